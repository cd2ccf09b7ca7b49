"""Tilt of the base: gravity that turns with it, followed by the gyro's x and y axes."""

import math

import numpy as np
import pytest
from staged_drive import (
    GRAVITY,
    RECTANGLE,
    T0,
    at_start,
    estimator,
    frames,
    imu,
    merged,
    run,
    staged,
    summed,
)

from mecanum_base.core.estimation.layout import (
    BAX,
    BAY,
    BSX,
    HAVE_GYRO,
    LEAN_GAIN,
    LEAN_REST,
    LEAN_X,
    LEAN_XZ,
    LEAN_Y,
    LEAN_YZ,
    LEAN_ZZ,
    TREMOR,
    WZ,
)
from mecanum_base.core.estimation.lean import follow, turn_offset, wander

RAMP = math.radians(4.0)
UP, LEVEL = 3.0, 4.0  # s: the nose goes down from here to there
DRIVE = staged((1.5, (0.0, 0.0, 0.0)), (4.0, (0.4, 0.0, 0.0)))


@pytest.fixture
def parts():
    return at_start()


def ramp_readings(measured):
    """IMU of a drive down a ramp; about y the base turns by RAMP between UP and LEVEL."""
    readings = imu(DRIVE)
    for reading in readings:
        t = (reading.stamp_ns - T0) * 1e-9
        pitch = float(np.interp(t, [UP, LEVEL], [0.0, RAMP]))
        reading.accel[0] -= GRAVITY * math.sin(pitch)  # nose down: gravity pulls forward
        if measured and UP <= t < LEVEL:
            reading.gyro[1] += RAMP / (LEVEL - UP)
        if not measured:
            reading.gyro[:2] = 0.0  # as an IMU with one gyro axis reports it
    return readings


@pytest.mark.parametrize(('measured', 'least', 'most'), [(True, 0.0, 0.06), (False, 0.25, 9.0)])
def test_without_wheels_a_ramp_is_told_from_braking_by_the_pitch_rate_alone(measured, least, most):
    angles = summed(DRIVE.twist @ RECTANGLE.T)
    heard = [f for f in frames(DRIVE, angles) if f.stamp_ns < T0 + UP * 1e9]
    last = heard[-1].stamp_ns
    found = run(estimator(), merged(ramp_readings(measured), heard))
    # by hand: g * 0.07 rad over 1 s of ramp and 1.5 s after it, unseen: 1.2 m
    moved = found[-1].pose[0] - DRIVE.pose[round((last - T0) / 1e6), 0]
    wanted = DRIVE.pose[-1, 0] - DRIVE.pose[round((last - T0) / 1e6), 0]
    assert least <= abs(moved - wanted) < most


def test_the_offset_of_a_tilted_base_turns_with_it_and_that_of_the_sensor_does_not(parts):
    _, memory = parts
    memory.x[BAX], memory.x[BSX] = 0.5, 0.2
    for _ in range(9000):
        turn_offset(memory, 0.5 * math.pi / 9000)
    # tilt 0.3 along x is seen along -y after a quarter turn to the left; 1e-4: steps of 0.01 deg
    assert memory.x[[BAX, BAY]] == pytest.approx([0.2, -0.3], abs=1e-4)


def test_the_share_of_the_yaw_rate_in_the_other_axes_is_learnt(parts):
    model, memory = parts
    memory.m[LEAN_REST] = memory.m[HAVE_GYRO] = memory.m[WZ] = 1.0
    for _ in range(4000):
        follow(memory, 0.012, -0.02, 0.005)
        wander(model, memory)
    # least squares with a prior of 0 +- 0.015, worth 0.07 s of this turn against 20 s
    assert memory.m[LEAN_XZ] / memory.m[LEAN_ZZ] == pytest.approx(0.012, rel=0.01)
    assert memory.m[LEAN_YZ] / memory.m[LEAN_ZZ] == pytest.approx(-0.02, rel=0.01)


@pytest.mark.parametrize('rates', [(0.0, 0.0), (math.nan, 0.1), (math.inf, 0.1), (500.0, 0.0)])
def test_axes_that_are_silent_or_absurd_are_not_followed(parts, rates):
    model, memory = parts
    memory.m[LEAN_REST] = memory.m[HAVE_GYRO] = memory.m[LEAN_GAIN] = 1.0
    follow(memory, *rates, 0.005)
    assert memory.x[BAX] == memory.x[BAY] == 0.0
    assert wander(model, memory) == model.accel_drift ** 2
    assert memory.m[LEAN_GAIN] == 0.0


