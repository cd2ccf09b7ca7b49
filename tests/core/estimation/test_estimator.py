"""The estimator on scripted motions whose truth is known."""

import math
import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from motion import Drive, error, mecanum, parts, ramp, run, track

from mecanum_base.core.estimation.estimator import Estimator
from mecanum_base.core.estimation.odometry import WheelOdometry
from mecanum_base.core.records import (
    ImuSample,
    PoseSample,
    ResetSample,
    TickSample,
    WheelSample,
)


def lap(t):
    """Stand 1 s, then forward, sideways and a turn at the same time."""
    on = ramp(t, 1.0, 7.0)
    return (0.4 * on, 0.2 * on * math.sin(t), 0.4 * on)


def spin_of_front_left(t):
    """The front left wheel turns 6 rad/s too fast between 4.0 and 4.6 s."""
    return (6.0 if 4.0 <= t < 4.6 else 0.0, 0.0, 0.0, 0.0)


CLEAN = Drive(lap, 8.0)
SPUN = Drive(lap, 8.0, slip=spin_of_front_left)


def estimator(**tuning):
    return Estimator(*parts(**tuning))


def test_without_slip_the_track_follows_the_truth_to_millimetres():
    # 2.6 m of way; encoder steps of 27 um and 5 ms sampling of the gyro leave below 3 mm
    assert error(run(estimator(), CLEAN.samples), CLEAN) < 0.003


def test_every_encoder_sample_but_the_first_gives_one_estimate_with_its_stamp():
    found = [e for e in run(estimator(), CLEAN.samples) if e.source == 'encoder']
    frames = [s.stamp_ns for s in CLEAN.samples if isinstance(s, WheelSample)]
    assert [e.stamp_ns for e in found] == frames[1:]


def test_a_spinning_wheel_moves_wheel_odometry_by_decimetres_and_the_estimate_hardly():
    base, encoder, _, _ = parts()
    wheels = WheelOdometry(base, encoder)
    for s in SPUN.samples:
        if isinstance(s, WheelSample):
            wheels.handle(s)
    lost = math.hypot(*(wheels.pose[:2] - SPUN.pose[:2]))
    assert lost > 0.10
    assert error(run(estimator(), SPUN.samples), SPUN) < 0.1 * lost


def test_the_spinning_wheel_is_named_with_its_slip_rate_and_distance():
    own = estimator()
    found = run(own, SPUN.samples)
    during = [e for e in found if 4.1e9 < e.stamp_ns - 1e12 < 4.55e9]
    assert len(during) > 40
    for e in during:
        assert e.slip.body_probability > 0.9
        assert int(np.argmax(e.slip.probability)) == 0
        # 6 rad/s within 8 %: the creep the filter allows the other wheels
        assert e.slip.rate[0] == pytest.approx(6.0, rel=0.08)
    assert len(own.episodes) == 1
    episode = own.episodes[0]
    assert episode.kind == 'single'
    assert episode.wheels == (0,)
    assert (episode.start_ns - 1e12) / 1e9 == pytest.approx(4.0, abs=0.05)
    assert (episode.end_ns - 1e12) / 1e9 == pytest.approx(4.6, abs=0.1)
    # 0.6 s of 6 rad/s on a radius of 50 mm, along rollers at 45 degrees
    assert episode.distance == pytest.approx(0.6 * 6.0 * 0.05 * math.sin(math.pi / 4), rel=0.15)


def test_slip_is_not_claimed_where_there_is_none():
    own = estimator()
    found = run(own, CLEAN.samples)
    assert own.episodes == ()
    assert max(e.slip.body_probability for e in found) < 0.2


def test_tlales_coefficient_is_one_when_rolling_below_one_for_a_spinning_wheel_nan_at_rest():
    found = run(estimator(), SPUN.samples)

    def at(seconds):
        return min(found, key=lambda e: abs(e.stamp_ns - 1e12 - seconds * 1e9)).slip.ratio

    assert np.isnan(at(0.5)).all()
    assert at(3.5)[0] == pytest.approx(1.0, abs=0.02)
    assert at(4.55)[0] < 0.8
    assert at(4.55)[3] == pytest.approx(1.0, abs=0.05)


def test_a_robot_pushed_while_its_wheels_stand_is_followed_by_the_imu():
    def shove(t):
        return (0.6 * ramp(t, 2.0, 3.2, 0.4), 0.0, 0.0)

    def held(t):
        return -shove(t)[0] / 0.05 * np.ones(4)

    pushed = Drive(shove, 5.0, slip=held, noise=0.2)
    own = estimator()
    found = run(own, pushed.samples)
    assert pushed.pose[0] == pytest.approx(0.48, abs=0.01)
    assert error(found, pushed) < 0.06  # wheels alone say 0.48 m less
    assert [e.kind for e in own.episodes] == ['pushed']


