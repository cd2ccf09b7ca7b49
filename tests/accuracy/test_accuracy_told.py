"""What an estimator is told that knows how the simulated robots are drawn."""

import dataclasses
import math

import numpy as np
import pytest

from mecanum_base.accuracy.told import LEAST, told
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.imu_presets import PRESETS


def robot(**sim):
    found = load_robot(shipped() / 'mecanum4.yaml')
    base = dataclasses.replace(found.base, roller_count=np.zeros(4, dtype=int))  # rows by hand
    return dataclasses.replace(found, base=base, sim=dataclasses.replace(found.sim, **sim))


def test_radii_and_imu_are_known_by_name():
    found = told(robot(radius_error=0.003, common_radius_error=0.004, imu_preset='bno055',
                       imu_error_scale=2.0))
    assert (found.radius_sigma, found.wheel_sigma) == (0.004, 0.003)
    assert found.gyro_scale_sigma == 2.0 * PRESETS['bno055'].gyro_sensitivity_error
    assert found.accel_scale_sigma == 2.0 * PRESETS['bno055'].accel_sensitivity_error


def test_the_lever_follows_from_the_places_of_the_wheels():
    found = told(robot(position_error=0.002, roller_error=0.0))
    # by hand: x and y of 4 wheels, each 2 mm of a lever of 0.35 m: 2 sqrt(8)/4 mm of it
    assert found.lever_sigma == pytest.approx(0.002 * math.sqrt(8.0) / 4.0 / 0.35, rel=1e-4)
    assert found.roller_sigma == LEAST  # no wheel goes sideways by another way


def test_lateral_travel_and_lever_follow_from_the_roller_angles():
    found = told(robot(position_error=0.0, roller_error=0.01))
    # by hand: cot of 45 degrees changes by 2 d; the lever is |y| + |x| cot: 0.2 of 0.35 m changes
    assert found.roller_sigma == pytest.approx(0.01 * 2.0, rel=1e-4)
    assert found.lateral_sigma == LEAST  # each roller is drawn for itself
    assert found.lever_sigma == pytest.approx(0.01 * 2.0 / 2.0 * 0.2 / 0.35, rel=1e-4)


def test_everything_else_of_the_block_stays():
    before = robot()
    found = told(before)
    changed = {f.name for f in dataclasses.fields(found)
               if getattr(found, f.name) != getattr(before.estimator, f.name)}
    assert changed <= {'radius_sigma', 'wheel_sigma', 'lateral_sigma', 'roller_sigma',
                       'lever_sigma', 'gyro_scale_sigma', 'accel_scale_sigma'}


def test_carriers_have_no_rollers():
    with pytest.raises(TypeError, match='fixed wheels'):
        told(load_robot(shipped() / 'dual_differential.yaml'))