def test_before_the_first_rest_the_axes_are_hardly_believed_and_afterwards_they_are(parts):
    model, memory = parts
    memory.m[HAVE_GYRO] = 1.0
    follow(memory, 0.01, 0.01, 0.005)
    wander(model, memory)
    before = float(memory.m[LEAN_GAIN])
    memory.m[LEAN_REST] = 2.0
    wander(model, memory)
    assert before < 0.02
    assert memory.m[LEAN_GAIN] > 0.9


def read_axes(model, memory, rates, seconds, dt=0.005):
    """Steady rates about x and y, read every ``dt``; the gain is set anew as often."""
    for _ in range(round(seconds / dt)):
        follow(memory, *rates, dt)
        wander(model, memory)


def turning(memory, tremor):
    """A base known from rest that turns at 1 rad/s under a trembling gyro [rad^2/s]."""
    memory.m[LEAN_REST] = 5.0
    memory.m[HAVE_GYRO] = memory.m[WZ] = 1.0
    memory.m[TREMOR] = tremor


@pytest.mark.parametrize(('rate', 'least', 'most'), [(0.3, 0.975, 1.02), (0.01, 0.0, 0.7)])
def test_the_edge_of_a_ramp_is_followed_whole_where_small_rates_are_not(parts, rate, least, most):
    """By hand: 0.06 rad of pitch are 0.59 m/s^2, whether it takes 0.2 s or 6 s."""
    model, memory = parts
    turning(memory, 1e-5)
    read_axes(model, memory, (0.0, 1e-4), 5.0)  # the leak of the yaw rate is known
    before = memory.x[BAX]
    read_axes(model, memory, (0.0, rate), 0.06 / rate)
    assert least < (before - memory.x[BAX]) / (9.80665 * 0.06) < most


def test_the_edge_of_a_ramp_teaches_nothing_of_the_leak(parts):
    model, memory = parts
    turning(memory, 1e-7)
    read_axes(model, memory, (0.0, 0.01), 5.0)
    before = memory.m[LEAN_YZ] / memory.m[LEAN_ZZ]
    read_axes(model, memory, (0.0, 0.31), 0.2)
    # by hand: least squares alone would move it by 0.3 * 0.2 s / 5.3 s = 0.011
    assert memory.m[LEAN_YZ] / memory.m[LEAN_ZZ] == pytest.approx(before, abs=0.002)


def test_a_leak_larger_than_believed_possible_is_learnt_all_the_same(parts):
    """0.1 is more than six standard deviations of what is assumed: there is a way back."""
    model, memory = parts
    turning(memory, 1e-7)
    read_axes(model, memory, (0.0, 0.1), 60.0)
    assert memory.m[LEAN_YZ] / memory.m[LEAN_ZZ] == pytest.approx(0.1, rel=0.1)


def test_one_reading_of_zero_does_not_make_the_axes_count_as_missing(parts):
    model, memory = parts
    memory.m[HAVE_GYRO] = 1.0
    follow(memory, 0.001, 0.0, 0.005)
    follow(memory, 0.0, 0.0, 0.005)
    wander(model, memory)
    assert memory.m[LEAN_GAIN] > 0.0
    for _ in range(25):
        follow(memory, 0.0, 0.0, 0.005)
    wander(model, memory)
    assert memory.m[LEAN_GAIN] == 0.0


def test_a_reading_of_zero_just_before_a_standstill_does_not_keep_the_offsets_unlearnt():
    drive = staged((2.0, (0.0, 0.0, 0.0)))
    readings = imu(drive)
    for reading in readings:
        reading.gyro[:2] += (0.012, -0.007)
        if reading.stamp_ns < T0 + 300_000_000:
            reading.gyro[:2] = 0.0
    subject = estimator()
    run(subject, merged(readings, frames(drive, summed(drive.twist @ RECTANGLE.T))))
    memory = subject._filter.memory
    # noise of 2 mrad/s over 340 readings
    assert memory.m[LEAN_REST] > 1.0
    assert memory.m[LEAN_X] == pytest.approx(0.012, abs=5e-4)
    assert memory.m[LEAN_Y] == pytest.approx(-0.007, abs=5e-4)
