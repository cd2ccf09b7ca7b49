"""The gyro scale of the robot file: what it divides, one by one and by columns."""

import dataclasses
import math

import numpy as np
import pytest
from staged_drive import estimator, frames, imu, merged, miss, run, staged, wheel_angles

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.estimation.layout import FRAME, IMU
from mecanum_base.core.estimation.sensors import ImuConfig
from mecanum_base.core.estimation.stretch import Stretch, take
from mecanum_base.core.parameter import read_section
from mecanum_base.core.records import ImuSample

TURNS = staged((1.0, (0.0, 0.0, 0.0)), (4.0, (0.2, 0.1, 0.9)), (0.5, (0.0, 0.0, 0.0)))
ASKEW = (0.3, -0.2, 1.1)


def samples(gain, rpy=(0.0, 0.0, 0.0), wheels=True):
    """Both sensors of TURNS, the gyro reading ``gain`` times too much (noise included)."""
    scaled = [dataclasses.replace(s, gyro=s.gyro * gain)
              for s in imu(TURNS, rpy=rpy)]
    return merged(scaled, frames(TURNS, wheel_angles(TURNS))) if wheels else scaled


def test_a_gyro_that_reads_double_gives_the_bits_of_one_that_reads_right():
    right = run(estimator(), samples(1.0))
    double = run(estimator(imu=ImuConfig(gyro_scale=2.0)), samples(2.0))  # exact in binary
    assert len(right) == len(double) > 400
    for a, b in zip(right, double):
        assert a.pose.tobytes() == b.pose.tobytes()
        assert a.twist.tobytes() == b.twist.tobytes()


def test_without_the_scale_the_same_readings_lead_astray():
    known = run(estimator(imu=ImuConfig(gyro_scale=1.04)), samples(1.04))
    unknown = run(estimator(), samples(1.04))
    # 3.5 rad turned; four percent of it are 0.14 rad, of which wheels that agree take the most
    assert miss(known[-1], TURNS)[1] < 0.01
    assert miss(unknown[-1], TURNS)[1] > 2.0 * miss(known[-1], TURNS)[1]


@pytest.mark.parametrize('rpy', [(0.0, 0.0, 0.0), ASKEW])
def test_one_by_one_and_by_columns_give_the_same_bits(rpy):
    mount = ImuConfig(rpy=rpy, gyro_scale=1.013)
    arrived = samples(1.013, rpy)
    single = run(estimator(imu=mount), arrived)
    kind = np.array([IMU if isinstance(s, ImuSample) else FRAME for s in arrived])
    index = np.where(kind == IMU, np.cumsum(kind == IMU), np.cumsum(kind == FRAME)) - 1
    of = [s for s in arrived if isinstance(s, ImuSample)]
    rest = [s for s in arrived if not isinstance(s, ImuSample)]
    rows = take(estimator(imu=mount), Stretch(
        kind, index, np.array([s.stamp_ns for s in of]), np.array([s.gyro for s in of]),
        np.array([s.accel for s in of]), np.array([s.stamp_ns for s in rest]),
        np.array([s.position for s in rest]), False), last=True)
    assert len(rows.table) == len(single)
    for row, estimate in zip(rows.table, single):
        assert row[:3].tobytes() == estimate.pose.tobytes()


def test_a_scale_that_is_another_unit_is_refused():
    with pytest.raises(ConfigError, match=r'imu\.gyro_scale = 57\.\d+: must be >= 0\.5 and <= 2'):
        read_section(ImuConfig, {'gyro_scale': math.degrees(1.0)}, 'imu')
