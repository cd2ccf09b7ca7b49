"""Which way is up for the IMU: gravity at rest and the axis about which the base turns.

In the axes of the robot file's mount, z of the base is seen as q = (q_x, q_y, ~1):

    at rest     accel_xy / g = q + Rz(-heading) floor + zero-g / g      floor: slope, world axes
    turning     gyro_xy = q * gyro_z + bias                             (a base turns about its z)

Gravity alone cannot tell the mount from the accelerometer's zero offset, and a slope of the floor
only when the base has stood at different headings; the turning axis knows neither, but the gyro's
cross-axis error (the axes of the accelerometer are those of the sensor). Both are weighted by
these errors (datasheets of MPU-6050, BNO055, BMI088).
Not modelled: suspension, and a floor whose slope changes by more than 0.15 deg from stop to stop.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.bag.analysis.agreement import yaw_integral
from mecanum_base.bag.analysis.calibration_windows import WINDOW
from mecanum_base.bag.analysis.clusters import clusters
from mecanum_base.bag.analysis.imu_checks import GRAVITY, resting_at
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.bag.analysis.robust_fit import robust_fit
from mecanum_base.core.parameter import FloatArray, IntArray

ZERO_G = 0.5  # m/s2, standard deviation of the accelerometer's offset (20 to 80 mg)
CROSS_AXIS = 0.012  # standard deviation of the gyro's axes in those of the accelerometer
_FLOOR = math.radians(0.3)  # slope of an indoor floor
_SPOT = math.radians(0.15)  # how much it differs from stop to stop
_REST = 1.0  # s a stop must last
_TURNED = 6.0  # rad
_LEAST_RATE = 1e-4  # rad/s; a smaller spread is an axis that the driver does not fill


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """``up`` (2,): q; ``sigma`` (2,): its standard deviations; ``source`` in words."""

    up: FloatArray
    sigma: FloatArray
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Stops:
    """``accel`` (K, 3) m/s2: mean of each stop in the axes of the file; ``heading`` (K,) rad."""

    accel: FloatArray
    heading: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Turns:
    """``angle`` (K, 3) rad that the gyro's axes turned in each window; ``cluster`` (K,)."""

    angle: FloatArray
    cluster: IntArray


def axis_integrals(gyro: Gyro) -> FloatArray:
    """Integral (N, 3) rad of the three axes."""
    return np.column_stack([
        yaw_integral(Gyro(gyro.stamp_ns, np.column_stack([gyro.rate[:, i]] * 3), gyro.accel))
        for i in range(3)])


def stops_of(gyro: Gyro, motion: WheelMotion) -> Stops:
    """The stops of one recording; ``gyro`` in the axes of the file's mount."""
    rest = resting_at(gyro, motion) & np.isfinite(gyro.accel).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], rest.astype(np.int8), [0]))))
    seconds = (gyro.stamp_ns - gyro.stamp_ns[0]) / 1e9
    rate = gyro.rate[:, 2]
    bias = float(np.nanmean(rate[rest])) if rest.any() and np.isfinite(rate[rest]).any() else 0.0
    heading = yaw_integral(gyro) - bias * seconds
    pairs = [(a, b) for a, b in zip(edges[::2], edges[1::2])
             if b - a >= 20 and seconds[b - 1] - seconds[a] >= _REST]
    return Stops(np.array([gyro.accel[a:b].mean(axis=0) for a, b in pairs]).reshape(-1, 3),
                 np.array([heading[a:b].mean() for a, b in pairs]))


def turns_of(gyro: Gyro, motion: WheelMotion) -> Turns:
    """Windows of turning of one recording; empty where an axis is not measured."""
    empty = Turns(np.zeros((0, 3)), np.zeros(0, dtype=np.int64))
    if not np.isfinite(gyro.rate).all() or np.ptp(gyro.rate, axis=0).min() < _LEAST_RATE:
        return empty
    seconds = (gyro.stamp_ns - gyro.stamp_ns[0]) / 1e9
    edges = np.arange(0.0, seconds[-1], WINDOW)
    if len(edges) < 2:
        return empty
    rest = resting_at(gyro, motion)
    bias = gyro.rate[rest].mean(axis=0) if rest.sum() >= 20 else np.median(gyro.rate, axis=0)
    whole = axis_integrals(gyro)
    angle = np.column_stack([np.diff(np.interp(edges, seconds, whole[:, i])) for i in range(3)])
    angle -= bias * WINDOW
    speed = np.abs(np.concatenate((angle[:1, 2], angle[1:, 2] + angle[:-1, 2])))
    return Turns(angle, clusters(speed, WINDOW))