def test_biases_are_learnt_while_standing():
    drive = Drive(lambda t: (0.0, 0.0, 0.0), 3.0, noise=1.0)
    biased = [ImuSample(s.stamp_ns, s.gyro + 0.02, s.accel + np.array([0.3, -0.2, 0.0]))
              if isinstance(s, ImuSample) else s for s in drive.samples]
    own = estimator()
    found = run(own, biased)
    health = own.health
    assert health.standstill
    assert health.gyro_bias == pytest.approx(0.02, abs=4 * health.gyro_bias_sigma)
    assert health.accel_bias == pytest.approx((0.3, -0.2), abs=0.05)
    assert np.abs(found[-1].pose).max() < 1e-3


def test_the_imu_mount_is_turned_and_its_lever_arm_corrected():
    base, encoder, _, tuning = parts()
    from mecanum_base.core.estimation.sensors import ImuConfig
    x, y = 0.3, -0.2
    yaw = 0.7
    mounted = []
    before, last = 0.0, None
    for s in CLEAN.samples:
        if isinstance(s, ImuSample):
            w = float(s.gyro[2])
            dw = 0.0 if last is None else (w - before) / ((s.stamp_ns - last) * 1e-9)
            before, last = w, s.stamp_ns
            at = s.accel + np.array([-w * w * x - dw * y, -w * w * y + dw * x, 0.0])
            c, k = math.cos(yaw), math.sin(yaw)
            mounted.append(ImuSample(s.stamp_ns, s.gyro, np.array([
                c * at[0] + k * at[1], -k * at[0] + c * at[1], at[2]])))
        else:
            mounted.append(s)
    own = Estimator(base, encoder, ImuConfig(xyz=(x, y, 0.0), rpy=(0.0, 0.0, yaw)), tuning)
    assert error(run(own, mounted), CLEAN) < 0.006


@pytest.mark.parametrize('accel, imu', [(True, True), (False, True), (True, False)])
def test_the_track_holds_with_fewer_sensors_and_says_what_is_missing(accel, imu):
    drive = Drive(lap, 6.0, accel=accel, imu=imu)
    own = estimator()
    assert error(run(own, drive.samples), drive) < 0.01
    text = ' '.join(own.health.notes)
    assert ('no IMU' in text) is (not imu)
    assert ('no accelerometer' in text) is (imu and not accel)
    assert 'constant common slip' in text


def test_ticks_and_positions_of_the_same_wheels_give_the_same_track():
    counts = [TickSample(s.stamp_ns, np.round(s.position * 8192 / (2 * math.pi)).astype(np.int64))
              if isinstance(s, WheelSample) else s for s in CLEAN.samples]
    one = track(run(estimator(), CLEAN.samples))[1]
    two = track(run(estimator(), counts))[1]
    assert two == pytest.approx(one, abs=1e-9)


def test_arrival_order_within_the_wait_changes_no_bit():
    rng = np.random.default_rng(3)
    late = sorted(SPUN.samples[:900], key=lambda s: s.stamp_ns + int(rng.integers(0, 19_000_000)))
    one, two = run(estimator(), SPUN.samples[:900]), run(estimator(), late)
    assert [e.stamp_ns for e in one] == [e.stamp_ns for e in two]
    for a, b in zip(one, two):
        assert np.array_equal(a.pose, b.pose)
        assert np.array_equal(a.slip.rate, b.slip.rate)


def test_silent_encoders_are_predicted_through_with_growing_covariance():
    kept = [s for s in CLEAN.samples
            if not (isinstance(s, WheelSample) and 3.0e9 < s.stamp_ns - 1e12 < 4.0e9)]
    found = run(estimator(), kept)
    gap = [e for e in found if 3.1e9 < e.stamp_ns - 1e12 < 4.0e9]
    assert {e.source for e in gap} == {'predicted'}
    assert len(gap) == pytest.approx(0.9 * 20, abs=2)  # min_rate is 20 Hz
    size = [np.trace(e.pose_covariance[:2, :2]) for e in gap]
    assert size == sorted(size)
    assert error(found, CLEAN) < 0.02


def test_a_given_pose_and_a_reset_are_applied_at_their_stamps():
    stamp = CLEAN.samples[-1].stamp_ns
    covariance = np.diag([0.01, 0.02, 0.03])
    own = estimator()
    run(own, CLEAN.samples)
    own.handle(PoseSample(stamp + 1, np.array([3.0, -1.0, 0.5]), covariance))
    placed = own.handle(WheelSample(stamp + 10_000_000, CLEAN.samples[-1].position
                                    if isinstance(CLEAN.samples[-1], WheelSample)
                                    else last_wheels(CLEAN), np.full(4, np.nan)))
    placed = [*placed, *own.flush()]
    assert placed[-1].pose == pytest.approx([3.0, -1.0, 0.5], abs=2e-3)
    assert np.diag(placed[-1].pose_covariance) == pytest.approx([0.01, 0.02, 0.03], rel=0.05)
    own.handle(ResetSample(stamp + 11_000_000))
    again = own.handle(WheelSample(stamp + 20_000_000, last_wheels(CLEAN), np.full(4, np.nan)))
    again = [*again, *own.flush()]
    assert again[-1].pose == pytest.approx([0.0, 0.0, 0.0], abs=2e-3)


