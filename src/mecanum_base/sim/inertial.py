"""The IMU: what the body feels, seen through a sensor with the errors of a datasheet.

    gyro  = Q( M_g (w + vibration) + b_g(t) + n_g )      M = (I + sensitivity, cross axis) R_mount
    accel = Q( M_a (f + vibration) + b_a(t) + n_a )      b(t) = turn-on bias + random walk

n is white with the noise density times sqrt(rate / 2), Q rounds to the LSB and clips at the range.
Lever arm, tilt and the low-pass filter act in the kernel, at the rate of the physics.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mecanum_base.core.estimation.sensors import ImuConfig
from mecanum_base.core.parameter import FloatArray
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.imu_presets import PRESETS
from mecanum_base.sim.randomness import stream

Three = Sequence[float]  # three numbers
_BLOCK = 256  # samples for which random numbers are drawn at once


class _Triad:
    """Three axes of one kind with their errors; random numbers are drawn in blocks."""

    def __init__(self, matrix: FloatArray, bias: list[float], walk: float, noise: float,
                 lsb: float, full: float, seed: int, name: str) -> None:
        self._m = tuple(float(v) for v in matrix.ravel())
        self._start, self._walk, self._noise = np.array(bias), walk, noise
        self._lsb, self._full = lsb, full if full > 0.0 else math.inf
        self._seed, self._name = seed, name
        self.restart()

    def restart(self) -> None:
        self._bias = self._start
        self._generator = stream(self._seed, self._name)
        self._left: list[list[float]] = []

    def _draw(self) -> None:
        draw = self._generator.standard_normal((_BLOCK, 9))
        bias = self._bias + self._walk * np.cumsum(draw[:, :3], axis=0)
        self._bias = bias[-1]
        self._left = np.hstack([bias + self._noise * draw[:, 3:6], draw[:, 6:]]).tolist()
        self._left.reverse()

    def read(self, felt: Three, shake: float) -> list[float]:
        """Reading of the felt vector; ``shake`` is the standard deviation of the vibration."""
        if not self._left:
            self._draw()
        ex, ey, ez, sx, sy, sz = self._left.pop()
        x, y, z = felt[0] + shake * sx, felt[1] + shake * sy, felt[2] + shake * sz
        m0, m1, m2, m3, m4, m5, m6, m7, m8 = self._m
        out = [m0 * x + m1 * y + m2 * z + ex, m3 * x + m4 * y + m5 * z + ey,
               m6 * x + m7 * y + m8 * z + ez]
        lsb, full = self._lsb, self._full
        if lsb > 0.0:
            out = [math.floor(value / lsb + 0.5) * lsb for value in out]
        if max(out) > full or min(out) < -full:
            out = [min(max(value, -full), full) for value in out]
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
