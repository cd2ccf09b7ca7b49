"""Block ``estimator`` of the robot file."""

from __future__ import annotations

from dataclasses import dataclass

from mecanum_base.core.parameter import parameter


@dataclass(frozen=True, slots=True, eq=False)
class EstimatorConfig:
    """Settings of the estimator; the defaults suit hobby to industrial bases."""

    reorder_wait: float = parameter(
        'float', 's', 'how long a sample may be late behind the newest stamp of any stream',
        default=0.02, low=0.0, high=1.0)
    min_rate: float = parameter(
        'float', 'Hz', 'rate of predicted odometry while the encoders are silent (data time)',
        default=20.0, low=0.1, high=1000.0)
    gyro_noise: float = parameter(
        'float', 'rad/s/rtHz', 'white noise of the gyro; more is learnt from its own readings',
        default=2.8e-4, low=0.0, open_low=True)
    accel_noise: float = parameter(
        'float', 'm/s^2/rtHz', 'white noise of the accelerometer; more is learnt from readings',
        default=2.5e-3, low=0.0, open_low=True)
    gyro_bias_sigma: float = parameter(
        'float', 'rad/s', 'gyro bias before the first standstill', default=0.03, low=0.0,
        open_low=True)
    accel_bias_sigma: float = parameter(
        'float', 'm/s^2', 'accelerometer bias and gravity leak before the first standstill',
        default=0.5, low=0.0, open_low=True)
    creep: float = parameter(
        'float', '', 'slip of a gripping wheel over its speed, for each unit of traction over '
        'load; 0 = none', default=0.05, low=0.0, high=1.0)
    gyro_scale_sigma: float = parameter(
        'float', '', 'scale error of the gyro', default=0.006, low=0.0, open_low=True)
    accel_scale_sigma: float = parameter(
        'float', '', 'scale error of the accelerometer', default=0.01, low=0.0, open_low=True)
    radius_sigma: float = parameter(
        'float', '', 'relative error of all wheel radii together', default=0.0035, low=0.0,
        open_low=True)
    wheel_sigma: float = parameter(
        'float', '', 'relative error of each radius against the others', default=0.002, low=0.0,
        open_low=True)
    lateral_sigma: float = parameter(
        'float', '', 'relative error of sideways against forward travel', default=0.003, low=0.0,
        open_low=True)
    roller_sigma: float = parameter(
        'float', '', 'the same of each wheel against the others: of rollers at 45 degrees twice '
        'the error of their angle in rad', default=0.003, low=0.0, open_low=True)
    lever_sigma: float = parameter(
        'float', '', 'relative error of the wheel lever arms in rotation', default=0.006, low=0.0,
        open_low=True)