def last_wheels(drive):
    return [s for s in drive.samples if isinstance(s, WheelSample)][-1].position


def test_a_restart_keeps_the_pose_and_forgets_the_certainty():
    own = estimator()
    before = run(own, CLEAN.samples)[-1]
    own.restart()
    found = run(own, Drive(lambda t: (0.0, 0.0, 0.0), 0.5).samples)  # stamps start over
    assert found[-1].pose == pytest.approx(before.pose, abs=2e-3)
    assert own.health.restarts == 1


def test_covariance_is_honest_over_many_noisy_runs():
    # e' P^-1 e of (x, y) has median 1.39 if P is right; a factor 3 either way is accepted
    nees = []
    for seed in range(8):
        drive = Drive(lap, 3.0, noise=1.0, seed=seed)
        rng = np.random.default_rng(1000 + seed)
        scale = 1.0 + 0.004 * rng.normal() + 0.003 * rng.normal(size=4)
        scaled = [WheelSample(s.stamp_ns, s.position * scale, s.velocity)
                  if isinstance(s, WheelSample) else s for s in drive.samples]
        last = run(estimator(), scaled)[-1]
        e = last.pose[:2] - drive.truth[-1, 1:3]
        nees.append(float(e @ np.linalg.solve(last.pose_covariance[:2, :2], e)))
    assert 1.39 / 4 < np.median(nees) < 1.39 * 3


def test_two_wheels_of_a_diagonal_are_seen_through_the_accelerometer():
    def slip(t):
        speed = 8.0 * ramp(t, 4.0, 4.8, 0.1)
        return (speed, 0.0, 0.0, speed)

    drive = Drive(lap, 8.0, slip=slip, noise=0.3)
    own = estimator()
    assert error(run(own, drive.samples), drive) < 0.03
    assert [(e.kind, e.wheels) for e in own.episodes] == [('diagonal', (0, 3))]


def test_three_wheels_are_enough_and_their_blindness_is_said():
    from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
    from mecanum_base.core.estimation.tuning import EstimatorConfig
    from mecanum_base.core.kinematics.wheels import Wheels
    bearing = np.radians([30.0, 150.0, 270.0])
    base = Wheels(('a', 'b', 'c'), 0.2 * np.cos(bearing), 0.2 * np.sin(bearing), bearing,
                  np.full(3, math.pi / 2), np.full(3, 0.05))
    own = Estimator(base, EncoderConfig(counts_per_revolution=4096.0), ImuConfig(),
                    EstimatorConfig())
    # positive rate is right-handed about the outward axle: the rim drives along -tangent
    tangent = np.column_stack([-np.sin(bearing), np.cos(bearing), np.full(3, 0.2)])
    rates = -tangent @ np.array([0.3, 0.1, 0.2]) / 0.05
    found = []
    for k in range(400):
        found += own.handle(WheelSample(10**9 + k * 10_000_000, rates * k * 0.01,
                                        np.full(3, np.nan)))
    found += own.flush()
    w, t = 0.2, 3.99
    exact = np.array([math.sin(w * t) * 0.3 - (1 - math.cos(w * t)) * 0.1,
                      (1 - math.cos(w * t)) * 0.3 + math.sin(w * t) * 0.1]) / w
    assert found[-1].pose[:2] == pytest.approx(exact, abs=0.01)
    assert any('slip cannot be seen at all' in note for note in own.health.notes)


def test_rejected_messages_are_counted_by_stream_and_reason():
    own = estimator()
    own.reject('joint_states', 'joint named twice')
    run(own, CLEAN.samples[:50])
    own.handle(CLEAN.samples[0])
    health = own.health
    assert health.rejected[('joint_states', 'joint named twice')] == 1
    assert health.received['imu'] == sum(isinstance(s, ImuSample) for s in CLEAN.samples[:50]) + 1
    assert ('imu', 'late') in health.rejected


def test_the_base_of_the_tests_is_the_textbook_one():
    from motion import wheel_rates

    from mecanum_base.core.kinematics.matrix import wheels_from_body
    twist = np.array([0.3, -0.2, 0.5])
    assert wheels_from_body(mecanum()) @ twist == pytest.approx(wheel_rates(twist))
