"""The methods compared with ours, on a motion without noise or slip."""

import dataclasses
import math

import numpy as np
import pytest

from mecanum_base.accuracy.oracle import TOLD, Oracle, oracle_track
from mecanum_base.accuracy.track import Readings, readings_of, wheel_track
from mecanum_base.accuracy.trial import nees
from mecanum_base.accuracy.twist_filter import twist_filter_track
from mecanum_base.core import se2
from mecanum_base.core.estimation.geometry import rolling_rows, travel_per_radian
from mecanum_base.core.records import ImuSample, WheelSample
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.headless import Run

BIAS = 0.01  # rad/s
TWIST = np.array([0.4, -0.3, 0.5])
SECONDS = 8.0
FRAMES, IMUS = 100, 200  # Hz


@pytest.fixture(scope='module')
def robot():
    """Encoders that resolve a micrometre, so that nothing but the method is tested."""
    shipped_robot = load_robot(shipped() / 'mecanum4.yaml')
    return shipped_robot.replace(encoder=dataclasses.replace(
        shipped_robot.encoder, counts_per_revolution=1e6))


def eased(t):
    """Share of TWIST at time t: 0 for a second, then up within another, smoothly; and integral.

    The twist keeps its direction, so that the pose is exactly exp(TWIST x integral).
    """
    u = np.clip(t - 1.0, 0.0, 1.0)
    share = u * u * (3.0 - 2.0 * u)
    return share, u**3 - 0.5 * u**4 + np.maximum(t - 2.0, 0.0)


@pytest.fixture(scope='module')
def motion(robot):
    """One second of rest, then a motion without noise or slip: (run, samples)."""
    rates = rolling_rows(robot.base) @ TWIST / travel_per_radian(robot.base)
    x, y = robot.imu.xyz[:2]
    vx, vy, wz = TWIST
    samples = []
    for k in range(round((1.0 + SECONDS) * IMUS) + 1):
        t, dt = k / IMUS, 1.0 / IMUS
        mean = (eased(t)[1] - eased(t - dt)[1]) * IMUS  # a sample is the mean since the last
        growth = (eased(t)[0] - eased(t - dt)[0]) * IMUS
        w, turn = wz * mean, wz * growth
        accel = [vx * growth - w * vy * mean - turn * y - w * w * x,
                 vy * growth + w * vx * mean + turn * x - w * w * y, 9.81]
        samples.append(ImuSample(round(t * 1e9), np.array([0.0, 0.0, w + BIAS]),
                                 np.array(accel)))
        if k % 2 == 0:
            samples.append(WheelSample(round(t * 1e9), rates * eased(t)[1], np.full(4, np.nan)))
    stamps = np.arange(round((1.0 + SECONDS) * FRAMES) + 1) * (10**9 // FRAMES)
    share, driven = eased(stamps * 1e-9)
    run = Run(robot.base.joint, 1, 0, int(stamps[-1]), (), (), stamps,
              np.array([se2.exp(TWIST * d) for d in driven]), TWIST * share[:, None],
              np.zeros((len(stamps), 4)), np.zeros((len(stamps), 4)))
    return run, samples


def test_the_readings_carry_travel_and_an_unbiased_gyro_at_the_base(robot, motion):
    run, samples = motion
    readings = readings_of(run, robot, samples)
    assert isinstance(readings, Readings)
    assert readings.raw_gyro - readings.gyro == pytest.approx(BIAS)
    expected = rolling_rows(robot.base) @ TWIST * (SECONDS - 0.5)
    assert readings.travel[-1] == pytest.approx(expected, abs=1e-9)
    # the lever arm is removed: what is left is w x v
    assert readings.accel[-10] == pytest.approx([0.5 * 0.3, 0.5 * 0.4], abs=1e-9)


def test_the_twist_filter_tracks_a_constant_twist(robot, motion):
    run, samples = motion
    readings = readings_of(run, robot, samples)
    track = twist_filter_track(readings, rolling_rows(robot.base))
    # it trails the growing speed by some frames: under 1 cm and 10 mrad
    assert track.pose[-1] == pytest.approx(run.pose[-1], abs=0.01)
    late = track.stamp_ns > 3_000_000_000
    start = int(np.argmax(late))
    moved = se2.compose(se2.inverse(track.pose[start]), track.pose[-1])
    wanted = se2.compose(se2.inverse(run.pose[start]), run.pose[-1])
    # as ekf_node it moves along the heading at the start of each step of 5 ms:
    # 0.5 rad/s x 2.5 ms over 3 m are 3.8 mm
    assert moved == pytest.approx(wanted, abs=4e-3)


def test_dead_reckoning_is_exact_without_noise(robot, motion):
    run, samples = motion
    readings = readings_of(run, robot, samples)
    for gyro_heading in (False, True):
        track = wheel_track(readings, robot, gyro_heading=gyro_heading)
        # what is left: the gyro's own sampling at the jump, half an IMU period of 0.5 rad/s
        assert track.pose[-1] == pytest.approx(run.pose[-1], abs=3e-3)


@pytest.mark.parametrize('told', TOLD)
def test_the_oracle_follows_a_motion_without_slip(robot, motion, told):
    run, samples = motion
    readings = readings_of(run, robot, samples)
    track = oracle_track(readings, robot, run, told)
    assert track.pose[-1] == pytest.approx(run.pose[-1], abs=0.01)


@pytest.mark.parametrize('told', TOLD)
def test_true_slip_told_to_the_oracle_costs_it_next_to_nothing(robot, motion, told):
    run, samples = motion
    run, samples, slid = _slipping(run, samples)
    readings = readings_of(run, robot, samples)
    track = oracle_track(readings, robot, run, told)
    # 0.5 m of false travel on two wheels; 2 cm is what the accelerometer's start-up doubt leaves
    assert np.max(np.abs(slid)) * 0.035 > 0.5
    assert track.pose[-1, :2] == pytest.approx(run.pose[-1, :2], abs=0.02)
    wheels = wheel_track(readings, robot, gyro_heading=True)
    assert np.hypot(*(wheels.pose[-1] - run.pose[-1])[:2]) > 0.2


def test_an_unknown_kind_of_oracle_is_refused(robot):
    with pytest.raises(ValueError, match='told must be one of'):
        Oracle(robot, 'nothing')


def test_nees_of_a_known_error():
    error = np.array([[1.0, 2.0], [0.0, 3.0]])
    covariance = np.array([[[1.0, 0.0], [0.0, 4.0]], [[2.0, 1.0], [1.0, 2.0]]])
    # the second inverse is [[2, -1], [-1, 2]]/3
    assert nees(error, covariance) == pytest.approx([1.0 + 1.0, 9.0 * 2.0 / 3.0])


def _slipping(run, samples):
    """Both wheels of one diagonal spin 16 rad/s too fast for one second (angle slid: 16 rad)."""
    slid = np.zeros_like(run.slip_angle)
    rate = np.zeros_like(slid)
    seconds = run.stamp_ns * 1e-9
    for wheel in (0, 3):
        slid[:, wheel] = 16.0 * np.clip(seconds - 4.0, 0.0, 1.0)
        rate[:, wheel] = 16.0 * ((seconds > 4.0) & (seconds <= 5.0))
    turned = dict(zip(run.stamp_ns.tolist(), slid))
    told = [dataclasses.replace(s, position=s.position + turned[s.stamp_ns])
            if isinstance(s, WheelSample) else s for s in samples]
    assert math.isclose(float(slid[-1, 0]), 16.0)
    return dataclasses.replace(run, slip_angle=slid, slip_rate=rate), told, slid
