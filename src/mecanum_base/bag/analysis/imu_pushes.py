"""Acceleration as the wheels tell it beside the accelerometer's, through one and the same filter.

With p(t) the place of the IMU in the world and f the accelerometer turned into the world by the
heading, both are second differences over W = 0.2 s, so neither is differentiated more coarsely:

    told(t) = (p(t + W) - 2 p(t) + p(t - W)) / W^2       p = track + R(heading) lever
    felt(t) = the same of the double integral of f        both turned back into base axes at t

Gravity, zero-g and the slope of the floor are constant over a window and stay in ``felt``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.bag.analysis.clusters import clusters
from mecanum_base.bag.analysis.drift import Track, at_stamps
from mecanum_base.bag.analysis.imu_checks import resting_at
from mecanum_base.bag.analysis.imu_levels import axis_integrals
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.parameter import FloatArray, IntArray

SPAN = 0.2  # s, W
_STEP = 0.1  # s between windows
_ARM = 0.2  # m: what a radian counts
_SHORTEST = 2.0  # s


@dataclass(frozen=True, slots=True, eq=False)
class Pushes:
    """K windows: ``told`` (K, 2) and ``felt`` (K, 2) m/s2, ``heading`` (K,) rad, ``cluster``
    (K,)."""

    told: FloatArray
    felt: FloatArray
    heading: FloatArray
    cluster: IntArray

    def __len__(self) -> int:
        return len(self.told)


def heading_of(gyro: Gyro, motion: WheelMotion) -> FloatArray:
    """Heading (N,) rad on the gyro's stamps, bias at rest removed (axes of the base)."""
    seconds = (gyro.stamp_ns - gyro.stamp_ns[0]) / 1e9
    rest = resting_at(gyro, motion)
    turned: FloatArray = axis_integrals(gyro)[:, 2]
    if rest.sum() < 20:
        return turned
    steady: FloatArray = turned - float(np.nanmean(gyro.rate[rest, 2])) * seconds
    return steady


def wheel_track(motion: WheelMotion, matrix: FloatArray, gyro: Gyro, late_ns: int) -> Track:
    """Dead reckoning with the wheels' way and the gyro's heading (without a gyro the wheels'), on
    the wheels' stamps."""
    step = np.diff(motion.angle, axis=0) @ body_from_wheels(matrix).T
    if np.isfinite(gyro.rate[:, 2]).mean() > 0.9:
        at = (motion.stamp_ns - (gyro.stamp_ns[0] - late_ns)) / 1e9
        heading = np.interp(at, (gyro.stamp_ns - gyro.stamp_ns[0]) / 1e9,
                            heading_of(gyro, motion))
    else:
        heading = np.concatenate(([0.0], np.cumsum(step[:, 2])))
    middle = (heading[1:] + heading[:-1]) / 2.0
    c, s = np.cos(middle), np.sin(middle)
    x = np.concatenate(([0.0], np.cumsum(c * step[:, 0] - s * step[:, 1])))
    y = np.concatenate(([0.0], np.cumsum(s * step[:, 0] + c * step[:, 1])))
    return Track(motion.stamp_ns, np.column_stack([x, y, heading]))


def pushes_of(track: Track, gyro: Gyro, lever: FloatArray, late_ns: int) -> Pushes | None:
    """``gyro`` in (levelled) axes of the file's mount; ``lever`` (2,) m to the IMU in base axes;
    ``late_ns`` is taken off the gyro's stamps. None where there is less than 2 s."""
    good = np.isfinite(gyro.accel).all(axis=1)
    if good.sum() < 40:
        return None
    stamp, accel = gyro.stamp_ns[good] - late_ns, gyro.accel[good]
    start = max(int(stamp[0]), int(track.stamp_ns[0])) + int(SPAN * 1e9)
    stop = min(int(stamp[-1]), int(track.stamp_ns[-1])) - int(SPAN * 1e9)
    grid = np.arange(start, stop, int(_STEP * 1e9), dtype=np.int64)
    if len(grid) < _SHORTEST / _STEP:
        return None
    pose = at_stamps(track, grid)
    told = _second([_place(at_stamps(track, grid + d), lever) for d in _around()])
    heading = np.interp((stamp - track.stamp_ns[0]) / 1e9,
                        (track.stamp_ns - track.stamp_ns[0]) / 1e9, track.pose[:, 2])
    world = _turned(accel[:, :2], heading)
    twice = _integral(stamp, _integral(stamp, world))
    at = (stamp - stamp[0]) / 1e9
    felt = _second([np.column_stack([np.interp((grid + d - stamp[0]) / 1e9, at, column)
                                     for column in twice.T]) for d in _around()])
    told, felt = _turned(told, -pose[:, 2]), _turned(felt, -pose[:, 2])
    keep = np.isfinite(told).all(axis=1) & np.isfinite(felt).all(axis=1)
    around = at_stamps(track, grid + _around()[2]) - at_stamps(track, grid + _around()[0])
    cluster = clusters(np.linalg.norm(around * [1.0, 1.0, _ARM], axis=1), _STEP)
    return Pushes(told[keep], felt[keep], pose[keep, 2], cluster[keep])


def _around() -> tuple[int, int, int]:
    half = int(SPAN * 1e9)
    return -half, 0, half


def _place(pose: FloatArray, lever: FloatArray) -> FloatArray:
    return pose[:, :2] + _turned(np.broadcast_to(lever, (len(pose), 2)), pose[:, 2])


def _turned(columns: FloatArray, angle: FloatArray) -> FloatArray:
    """Vectors (K, 2) turned by angles (K,)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * columns[:, 0] - s * columns[:, 1],
                            s * columns[:, 0] + c * columns[:, 1]])


def _second(three: list[FloatArray]) -> FloatArray:
    found: FloatArray = (three[2] - 2.0 * three[1] + three[0]) / SPAN**2
    return found


def _integral(stamp: IntArray, columns: FloatArray) -> FloatArray:
    step = np.diff(stamp)[:, None] / 1e9
    found: FloatArray = np.vstack([np.zeros(2), np.cumsum(
        step * (columns[1:] + columns[:-1]) / 2.0, axis=0)])
    return found
