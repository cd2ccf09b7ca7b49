"""Windows of motion for the calibration: what the wheels say and what the reference says.

A window is half a second. Its reference motion is the sum of short steps, each turned into the
body axes of its middle, as the wheels see it: a base may turn while it goes straight on in the
world, which is another way along its axes than an arc between the same poses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.agreement import yaw_integral
from mecanum_base.bag.analysis.clusters import clusters
from mecanum_base.bag.analysis.drift import Track, at_stamps, has_heading
from mecanum_base.bag.analysis.imu_checks import resting_at
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.core.parameter import FloatArray, IntArray

WINDOW = 0.5  # s
_STEPS = 20  # of the reference in a window
_SHORTEST = 16  # windows
_AROUND = 0.1  # s, the speed at an edge is told from this much before to this much after


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """K windows: ``wheel`` (K, W) rad turned; ``moved`` (K, 3): reference motion m, m, rad
    (columns NaN where there is none); ``gyro`` (K,) rad, bias at rest removed, NaN without one;
    ``cluster`` (K,): which stretch of dependent errors a window belongs to; ``bag`` (K,)."""

    wheel: FloatArray
    moved: FloatArray
    gyro: FloatArray
    cluster: IntArray
    bag: IntArray

    def __len__(self) -> int:
        return len(self.wheel)

    def where(self, chosen: Any) -> Windows:
        """The chosen windows (a flag each)."""
        return Windows(self.wheel[chosen], self.moved[chosen], self.gyro[chosen],
                       self.cluster[chosen], self.bag[chosen])


def windows_of(motion: WheelMotion, truth: Track | None, gyro: Gyro | None, up: FloatArray,
               gyro_late: float = 0.0) -> Windows | None:
    """Windows of one recording; ``up`` (3,): z of the base in gyro axes. None if too short."""
    start, stop = int(motion.stamp_ns[0]), int(motion.stamp_ns[-1])
    late = int(gyro_late * 1e9)
    if truth is not None:
        start, stop = max(start, int(truth.stamp_ns[0])), min(stop, int(truth.stamp_ns[-1]))
    if gyro is not None:
        start = max(start, int(gyro.stamp_ns[0]) - late)
        stop = min(stop, int(gyro.stamp_ns[-1]) - late)
    edges = np.arange(start, stop, int(WINDOW * 1e9))
    if len(edges) < _SHORTEST:
        return None
    at = (edges - int(motion.stamp_ns[0])) / 1e9
    angle = np.column_stack([np.interp(at, motion.seconds, c) for c in motion.angle.T])
    count = len(edges) - 1
    moved = np.full((count, 3), np.nan)
    if truth is not None:
        moved = _moved(truth, edges)
    turned = np.full(count, np.nan)
    if gyro is not None:
        turned = _turned(gyro, motion, up, edges, late)
    return Windows(np.diff(angle, axis=0), moved, turned,
                   clusters(_speed(motion, at[:-1]), WINDOW), np.zeros(count, dtype=np.int64))


def _speed(motion: WheelMotion, at: FloatArray) -> FloatArray:
    """How much all wheels turn around each instant (K,)."""
    found: FloatArray = np.zeros(len(at))
    for column in motion.angle.T:
        found += np.abs(np.interp(at + _AROUND, motion.seconds, column)
                        - np.interp(at - _AROUND, motion.seconds, column))
    return found


def _moved(truth: Track, edges: IntArray) -> FloatArray:
    count = len(edges) - 1
    if not has_heading(truth, 1.0):
        return np.full((count, 3), np.nan)
    part = np.arange(_STEPS) * (int(WINDOW * 1e9) // _STEPS)
    pose = at_stamps(truth, np.append((edges[:-1, None] + part).reshape(-1), edges[-1]))
    step = np.diff(pose, axis=0)
    middle = pose[:-1, 2] + step[:, 2] / 2.0
    c, s = np.cos(middle), np.sin(middle)
    body = np.column_stack([c * step[:, 0] + s * step[:, 1], -s * step[:, 0] + c * step[:, 1],
                            step[:, 2]])
    found: FloatArray = body.reshape(count, _STEPS, 3).sum(axis=1)
    return found


def _turned(gyro: Gyro, motion: WheelMotion, up: FloatArray, edges: IntArray,
            late: int) -> FloatArray:
    rate = gyro.rate @ up
    rest = resting_at(gyro, motion).astype(bool) & np.isfinite(rate)
    if rest.sum() >= 20:
        rate = rate - _bias(gyro.stamp_ns, rate, rest)
    columns = Gyro(gyro.stamp_ns, np.column_stack([rate] * 3), gyro.accel)
    at = (edges + late - int(gyro.stamp_ns[0])) / 1e9
    seconds = (gyro.stamp_ns - int(gyro.stamp_ns[0])) / 1e9
    found: FloatArray = np.diff(np.interp(at, seconds, yaw_integral(columns)))
    return found


def _bias(stamp_ns: IntArray, rate: FloatArray, rest: FloatArray) -> FloatArray:
    """Bias between stops: the mean of each stop, interpolated in time."""
    edge = np.flatnonzero(np.diff(np.concatenate(([0], rest.astype(np.int8), [0]))))
    pairs = [(a, b) for a, b in zip(edge[::2], edge[1::2]) if b - a >= 20]
    if not pairs:
        return np.full(len(rate), float(rate[rest].mean()))
    middle = [float(stamp_ns[(a + b) // 2] - stamp_ns[0]) for a, b in pairs]
    value = [float(rate[a:b].mean()) for a, b in pairs]
    found: FloatArray = np.interp((stamp_ns - stamp_ns[0]).astype(float), middle, value)
    return found


def together(parts: list[Windows]) -> Windows:
    """Windows of several recordings, clusters kept apart."""
    cluster, bag, offset = [], [], 0
    for number, part in enumerate(parts):
        cluster.append(part.cluster + offset)
        bag.append(np.full(len(part), number))
        offset += int(part.cluster.max()) + 1
    return Windows(np.concatenate([p.wheel for p in parts]),
                   np.concatenate([p.moved for p in parts]),
                   np.concatenate([p.gyro for p in parts]), np.concatenate(cluster),
                   np.concatenate(bag))
