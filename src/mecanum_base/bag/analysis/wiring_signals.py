"""What a wiring fault can be judged by: wheel rates, gyro, accelerometer and witnesses on a grid.

Everything the search needs are second moments of these columns, so thousands of wirings cost no
more than one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.bag.analysis.agreement import yaw_integral
from mecanum_base.bag.analysis.drift import Track, at_stamps
from mecanum_base.bag.analysis.imu_checks import frozen_spans, resting_at
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.core.parameter import FloatArray

GRID = 0.05  # s
WINDOW = 0.2  # s: rates are means over this
_EDGE = 0.4  # s left out at both ends
_DELAY = 1.0  # s by which wheels may follow a command
_OBEYED = 0.5  # of the commands must show on the wheels, in whatever order, or they tell nothing


@dataclass(frozen=True, slots=True, eq=False)
class Signals:
    """Columns on one grid (K rows): ``wheel`` (K, W) rad/s and its change ``push`` (K, W)
    rad/s^2; ``gyro`` (K, 3) rad/s and ``accel`` (K, 3) m/s^2 in sensor axes, mean at rest
    removed, None where absent; ``up`` (3,): direction of gravity in sensor axes at rest;
    ``witness`` (K, 3): twist told by the truth, or by commands where there is no gyro; ``asked``
    (K, 3): twist of the commands beside a gyro, at the delay at which the wheels follow best;
    ``commanded``: the witness are commands."""

    wheel: FloatArray
    push: FloatArray
    gyro: FloatArray | None
    accel: FloatArray | None
    up: FloatArray | None
    up_size: float
    up_rested: bool
    witness: FloatArray | None
    seconds: float
    asked: FloatArray | None = None
    commanded: bool = False


def signals_of(motion: WheelMotion, gyro: Gyro | None, truth: Track | None = None,
               command: Track | None = None, gyro_late: float = 0.0) -> Signals | None:
    """The columns; None for less than two seconds. ``gyro`` in sensor axes; ``gyro_late`` s is
    taken off its stamps. ``truth`` (poses) comes before ``command`` (twists) as witness."""
    origin = int(motion.stamp_ns[0])
    begin, end = _EDGE, (int(motion.stamp_ns[-1]) - origin) / 1e9 - _EDGE
    if gyro is not None:
        begin = max(begin, (int(gyro.stamp_ns[0]) - origin) / 1e9 + _EDGE)
        end = min(end, (int(gyro.stamp_ns[-1]) - origin) / 1e9 - _EDGE)
    grid = np.arange(begin, end, GRID)
    if gyro is not None:  # what a sensor that hangs says is no evidence
        lag = (int(gyro.stamp_ns[0]) - origin) / 1e9 - gyro_late
        for start, stop in frozen_spans(gyro):
            grid = grid[(grid < start + lag - _EDGE) | (grid > stop + lag + _EDGE)]
    if len(grid) < 2.0 / GRID:
        return None
    wheel = _rate(motion.seconds, motion.angle, grid)
    push = (_rate(motion.seconds, motion.angle, grid + WINDOW / 2)
            - _rate(motion.seconds, motion.angle, grid - WINDOW / 2)) / WINDOW
    rate = accel = up = None
    size, rested = 0.0, False
    if gyro is not None:
        at = (gyro.stamp_ns - origin) / 1e9 - gyro_late
        rest = resting_at(gyro, motion)
        rate = _gyro_rate(gyro, at, grid, rest)
        if np.isfinite(gyro.accel).all(axis=1).mean() > 0.9:
            good = np.isfinite(gyro.accel).all(axis=1)
            rested = bool((good & rest).sum() >= 20)
            mean = gyro.accel[good & rest if rested else good].mean(axis=0)
            size = float(np.linalg.norm(mean))
            up = mean / size if size > 0.1 else None
            step = np.diff(at[good], prepend=at[good][:1])
            speed = np.cumsum((gyro.accel[good] - mean) * step[:, None], axis=0)
            accel = _rate(at[good], speed, grid)
    witness = asked = None
    if truth is not None:
        witness = _truth_twist(truth, origin, grid)
    elif command is not None:
        asked = _followed(command, origin, grid, wheel)
        if gyro is None:
            witness, asked = asked, None
    return Signals(wheel, push, rate, accel, up, size, rested, witness, len(grid) * GRID, asked,
                   truth is None and witness is not None)


def _rate(seconds: FloatArray, columns: FloatArray, grid: FloatArray) -> FloatArray:
    ahead = [np.interp(grid + WINDOW / 2, seconds, c) for c in columns.T]
    behind = [np.interp(grid - WINDOW / 2, seconds, c) for c in columns.T]
    found: FloatArray = (np.column_stack(ahead) - np.column_stack(behind)) / WINDOW
    return found


def _gyro_rate(gyro: Gyro, at: FloatArray, grid: FloatArray, rest: FloatArray) -> FloatArray:
    columns = []
    still = rest.astype(bool)
    for axis in range(3):
        one = Gyro(gyro.stamp_ns, np.column_stack([gyro.rate[:, axis]] * 3), gyro.accel)
        rate = _rate(at, yaw_integral(one)[:, None], grid)[:, 0]
        bias = (float(np.nanmean(gyro.rate[still, axis])) if still.sum() >= 20
                else float(np.median(rate)))
        columns.append(rate - bias)
    return np.column_stack(columns)


def _truth_twist(truth: Track, origin: int, grid: FloatArray) -> FloatArray:
    half = WINDOW / 2
    ends = [at_stamps(truth, (origin + (grid + d) * 1e9).astype(np.int64)) for d in (-half, half)]
    step = ends[1] - ends[0]
    middle = (ends[0][:, 2] + ends[1][:, 2]) / 2.0
    c, s = np.cos(middle), np.sin(middle)
    return np.column_stack([c * step[:, 0] + s * step[:, 1], -s * step[:, 0] + c * step[:, 1],
                            step[:, 2]]) / WINDOW


def _held(command: Track, origin: int, grid: FloatArray) -> FloatArray:
    at = (command.stamp_ns - origin) / 1e9
    index = np.searchsorted(at, grid, side='right') - 1
    found: FloatArray = command.pose[np.clip(index, 0, None)].copy()
    found[(index < 0) | (grid - at[np.clip(index, 0, None)] > 0.6)] = 0.0
    return found


def _followed(command: Track, origin: int, grid: FloatArray,
              wheel: FloatArray) -> FloatArray | None:
    """Commands at the delay at which the wheels explain them best; None if they hardly do."""
    best, chosen = _OBEYED, None
    for late in np.arange(0.0, _DELAY, GRID):
        asked = _held(command, origin, grid - late)
        power = float(np.sum((asked - asked.mean(axis=0)) ** 2))
        rest = asked - wheel @ np.linalg.lstsq(wheel, asked, rcond=None)[0]
        share = 1.0 - float(np.sum(rest**2)) / max(power, 1e-12)
        if share > best:
            best, chosen = share, asked
    return chosen


def right_angles() -> list[FloatArray]:
    """The 24 rotations (3, 3) that map axes onto axes."""
    found = []
    for first in range(3):
        for second in range(3):
            if second == first:
                continue
            for a in (1.0, -1.0):
                for b in (1.0, -1.0):
                    rows = np.zeros((3, 3))
                    rows[0, first], rows[1, second] = a, b
                    rows[2] = np.cross(rows[0], rows[1])
                    found.append(rows)
    found.sort(key=lambda r: -float(np.trace(r)))  # the identity first
    return found


def rpy_of(matrix: FloatArray) -> tuple[float, float, float]:
    """Fixed-axis roll, pitch, yaw of a rotation (3, 3) = Rz Ry Rx."""
    pitch = -math.asin(max(-1.0, min(1.0, float(matrix[2, 0]))))
    if abs(matrix[2, 0]) > 1.0 - 1e-9:  # gimbal: roll and yaw turn about the same axis
        return 0.0, pitch, math.atan2(-float(matrix[0, 1]), float(matrix[1, 1]))
    return (math.atan2(float(matrix[2, 1]), float(matrix[2, 2])), pitch,
            math.atan2(float(matrix[1, 0]), float(matrix[0, 0])))
