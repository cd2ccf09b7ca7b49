"""The IMU: what the body feels, seen through a sensor with the errors of a datasheet.

    gyro  = Q( M_g (w + vibration) + b_g(t) + n_g )      M = (I + sensitivity, cross axis) R_mount
    accel = Q( M_a (f + vibration) + b_a(t) + n_a )      b(t) = turn-on bias + random walk

n is white with the noise density times sqrt(rate / 2), Q rounds to the LSB and clips at the range.
Lever arm, tilt and the low-pass filter act in the kernel, at the rate of the physics.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.sensors import ImuConfig
from mecanum_base.core.parameter import FloatArray
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.imu_presets import PRESETS
from mecanum_base.sim.randomness import Normals, stream

Three = tuple[float, float, float]


class _Triad:
    """Three axes of one kind with their errors."""

    def __init__(self, matrix: FloatArray, bias: list[float], walk: float, noise: float,
                 lsb: float, full: float, seed: int, name: str) -> None:
        self._m = [float(v) for v in matrix.ravel()]
        self._start, self._walk, self._noise = bias, walk, noise
        self._lsb, self._full = lsb, full
        self._seed, self._name = seed, name
        self.restart()

    def restart(self) -> None:
        self.bias = list(self._start)
        self._normal = Normals(self._seed, self._name)

    def read(self, felt: Three, shake: float) -> list[float]:
        """Reading of the felt vector; ``shake`` is the standard deviation of the vibration."""
        normal, m, bias = self._normal, self._m, self.bias
        x, y, z = felt
        if shake > 0.0:
            x, y, z = x + shake * normal(), y + shake * normal(), z + shake * normal()
        out = []
        for k in range(3):
            if self._walk > 0.0:
                bias[k] += self._walk * normal()
            value = m[3 * k] * x + m[3 * k + 1] * y + m[3 * k + 2] * z + bias[k]
            if self._noise > 0.0:
                value += self._noise * normal()
            if self._full > 0.0:
                value = min(max(value, -self._full), self._full)
            if self._lsb > 0.0:
                value = math.floor(value / self._lsb + 0.5) * self._lsb
            out.append(value)
        return out


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
            start = (draw.standard_normal(3) * bias * scale).tolist()
            triads.append(_Triad((np.eye(3) + off) @ sensor_from_base, start,
                                 walk * scale / root, density * scale * root / math.sqrt(2.0),
                                 lsb, full, seed, f'{name} noise'))
        self.gyro, self.accel = triads
        self._shake_gyro = config.vibration_gyro
        self._shake_accel = config.vibration_accel

    def restart(self) -> None:
        """Switch the sensor off and on: the same turn-on bias and noise as at the start."""
        self.gyro.restart()
        self.accel.restart()

    def read(self, rates: Three, force: Three, speed: float) -> tuple[list[float], list[float]]:
        """(gyro, accel) from felt rates [rad/s], specific force [m/s2], mean rim speed [m/s]."""
        return (self.gyro.read(rates, self._shake_gyro * speed),
                self.accel.read(force, self._shake_accel * speed))
