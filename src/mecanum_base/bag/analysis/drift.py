"""Drift of an odometry track against the truth: ATE, RPE per distance, final error, yaw.

Alignment is stated with every figure: 'start' puts both start poses on each other; 'rotation'
turns and shifts the truth for the least position error (used where the truth has no heading).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.recording import unwrapped
from mecanum_base.core.parameter import FloatArray, IntArray

SEGMENTS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
_LEAST = 5  # segments for a figure


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Poses (N, 3) of base_link at stamps (N,) ns, in order."""

    stamp_ns: IntArray
    pose: FloatArray


@dataclass(frozen=True, slots=True)
class Drift:
    """Errors of one track: positions in m, yaw in rad; ``rpe``: distance -> figures."""

    name: str
    alignment: str
    path: float
    seconds: float
    ate: float
    ate_best: float
    final: float
    final_share: float
    yaw_final: float | None
    yaw_rms: float | None
    rpe: dict[str, dict[str, float]] = field(default_factory=dict)


def truth_track(stamp_ns: IntArray, pose: FloatArray) -> Track:
    """The truth sorted by stamp, equal stamps and non-finite poses dropped, yaw unwrapped."""
    order = np.argsort(stamp_ns, kind='stable')
    stamp, grid = stamp_ns[order], pose[order]
    keep = np.isfinite(grid).all(axis=1)
    stamp, grid = stamp[keep], grid[keep].copy()
    keep = np.concatenate(([True], np.diff(stamp) > 0)) if len(stamp) else np.zeros(0, bool)
    stamp, grid = stamp[keep], grid[keep]
    grid[:, 2] = unwrapped(grid[:, 2])
    return Track(stamp, grid)


def at_stamps(track: Track, stamp_ns: IntArray) -> FloatArray:
    """Poses (N, 3) of the track at other stamps, interpolated; NaN outside its span."""
    origin = int(track.stamp_ns[0])
    seconds, own = (stamp_ns - origin) / 1e9, (track.stamp_ns - origin) / 1e9
    columns = [np.interp(seconds, own, track.pose[:, i], left=np.nan, right=np.nan)
               for i in range(3)]
    found: FloatArray = np.column_stack(columns)
    return found


def has_heading(truth: Track, turned: float) -> bool:
    """Whether the truth knows the heading: it does not if it never turns while the robot does."""
    return bool(np.ptp(truth.pose[:, 2]) > 1e-6) or turned < 0.2


def drift_of(name: str, track: Track, truth: Track) -> tuple[Drift, FloatArray] | None:
    """Errors of ``track``, and the aligned truth (N, 3) at its own stamps inside the track's span.

    None without overlap.
    """
    pose = at_stamps(track, truth.stamp_ns)
    inside = np.isfinite(pose[:, 0])
    if inside.sum() < 3:
        return None
    stamp, real, pose = truth.stamp_ns[inside], truth.pose[inside], pose[inside]
    heading = has_heading(truth, float(np.ptp(pose[:, 2])))
    aligned = (_start_aligned if heading else _best_aligned)(real, pose)
    best = _best_aligned(real, pose)
    error = np.hypot(*(pose - aligned)[:, :2].T)
    path = _path_length(real)
    turn = (pose[:, 2] - aligned[:, 2]) if heading else None
    drift = Drift(
        name, 'start' if heading else 'rotation', path, float(stamp[-1] - stamp[0]) / 1e9,
        float(np.sqrt(np.mean(error**2))),
        float(np.sqrt(np.mean(np.sum((pose - best)[:, :2]**2, axis=1)))),
        float(error[-1]), float(error[-1] / max(path, 1e-9)),
        None if turn is None else float(turn[-1]),
        None if turn is None else float(np.sqrt(np.mean(turn**2))),
        _relative(pose, aligned, path) if heading else {})
    return drift, aligned


def _path_length(pose: FloatArray) -> float:
    """Length of a noisy path: steps of at least 2 cm, so that noise at rest does not count."""
    total, anchor = 0.0, pose[0, :2]
    for point in pose[:, :2]:
        step = math.hypot(float(point[0] - anchor[0]), float(point[1] - anchor[1]))
        if step >= 0.02:
            total, anchor = total + step, point
    return total


def _start_aligned(real: FloatArray, pose: FloatArray) -> FloatArray:
    turn = float(pose[0, 2] - real[0, 2])
    return _moved(real, turn, real[0, :2], pose[0, :2])


def _best_aligned(real: FloatArray, pose: FloatArray) -> FloatArray:
    """Rotation and shift of ``real`` with least squared distance to ``pose`` (Horn, 2-D)."""
    a, b = real[:, :2] - real[:, :2].mean(axis=0), pose[:, :2] - pose[:, :2].mean(axis=0)
    turn = math.atan2(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(np.sum(a * b)))
    return _moved(real, turn, real[:, :2].mean(axis=0), pose[:, :2].mean(axis=0))


def _moved(real: FloatArray, turn: float, centre: Any, target: Any) -> FloatArray:
    c, s = math.cos(turn), math.sin(turn)
    shifted = real[:, :2] - centre
    found: FloatArray = np.column_stack([
        c * shifted[:, 0] - s * shifted[:, 1] + target[0],
        s * shifted[:, 0] + c * shifted[:, 1] + target[1], real[:, 2] + turn])
    return found


def _relative(pose: FloatArray, real: FloatArray, path: float) -> dict[str, dict[str, float]]:
    """Errors over segments of equal travelled distance, as in KITTI."""
    travelled = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(real[:, :2], axis=0).T))))
    found: dict[str, dict[str, float]] = {}
    for length in SEGMENTS:
        if length > path / 2.0:
            break
        starts = np.arange(0, len(pose), max(len(pose) // 200, 1))
        ends = np.searchsorted(travelled, travelled[starts] + length)
        good = ends < len(pose)
        starts, ends = starts[good], ends[good]
        if len(starts) < _LEAST:
            continue
        moved, turned = _between(pose, starts, ends)
        true_moved, true_turned = _between(real, starts, ends)
        error = np.hypot(*(moved - true_moved).T)
        found[f'{length:g}'] = {
            'segments': float(len(starts)), 'rms': float(np.sqrt(np.mean(error**2))),
            'share': float(np.sqrt(np.mean(error**2)) / length),
            'yaw_rms': float(np.sqrt(np.mean((turned - true_turned)**2)))}
    return found


def _between(pose: FloatArray, starts: IntArray, ends: IntArray) -> tuple[FloatArray, FloatArray]:
    """Motion (K, 2) and turn (K,) from start to end, in the frame of the start."""
    step, yaw = pose[ends] - pose[starts], pose[starts, 2]
    c, s = np.cos(yaw), np.sin(yaw)
    return np.column_stack([c * step[:, 0] + s * step[:, 1], -s * step[:, 0] + c * step[:, 1]]), \
        step[:, 2]
