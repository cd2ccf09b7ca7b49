"""Errors of a track against the truth, as sums that may be added over runs.

Both start at 0, 0, 0; nothing is aligned. Segment drift: over every :data:`SEGMENT` m of true
path, starting every :data:`EVERY` m, the error of the relative motion

    e = | p(T_a^-1 T_b) - p(S_a^-1 S_b) | / SEGMENT      T truth, S track, p position

which does not depend on errors made before the segment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.accuracy.track import Track
from mecanum_base.core import se2
from mecanum_base.core.parameter import FloatArray, IntArray

SEGMENT, EVERY = 5.0, 0.25  # m


@dataclass(frozen=True, slots=True)
class Drift:
    """Sums of one run: squared segment errors (relative) and their number, squared position
    errors [m^2] and number; final position error over the path, final yaw error [rad]."""

    segment_squares: float
    segments: int
    squares: float
    samples: int
    final_share: float
    final_yaw: float


def at_stamps(track: Track, stamp_ns: IntArray) -> FloatArray:
    """Poses (N, 3) at stamps inside the track, interpolated."""
    yaw = np.unwrap(track.pose[:, 2])
    columns = (track.pose[:, 0], track.pose[:, 1], yaw)
    origin = int(track.stamp_ns[0])
    seconds, own = (stamp_ns - origin) * 1e-9, (track.stamp_ns - origin) * 1e-9
    found: FloatArray = np.column_stack([np.interp(seconds, own, c) for c in columns])
    return found


def path_of(pose: FloatArray) -> FloatArray:
    """Distance travelled (N,) m along poses (N, 3) of the noiseless truth."""
    step = np.hypot(np.diff(pose[:, 0]), np.diff(pose[:, 1]))
    found: FloatArray = np.concatenate(([0.0], np.cumsum(step)))
    return found


def drift_of(pose: FloatArray, truth: FloatArray) -> Drift:
    """Errors of poses (N, 3) against true ones (N, 3) at the same stamps."""
    error = np.hypot(pose[:, 0] - truth[:, 0], pose[:, 1] - truth[:, 1])
    path = path_of(truth)
    segment = _segments(pose, truth, path)
    return Drift(float(np.sum(segment**2)), len(segment), float(np.sum(error**2)), len(error),
                 float(error[-1] / max(path[-1], 1e-9)),
                 float(se2.wrap_angle(float(pose[-1, 2] - truth[-1, 2]))))


def _segments(pose: FloatArray, truth: FloatArray, path: FloatArray) -> FloatArray:
    if path[-1] < SEGMENT:
        return np.zeros(0)
    begin = np.arange(0.0, path[-1] - SEGMENT, EVERY)
    start = np.searchsorted(path, begin)
    end = np.searchsorted(path, begin + SEGMENT)
    moved, wanted = _between(pose, start, end), _between(truth, start, end)
    found: FloatArray = np.hypot(*(moved - wanted).T) / SEGMENT
    return found


def _between(pose: FloatArray, start: IntArray, end: IntArray) -> FloatArray:
    """Position (N, 2) of the poses at ``end`` in the frames of those at ``start``."""
    c, s = np.cos(pose[start, 2]), np.sin(pose[start, 2])
    dx, dy = (pose[end, :2] - pose[start, :2]).T
    found: FloatArray = np.column_stack([c * dx + s * dy, -s * dx + c * dy])
    return found
