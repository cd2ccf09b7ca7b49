"""The IMU: what the body feels, seen through a sensor with the errors of a datasheet.

    gyro  = Q( M_g (w + vibration) + b_g(t) + n_g )      M = (I + sensitivity, cross axis) R_mount
    accel = Q( M_a (f + vibration) + b_a(t) + n_a )      b(t) = turn-on bias + random walk

M_g is multiplied by the gyro scale of the robot file, whose hardware the simulator plays.
n is white with the noise density times sqrt(rate / 2), Q rounds to the LSB and clips at the range.
Lever arm, tilt and the low-pass filter act in the kernel, at the rate of the physics; a sample is
the mean since the last one, as converters that integrate report it. Samples are
taken in blocks of any length; how a run is cut into blocks does not change a bit of the result.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.sensors import ImuConfig
from mecanum_base.core.parameter import FloatArray
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.imu_presets import PRESETS
from mecanum_base.sim.randomness import stream


class _Triad:
    """Three axes of one kind with their errors."""

    def __init__(self, matrix: FloatArray, bias: FloatArray, walk: float, noise: float,
                 lsb: float, full: float, seed: int, name: str) -> None:
        self._matrix, self._start, self._walk, self._noise = matrix, bias, walk, noise
        self._lsb, self._full = lsb, full if full > 0.0 else math.inf
        self._seed, self._name = seed, name
        self.restart()

    def restart(self) -> None:
        self._bias = self._start[None, :]
        self._generator = stream(self._seed, self._name)

    def read(self, felt: FloatArray, shake: FloatArray) -> FloatArray:
        """Readings (N, 3) of felt vectors (N, 3); ``shake`` (N,): deviation of the vibration."""
        draw = self._generator.standard_normal((len(felt), 9))
        bias = np.cumsum(np.vstack([self._bias, self._walk * draw[:, :3]]), axis=0)
        self._bias = bias[-1:]
        felt = felt + shake[:, None] * draw[:, 6:]
        x, y, z = felt[:, :1], felt[:, 1:2], felt[:, 2:]
        m = self._matrix  # not a matrix product: its rounding depends on the length of the block
        values: FloatArray = m[:, 0] * x + m[:, 1] * y + m[:, 2] * z
        values += bias[1:] + self._noise * draw[:, 3:6]
        if self._lsb > 0.0:
            values = np.floor(values / self._lsb + 0.5) * self._lsb
        clipped: FloatArray = np.clip(values, -self._full, self._full)
        return clipped


class Inertial:
    """One IMU on its mount."""

    def __init__(self, mount: ImuConfig, config: SimConfig) -> None:
        errors, scale, seed = PRESETS[config.imu_preset], config.imu_error_scale, config.seed
        self.bandwidth = errors.bandwidth
        draw = stream(seed, 'imu errors')
        root = math.sqrt(config.imu_rate)
        tilt = draw.standard_normal(3) * config.mount_error
        wrong = np.array([[1.0, -tilt[2], tilt[1]], [tilt[2], 1.0, -tilt[0]],
                          [-tilt[1], tilt[0], 1.0]])
        left, _, right = np.linalg.svd(wrong)  # the nearest rotation
        sensor_from_base = (mount.base_from_sensor() @ (left @ right)).T
        triads = []
        for name, sensitivity, cross, bias, walk, density, lsb, full in (
                ('gyro', errors.gyro_sensitivity_error, errors.gyro_cross_axis,
                 errors.gyro_zero_rate, errors.gyro_bias_walk, errors.gyro_noise_density,
                 errors.gyro_lsb, errors.gyro_range),
                ('accel', errors.accel_sensitivity_error, errors.accel_cross_axis,
                 errors.accel_zero_g, errors.accel_bias_walk, errors.accel_noise_density,
                 errors.accel_lsb, errors.accel_range)):
            off = draw.standard_normal((3, 3)) * cross * scale
            off[np.diag_indices(3)] = draw.standard_normal(3) * sensitivity * scale
            start = draw.standard_normal(3) * bias * scale
            gain = mount.gyro_scale if name == 'gyro' else 1.0
            triads.append(_Triad(gain * (np.eye(3) + off) @ sensor_from_base, start,
                                 walk * scale / root, density * scale * root / math.sqrt(2.0),
                                 lsb, full, seed, f'{name} noise'))
        self._gyro, self._accel = triads
        self._shake_gyro = config.vibration_gyro
        self._shake_accel = config.vibration_accel

    def restart(self) -> None:
        """Switch the sensor off and on: the same turn-on bias and noise as at the start."""
        self._gyro.restart()
        self._accel.restart()

    def read(self, rates: FloatArray, force: FloatArray, speed: FloatArray,
             ) -> tuple[FloatArray, FloatArray]:
        """(gyro, accel) (N, 3) of felt rates [rad/s], specific force [m/s2], rim speed (N,)."""
        return (self._gyro.read(rates, self._shake_gyro * speed),
                self._accel.read(force, self._shake_accel * speed))