def level_of(stops: list[Stops], turns: list[Turns]) -> tuple[Level | None, str]:
    """q from all recordings together, or None and what is missing."""
    found: list[Level] = []
    missing: list[str] = []
    for level, why in (_from_gravity(stops), _from_turning(turns)):
        if level is not None:
            found.append(level)
        missing.append(why)
    if not found:
        return None, '; '.join(missing)
    if len(found) == 1:
        return found[0], ''
    weight = np.array([1.0 / level.sigma**2 for level in found])
    up = sum(w * level.up for w, level in zip(weight, found)) / weight.sum(axis=0)
    apart = np.abs(found[0].up - found[1].up) / np.hypot(found[0].sigma, found[1].sigma)
    source = ' and '.join(level.source for level in found)
    if apart.max() > 4.0:
        source += ', which disagree: a sloping floor or a large offset of the accelerometer'
    return Level(np.asarray(up), 1.0 / np.sqrt(weight.sum(axis=0)), source), ''


def _from_gravity(stops: list[Stops]) -> tuple[Level | None, str]:
    accel = np.concatenate([s.accel for s in stops]) if stops else np.zeros((0, 3))
    heading = np.concatenate([s.heading for s in stops]) if stops else np.zeros(0)
    bag = np.concatenate([np.full(len(s.heading), i) for i, s in enumerate(stops)]) \
        if stops else np.zeros(0)
    if not len(accel):
        return None, 'no stop of 1 s with an accelerometer: stand still for 3 s before and after'
    size = np.linalg.norm(accel, axis=1)
    if not (np.abs(size / GRAVITY - 1.0) < 0.1).all():
        return None, (f'the accelerometer reads {float(np.median(size)):.2f} m/s2 at rest, not '
                      'gravity')
    seen = accel[:, :2] / size[:, None]
    bags = int(bag.max()) + 1
    rows = np.zeros((2 * len(seen), 2 + 2 * bags))
    c, s, even = np.cos(heading), np.sin(heading), np.arange(0, 2 * len(seen), 2)
    rows[even, 0] = rows[even + 1, 1] = 1.0
    at = 2 + 2 * bag.astype(np.int64)
    rows[even, at], rows[even, at + 1] = c, s  # Rz(-heading) floor
    rows[even + 1, at], rows[even + 1, at + 1] = -s, c
    ridge = np.diag([0.0, 0.0] + [1.0 / _FLOOR**2] * (2 * bags))
    normal = rows.T @ rows / _SPOT**2 + ridge
    value = np.linalg.solve(normal, rows.T @ seen.reshape(-1) / _SPOT**2)
    sigma = np.sqrt(np.diag(np.linalg.inv(normal))[:2] + (ZERO_G / GRAVITY) ** 2)
    return Level(value[:2], sigma, f'gravity at {len(seen)} stops'), ''


def _from_turning(turns: list[Turns]) -> tuple[Level | None, str]:
    angle = np.concatenate([t.angle for t in turns]) if turns else np.zeros((0, 3))
    turned = float(np.abs(angle[:, 2]).sum())
    if turned < _TURNED:
        return None, (f'only {turned:.1f} rad turned with a three-axis gyro: turn two times '
                      'around in each direction on the spot')
    offset, parts = 0, []
    for turn in turns:
        parts.append(turn.cluster + offset)
        offset += int(turn.cluster.max()) + 1 if len(turn.cluster) else 0
    cluster = np.concatenate(parts)
    design = np.column_stack([angle[:, 2], np.full(len(angle), WINDOW)])
    up, sigma = np.zeros(2), np.zeros(2)
    for axis in range(2):
        fit = robust_fit(design, angle[:, axis], cluster, np.zeros(2), np.array([np.inf, 0.01]))
        if fit is None:
            return None, 'the turning is too short: turn two times around in each direction'
        up[axis] = fit.value[0]
        sigma[axis] = math.hypot(fit.half_width(0) / 1.645, CROSS_AXIS)
    return Level(up, sigma, f'the axis of {turned:.0f} rad of turning'), ''
