"""Where the estimator ends after known motions, on which sensors and wheels it can do so."""

import functools
import math

import numpy as np
import pytest
from staged_drive import (
    COUNTS,
    LEVER,
    LY,
    RADIUS,
    RECTANGLE,
    T0,
    drive,
    estimator,
    frames,
    imu,
    is_sound,
    merged,
    miss,
    rectangle,
    run,
    staged,
    wheel_angles,
)

from mecanum_base.core.estimation.layout import KL, LEAN_REST, K
from mecanum_base.core.estimation.odometry import WheelOdometry
from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.records import TickSample, WheelSample

REST = (0.9, (0.0, 0.0, 0.0))
STOP = (0.7, (0.0, 0.0, 0.0))
ARC = staged(REST, (2.5, (0.5, 0.2, 0.8)), STOP)


@functools.cache
def arc():
    return drive(ARC)


# 1.5 m of way on encoders of 77 um: half a degree of yaw and 5 mm are three times what the noise
# of the IMU (2 mrad/s, 0.03 m/s^2) was found to leave
@pytest.mark.parametrize('twist', [(0.6, 0, 0), (0, 0.5, 0), (0, 0, 1.2), (0.5, 0.2, 0.8)],
                         ids=['straight', 'strafe', 'spin', 'arc'])
def test_the_end_of_a_motion_is_met_within_five_millimetres_and_a_third_of_a_degree(twist):
    motion = staged(REST, (2.5, twist), STOP)
    subject, found = drive(motion)
    away, turned = miss(found[-1], motion)
    assert away < 0.005
    assert turned < math.radians(0.33)
    assert all(map(is_sound, found))
    assert subject.episodes == ()
    assert max(estimate.slip.body_probability for estimate in found) < 0.5


