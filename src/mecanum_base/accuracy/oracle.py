"""The oracle: an error-state filter on the same sensors that is told the true slip.

    state   pose (x, y, yaw), body velocity (vx, vy), gyro bias, accelerometer bias (2),
            scale errors of gyro and accelerometer (2) and of lever arms, travel phi_i of each
            wheel as it would be without slip, its radius error k_i and lateral error e_i
    motion  wz = (gyro - bg)/(1 + kg),  a = (accel - ba)/(1 + ka)  mean readings over a frame
    wheels  phi_i' = (A_i1 vx + A_i2 (1 + e_i) vy + A_i3 (1 + kL) wz)/(1 + k_i)
            z_i = phi_i + noise             z_i: measured travel along the roller axis [m]

What it knows beyond the sensors, by ``told``:

    'travel'  the true slip angle of every wheel at every encoder stamp: z_i is the measured
              travel less the true slip travel, so creep and micro-slip are known as well. No
              estimator can be expected to reach this one.
    'times'   which wheels slide faster than 3 cm/s, and when, but not by how much: their phi_i is
              set free (variance (3 m/s T)^2) for the frame of length T. This is the oracle of the
              design study, whose accuracy an estimator that judges slip perfectly would have.

It does not know radii, levers, biases, scale errors, floor or loads: their standard deviations
are those of block ``estimator`` of the robot file, as ours starts with. It is run over the
recording in the order of stamps, so late messages cost it nothing. Where IMU samples are missing
the motion in between is left to the wheels.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.accuracy.track import Readings, Track
from mecanum_base.core.estimation.geometry import rolling_rows, travel_per_radian
from mecanum_base.core.parameter import FloatArray
from mecanum_base.robot import Robot
from mecanum_base.sim.headless import Run

TOLD = ('travel', 'times')
SLIDING = 0.03  # m/s at which 'times' calls a wheel slipping
_X, _Y, _YAW, _VX, _VY, _BG, _BA, _KG, _KA, _KL, _PHI = 0, 1, 2, 3, 4, 5, 6, 8, 9, 11, 12
_FREE = 3.0  # m/s
_GYRO_SHAKE, _ACCEL_SHAKE = 7e-4, 0.03  # noise densities per m/s of speed
_GYRO_WALK, _ACCEL_WALK = 1e-5, 0.04  # rad/s/rt(s); m/s^2/rt(s), floor slope included
_MISSING_TURN, _MISSING_PUSH = 1.0, 3.0  # rad/s and m/s^2 of doubt while the IMU is silent
_TRAVEL_NOISE = {'travel': 5e-3, 'times': 7e-3}  # m/rt(m): contact wander; creep too
_EXCENTRIC, _JITTER = 4e-4, 2e-4  # m, s


class Oracle:
    """Filter over W fixed wheels; ``x`` (12 + 3 W,) and covariance ``P``."""

    def __init__(self, robot: Robot, told: str) -> None:
        if told not in TOLD:
            raise ValueError(f'told must be one of {TOLD}, not {told!r}')
        config, self._rows = robot.estimator, rolling_rows(robot.base)
        count = len(self._rows)
        self._phi = slice(_PHI, _PHI + count)
        self._scale = slice(_PHI + count, _PHI + 2 * count)
        self._side = slice(_PHI + 2 * count, _PHI + 3 * count)
        size = _PHI + 3 * count
        self.x: FloatArray = np.zeros(size)
        sigma = np.full(size, 1e-6)
        sigma[_VX:_VY + 1] = 1e-3
        sigma[_BG], sigma[_BA:_BA + 2] = config.gyro_bias_sigma, config.accel_bias_sigma
        sigma[_KG], sigma[_KA:_KA + 2] = config.gyro_scale_sigma, config.accel_scale_sigma
        sigma[_KL], sigma[self._side] = config.lever_sigma, config.roller_sigma
        sigma[self._scale] = config.wheel_sigma
        self.P: FloatArray = np.diag(sigma**2)
        self.P[self._scale, self._scale] += config.radius_sigma**2
        self.P[self._side, self._side] += config.lateral_sigma**2
        counts, _ = robot.encoder.for_wheels(count)
        quantum = travel_per_radian(robot.base) * 2.0 * math.pi / counts
        self._radius_places = (np.arange(count) + _PHI) * size + np.arange(count) + _PHI + count
        self._side_places = self._radius_places + count
        self._fixed = np.diag(quantum**2 / 12.0 + _EXCENTRIC**2)
        self._gyro_noise, self._accel_noise = config.gyro_noise, config.accel_noise
        self._travel_noise = _TRAVEL_NOISE[told]
        self._speed: FloatArray = np.zeros(count)

    def predict(self, dt: float, gyro: float, accel: FloatArray, missing: bool) -> None:
        """Over ``dt`` [s] with readings gyro [rad/s] and accel (2,) [m/s^2] at base_link."""
        x, rows = self.x, self._rows
        theta, vx, vy = x[_YAW], x[_VX], x[_VY]
        wz = (gyro - x[_BG]) / (1.0 + x[_KG])
        push = np.zeros(2) if missing else (accel - x[_BA:_BA + 2]) / (1.0 + x[_KA:_KA + 2])
        angle = wz * dt
        dvx, dvy = (push[0] + wz * vy) * dt, (push[1] - wz * vx) * dt
        mx, my = vx + 0.5 * dvx, vy + 0.5 * dvy
        c, s = math.cos(theta + 0.5 * angle), math.sin(theta + 0.5 * angle)
        dx, dy = (c * mx - s * my) * dt, (s * mx + c * my) * dt
        radius = 1.0 + x[self._scale]
        speed = (rows[:, 0] * mx + rows[:, 1] * (1.0 + x[self._side]) * my
                 + rows[:, 2] * (1.0 + x[_KL]) * wz) / radius
        F = np.eye(len(x))
        F[_YAW, _BG], F[_YAW, _KG] = -dt, -angle
        F[_X, _YAW], F[_X, _VX], F[_X, _VY] = -dy, c * dt, -s * dt
        F[_Y, _YAW], F[_Y, _VX], F[_Y, _VY] = dx, s * dt, c * dt
        F[_VX, _VY], F[_VX, _BG], F[_VX, _KG] = angle, -vy * dt, -vy * angle
        F[_VY, _VX], F[_VY, _BG], F[_VY, _KG] = -angle, vx * dt, vx * angle
        if not missing:
            for axis in (0, 1):
                F[_VX + axis, _BA + axis] = -dt
                F[_VX + axis, _KA + axis] = -push[axis] * dt
        F[self._phi, _VX], F[self._phi, _VY] = rows[:, 0] * dt, rows[:, 1] * dt
        F[self._phi, _BG], F[self._phi, _KG] = -rows[:, 2] * dt, -rows[:, 2] * angle
        F[self._phi, _KL] = rows[:, 2] * angle
        F.ravel()[self._side_places] = rows[:, 1] * my * dt
        F.ravel()[self._radius_places] = -speed * dt
        felt = min(1.5, math.hypot(mx, my) + 0.2 * abs(wz))
        turn = _MISSING_TURN if missing else self._gyro_noise + _GYRO_SHAKE * felt
        shake = _MISSING_PUSH if missing else self._accel_noise + _ACCEL_SHAKE * felt
        along = np.zeros(len(x))
        along[_YAW], along[_VX], along[_VY], along[self._phi] = 1.0, vy, -vx, rows[:, 2]
        noise = np.zeros(len(x))
        noise[_VX:_VY + 1], noise[_BG] = shake**2, _GYRO_WALK**2
        noise[_BA:_BA + 2], noise[self._phi] = _ACCEL_WALK**2, self._travel_noise**2 * abs(speed)
        x[[_X, _Y, _YAW, _VX, _VY]] += (dx, dy, angle, dvx, dvy)
        x[self._phi] += speed * dt
        self.P = F @ self.P @ F.T + (turn**2 * dt) * (along[:, None] * along)
        self.P.ravel()[::len(x) + 1] += noise * dt
        self._speed = speed

    def correct(self, travel: FloatArray, free: FloatArray) -> None:
        """Take the travel (W,) m of one frame; ``free`` (W,) m^2 is added to phi's variance."""
        phi = self._phi
        self.P[phi, phi] += np.diag(free)
        noise = self._fixed + _JITTER**2 * np.outer(self._speed, self._speed)
        gain = np.linalg.solve(self.P[phi, phi] + noise, self.P[phi]).T
        self.x = self.x + gain @ (travel - self.x[phi])
        self.P = self.P - gain @ self.P[phi]
        self.P = 0.5 * (self.P + self.P.T)


