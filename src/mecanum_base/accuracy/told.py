"""What an estimator would be told that knows how well the simulated robots are built.

A covariance can only be as large as errors are if the robots are drawn as it assumes. The
defaults of block ``estimator`` are those of a tape measure; block ``sim`` draws better robots.
Here its standard deviations become those of the estimator. Radii and the IMU have theirs by name;
those of a wheel's position (x, y) and roller angle act through the rows A of the wheel law. Of the
lateral column each wheel has a relative error of its own, and none is shared; what they have in
common of the lever column, by least squares, is its relative error:

    sigma(lateral)^2 = mean_i (dA_i2 / A_i2)^2        wheels with A_i2 only
    k_lever = sum_i A_i3 dA_i3 / sum_i A_i3^2,    sigma(k)^2 = sum over wheels and parameters

What wheels do not have in common of their levers has no state in the estimator and stays out.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from mecanum_base.core.estimation.geometry import travel_per_radian
from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.robot import Robot
from mecanum_base.sim.imu_presets import PRESETS

LEAST = 1e-6  # a standard deviation of 0 is no prior
STEP = 1e-6  # m, rad: of the differences that stand for derivatives


def told(robot: Robot) -> EstimatorConfig:
    """Block ``estimator`` of this robot with the standard deviations by which ``sim`` draws it,
    all of them relative (no unit).

    Raises TypeError for carriers: their rows have no rollers.
    """
    base, sim = robot.base, robot.sim
    if not isinstance(base, Wheels):
        raise TypeError(f'fixed wheels are needed, not {type(base).__name__}')
    weight = travel_per_radian(base)[:, None]
    nominal = weight * wheels_from_body(base)
    lever, side = 0.0, np.zeros(base.count)
    across = np.abs(nominal[:, 1]) > STEP
    for name, sigma in (('x', sim.position_error), ('y', sim.position_error),
                        ('roller', sim.roller_error)):
        values = getattr(base, name)
        moved = dataclasses.replace(base, **{name: values + STEP})
        change = (weight * wheels_from_body(moved) - nominal) / STEP
        share = nominal[:, 2] * change[:, 2] / (nominal[:, 2] ** 2).sum()
        lever += float(((share * sigma) ** 2).sum())
        side[across] += (sigma * change[across, 1] / nominal[across, 1]) ** 2
    errors = PRESETS[sim.imu_preset]
    found = {
        'radius_sigma': sim.common_radius_error, 'wheel_sigma': sim.radius_error,
        'lateral_sigma': 0.0, 'roller_sigma': float(np.sqrt(side[across].mean())),
        'lever_sigma': float(np.sqrt(lever)),
        'gyro_scale_sigma': errors.gyro_sensitivity_error * sim.imu_error_scale,
        'accel_scale_sigma': errors.accel_sensitivity_error * sim.imu_error_scale}
    return dataclasses.replace(robot.estimator,
                               **{key: max(value, LEAST) for key, value in found.items()})