def test_the_twist_is_that_of_the_body_all_the_way():
    _, found = arc()
    for estimate in found[::10]:
        truth = ARC.twist[(estimate.stamp_ns - T0) // 1_000_000]
        # 2 mrad/s rms of gyro noise, 0.03 m/s: the creep that ramps of 1.5 m/s^2 may hide
        assert estimate.twist[:2] == pytest.approx(truth[:2], abs=0.03)
        assert estimate.twist[2] == pytest.approx(truth[2], abs=0.012)


def test_biases_of_both_sensors_are_learnt_at_rest_and_removed_in_the_drive():
    motion = staged((3.0, (0, 0, 0)), (2.0, (0.5, 0.2, 0.8)), (1.3, (0, 0, 0)))
    subject, found = drive(motion, gyro_bias=0.02, accel_bias=(0.15, -0.1))
    away, turned = miss(found[-1], motion)
    assert away < 0.006
    assert turned < math.radians(0.4)  # the bias alone would be 7 degrees over 6.3 s
    health = subject.health
    assert health.gyro_bias == pytest.approx(0.02, abs=4 * health.gyro_bias_sigma)
    assert health.gyro_bias_sigma < 0.001
    assert health.accel_bias == pytest.approx((0.15, -0.1), abs=0.03)
    assert health.standstill
    assert health.imu == 'gyro + accelerometer'


def test_an_imu_mounted_askew_and_off_centre_gives_the_track_of_one_at_the_centre():
    _, centre = drive(ARC, noise=0.0)
    _, askew = drive(ARC, noise=0.0, xyz=(0.12, -0.08, 0.1), rpy=(0.3, -0.2, 1.1))
    # trapezoids of 5 ms see the lever arm's acceleration to 1e-3 of itself
    for a, b in zip(centre[::20], askew[::20]):
        assert b.pose == pytest.approx(a.pose, abs=5e-4)


def test_without_an_imu_the_wheels_carry_on_and_the_notes_say_so():
    subject = estimator()
    found = run(subject, frames(ARC, wheel_angles(ARC)))
    assert miss(found[-1], ARC)[0] < 0.005
    assert miss(found[-1], ARC)[1] < math.radians(0.33)
    assert subject.health.imu == 'none'
    assert any(note.startswith('no IMU') for note in subject.health.notes)


def test_a_gyro_alone_is_used_and_the_missing_accelerometer_is_named():
    subject, found = drive(ARC, accel=False)
    assert miss(found[-1], ARC)[0] < 0.005
    assert subject.health.imu == 'gyro'
    assert any('no accelerometer' in note for note in subject.health.notes)


def test_six_wheels_meet_the_end_and_need_no_word_on_redundancy():
    middle = np.array([[1, -1, -LY], [1, 1, LY]]) / RADIUS  # lever of the middle row: lx = 0
    subject, found = drive(ARC, base=rectangle(6),
                           rows=np.vstack([RECTANGLE[:2], middle, RECTANGLE[2:]]))
    assert miss(found[-1], ARC)[0] < 0.005
    assert found[-1].slip.probability.shape == (6,)
    assert not any('wheels leave' in note for note in subject.health.notes)


def test_three_omni_wheels_meet_the_end_and_say_that_they_have_no_redundancy():
    bearing = np.radians([60.0, 180.0, 300.0])
    base = Wheels(joint=('a', 'b', 'c'), x=0.2 * np.cos(bearing), y=0.2 * np.sin(bearing),
                  axle=bearing, roller=[math.pi / 2] * 3, radius=[RADIUS] * 3,
                  max_speed=[40.0] * 3)
    # right hand about the outward axle: the contact point is driven along the tangent, backwards
    rows = np.column_stack([np.sin(bearing), -np.cos(bearing), np.full(3, -0.2)]) / RADIUS
    subject, found = drive(ARC, base=base, rows=rows)
    assert miss(found[-1], ARC)[0] < 0.006
    assert any('3 wheels leave no redundancy' in note for note in subject.health.notes)


def test_a_platform_on_two_carriers_drives_straight_on_its_four_plain_wheels():
    base = Carriers(name=('front', 'rear'), x=[0.3, -0.3], y=[0.0, 0.0],
                    axle_offset=[-0.1, -0.1], half_track=[0.12, 0.12], wheel_radius=[0.05, 0.05],
                    left_joint=('a', 'c'), right_joint=('b', 'd'), max_speed=[40.0, 40.0])
    motion = staged(REST, (2.0, (0.4, 0.0, 0.0)), STOP)
    rows = np.array([[1.0, 0.0, 0.0]] * 4) / 0.05  # straight on, no carrier steers
    subject, found = drive(motion, base=base, rows=rows)
    assert miss(found[-1], motion)[0] < 0.008
    assert all(map(is_sound, found))


@pytest.mark.parametrize(('bits', 'start'), [(16, 65_000), (32, (1 << 31) - 900)])
def test_counters_that_wrap_in_mid_drive_leave_no_trace(bits, start):
    unit = 2.0 * math.pi / 4096.0
    counts = np.floor(wheel_angles(ARC) / unit + 0.5).astype(np.int64)
    low = 0 if start > 40_000 and bits == 16 else -(1 << bits - 1)
    shown = (counts + start - low) % (1 << bits) + low
    assert (np.abs(np.diff(shown, axis=0)) > 1000).any()  # it does wrap
    ticks = [TickSample(T0 + k * 1_000_000, shown[k]) for k in range(0, len(shown), 10)]
    _, plain = arc()
    config = EncoderConfig(source='wheel_ticks', counts_per_revolution=4096.0, counter_bits=bits)
    found = run(estimator(encoder=config), merged(imu(ARC), ticks))
    # sums of angles round differently: 1e-9 rad
    assert found[-1].pose == pytest.approx(plain[-1].pose, abs=1e-9)


def test_speeds_in_place_of_positions_give_a_coarser_track_and_a_note():
    rates = ARC.twist @ RECTANGLE.T
    blank = np.full(4, math.nan)
    samples = [WheelSample(T0 + k * 1_000_000, blank, rates[k]) for k in range(0, len(rates), 10)]
    subject = estimator()
    found = run(subject, merged(imu(ARC), samples))
    # each speed stands for the 10 ms before it: ramps end 3 mm off, and doubt is added
    assert miss(found[-1], ARC)[0] < 0.03
    assert any('wheel speeds stand in for positions' in note for note in subject.health.notes)


def test_every_encoder_sample_after_the_first_has_one_estimate_of_its_own_stamp():
    samples = frames(ARC, wheel_angles(ARC))
    _, found = arc()
    own = [estimate.stamp_ns for estimate in found if estimate.source == 'encoder']
    assert own == [sample.stamp_ns for sample in samples[1:]]


@pytest.mark.parametrize('seed', range(2))
def test_the_order_of_arrival_within_the_wait_changes_no_bit(seed):
    motion = staged((0.2, (0, 0, 0)), (0.8, (0.5, 0.2, 0.8)))
    samples = merged(imu(motion), frames(motion, wheel_angles(motion)))
    random = np.random.default_rng(seed)
    arrival = [s.stamp_ns + random.uniform(0.0, 19e6) for s in samples]
    shuffled = [samples[k] for k in np.argsort(arrival)]
    one, two = run(estimator(), samples), run(estimator(), shuffled)
    assert [e.stamp_ns for e in one] == [e.stamp_ns for e in two]
    for a, b in zip(one, two):
        for name in ('pose', 'pose_covariance', 'twist', 'twist_covariance'):
            assert getattr(a, name).tobytes() == getattr(b, name).tobytes()
        assert a.slip.rate.tobytes() == b.slip.rate.tobytes()
        assert a.slip.probability.tobytes() == b.slip.probability.tobytes()


def test_without_an_imu_scales_are_not_learnt_but_stay_doubtful():
    # one radius is 1 % off: four wheels without a gyro cannot tell that from a lever or from slip
    motion = staged((0.6, (0, 0, 0)), (4.0, (0.4, 0.2, 0.0)), (4.0, (0.0, 0.4, 0.5)))
    angles = wheel_angles(motion)
    angles[:, 1] *= 1.01
    subject = estimator()
    model, memory = subject._filter.model, subject._filter.memory
    before = memory.x.copy(), memory.P.copy()
    run(subject, frames(motion, angles))
    w = model.wheels
    scales = [KL, *range(K, K + w), *range(K + 3 * w, K + 4 * w)]
    assert np.array_equal(memory.x[scales], before[0][scales])
    assert np.allclose(memory.P[np.ix_(scales, scales)], before[1][np.ix_(scales, scales)],
                       rtol=1e-12, atol=0.0)


def test_without_an_imu_the_track_is_that_of_least_squares_whatever_the_radii():
    motion = staged((0.6, (0, 0, 0)), (4.0, (0.4, 0.2, 0.0)), (4.0, (0.0, 0.4, 0.5)),
                    (4.0, (-0.4, 0.0, -0.3)))
    angles = wheel_angles(motion) * np.array([1.004, 0.996, 1.0, 0.998])
    least_squares = WheelOdometry(rectangle(), EncoderConfig(counts_per_revolution=COUNTS))
    samples = frames(motion, angles)
    pose = [least_squares.handle(sample) for sample in samples][-1]
    found = run(estimator(), samples)
    # ten counts of travel over 4.6 m; wheels weighed by what is known of their radii, or a pose
    # that does not go along with a change of speed within a frame, lead several mm elsewhere
    assert np.hypot(*(found[-1].pose - pose)[:2]) < 8e-4
    assert abs(found[-1].pose[2] - pose[2]) < 6e-4


def test_without_an_imu_a_hard_change_of_speed_is_no_slip():
    # 1.7 m/s^2 at its peak; every change of speed is a correction by the wheels here, and their
    # sum over a quarter of a second is no sign that something was hidden
    motion = staged((0.6, (0, 0, 0)), (2.0, (0.0, 0.4, 0.5)), (2.0, (-0.4, 0.0, -0.3)))
    subject = estimator()
    found = run(subject, frames(motion, wheel_angles(motion)))
    assert subject.episodes == ()
    assert max(e.slip.body_probability for e in found) < 0.5
    assert miss(found[-1], motion)[0] < 0.005


@pytest.mark.parametrize('speed', [(0.5, 0.0, 0.0), (0.0, 0.5, 0.0)], ids=['ahead', 'sideways'])
def test_without_an_imu_the_pose_carries_the_doubt_of_the_scales(speed):
    motion = staged((0.6, (0, 0, 0)), (8.0, speed), (2.0, (0, 0, 0)))
    end = run(estimator(), frames(motion, wheel_angles(motion)))[-1]
    tuning = EstimatorConfig()
    # by hand: along a straight way L all radii together and the mean of four count, sideways the
    # lateral scales too; across it yaw from what each wheel errs by, sigma_w L/(2 lever), half of
    # it times L
    sideways = speed[1] > 0
    each = math.hypot(tuning.wheel_sigma, tuning.roller_sigma * sideways)
    shared = math.hypot(tuning.radius_sigma, tuning.lateral_sigma * sideways)
    along = math.hypot(shared, each / 2) * motion.path
    turned = each * motion.path / (2 * LEVER)
    first, second = (0, 1) if speed[0] > 0 else (1, 0)
    sigma = np.sqrt(end.pose_covariance.diagonal())
    # noise of rolling comes on top: 1.5 mm per root metre and wheel, a tenth of all this; the
    # averages that scales are multiplied with end within 2 % of the way
    assert 0.98 * along < sigma[first] < 1.1 * along
    assert 0.98 * turned < sigma[2] < 1.1 * turned
    assert (0.95 * turned * motion.path / 2 < sigma[second]
            < 1.15 * turned * motion.path / 2)


def test_a_base_whose_motors_hold_it_on_a_slope_learns_its_biases_although_its_wheels_creep():
    standing = staged((3.0, (0.0, 0.0, 0.0)))
    creep = 0.015  # rad/s: 0.75 mm/s, 10 counts a second
    angles = wheel_angles(standing, slip={1: (0.0, 3.1, creep), 2: (0.0, 3.1, -creep)})
    subject = estimator()
    run(subject, merged(imu(standing), frames(standing, angles)))
    assert subject._filter.memory.m[LEAN_REST] > 0.1  # s of rest that gyro x and y have learnt