def oracle_track(readings: Readings, robot: Robot, run: Run, told: str) -> Track:
    """Run the oracle over one recording; poses at the encoder stamps."""
    travel, free = _told(readings, robot, run, told)
    oracle = Oracle(robot, told)
    frames = readings.frame_ns
    seconds = np.diff(frames) * 1e-9
    gyro = _integrals(readings, readings.raw_gyro) / seconds
    accel = np.column_stack([_integrals(readings, readings.accel[:, i]) for i in (0, 1)]
                            ) / seconds[:, None]
    silent = _integrals(readings, readings.gap) > 0.0
    silent |= (frames[1:] > readings.imu_ns[-1]) | (frames[:-1] < readings.imu_ns[0])
    poses: list[FloatArray] = [np.zeros(3)]
    for k, dt in enumerate(seconds.tolist()):
        oracle.predict(dt, float(gyro[k]), accel[k], bool(silent[k]))
        oracle.correct(travel[k + 1], free[k + 1])
        poses.append(oracle.x[:3].copy())
    return Track(frames, np.array(poses))


def _integrals(readings: Readings, values: FloatArray) -> FloatArray:
    """Integral (F - 1,) over each frame of IMU values (I,), each the mean since the last."""
    step = np.diff(readings.imu_ns, prepend=readings.imu_ns[:1]) * 1e-9
    total = np.interp(readings.frame_ns, readings.imu_ns, np.cumsum(step * values))
    found: FloatArray = np.diff(total)
    return found


def _told(readings: Readings, robot: Robot, run: Run, told: str) -> tuple[FloatArray, FloatArray]:
    """Travel (F, W) the oracle gets, and the variance (F, W) by which phi is set free."""
    per_radian, frames = travel_per_radian(robot.base), readings.frame_ns
    free = np.zeros_like(readings.travel)
    if told == 'travel':
        slid = np.column_stack([np.interp(frames, run.stamp_ns, run.slip_angle[:, i])
                                for i in range(len(per_radian))])
        return readings.travel - (slid - slid[:1]) * per_radian, free
    sliding = np.abs(run.slip_rate) * per_radian > SLIDING
    seconds = np.diff(frames, prepend=frames[:1]) * 1e-9
    begin = np.searchsorted(run.stamp_ns, frames - np.round(seconds * 1e9).astype(np.int64),
                            side='right') - 1
    total = np.vstack([np.zeros((1, len(per_radian))), np.cumsum(sliding, axis=0)])
    end = np.minimum(np.searchsorted(run.stamp_ns, frames) + 1, len(run.stamp_ns))
    slips = total[end] - total[np.clip(begin, 0, None)] > 0.0
    free[slips] = 1.0
    return readings.travel, free * (_FREE * seconds[:, None])**2
