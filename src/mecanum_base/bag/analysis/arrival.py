"""How late sensor messages come into the merge by stamp, and the wait that this asks for.

    behind_i = max(0, max_(j < i) stamp_j - stamp_i)      i, j in order of arrival, all sensors

A message with behind > estimator.reorder_wait is dropped (core/estimation/ordering.py). Stamps of
the IMU that are moved back by ``imu.late`` are behind by as much where its driver stamps what it
reads late; where they come from a clock ahead, they are not. Only the order of arrival tells.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.bag.analysis.recording import Series
from mecanum_base.core.parameter import FloatArray, IntArray

_SHARE = 0.01  # of the messages of a topic may be dropped more than before
_MOST = 99.0  # percentile of the messages that the new wait is for
_RESERVE = 0.01  # s beyond these
_STEP = 0.01  # s, to which a wait is rounded up


@dataclass(frozen=True, slots=True, eq=False)
class Arrivals:
    """Encoder and IMU messages in order of arrival: stamps (N,) and which are of the IMU."""

    stamp_ns: IntArray
    inertial: IntArray

    def behind(self, moved_ns: int) -> FloatArray:
        """Seconds (N,) by which each lies behind the newest before it, with the stamps of the
        IMU ``moved_ns`` back."""
        stamp = self.stamp_ns - np.where(self.inertial, moved_ns, 0)
        newest = np.maximum.accumulate(np.concatenate((stamp[:1], stamp)))[:-1]
        found: FloatArray = np.maximum(newest - stamp, 0) / 1e9
        return found

    def wait(self, moved_ns: int, wait: float) -> float | None:
        """The reorder wait [s] for stamps of the IMU that are ``moved_ns`` further back; None
        where ``wait`` still does."""
        if not len(self.stamp_ns):
            return None
        before, after = self.behind(0), self.behind(moved_ns)
        needed = wait
        for chosen in (self.inertial == 0, self.inertial == 1):
            if not chosen.any():
                continue
            lost = float(np.mean(after[chosen] > wait) - np.mean(before[chosen] > wait))
            if lost > _SHARE:
                usual = float(np.percentile(after[chosen], _MOST)) + _RESERVE
                needed = max(needed, math.ceil(usual / _STEP - 1e-9) * _STEP)
        return None if needed == wait else round(needed, 3)


def arrivals(encoder: Series, imu: Series | None, late_ns: int = 0) -> Arrivals:
    """The messages of both topics by log time, ``late_ns`` off the stamps of the IMU."""
    log, stamp = encoder.log_ns, encoder.stamp_ns
    inertial = np.zeros(len(encoder), dtype=np.int64)
    if imu is not None:
        log = np.concatenate((log, imu.log_ns))
        stamp = np.concatenate((stamp, imu.stamp_ns - late_ns))
        inertial = np.concatenate((inertial, np.ones(len(imu), dtype=np.int64)))
    order = np.argsort(log, kind='stable')
    return Arrivals(stamp[order], inertial[order])
