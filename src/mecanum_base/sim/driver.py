"""Who drives: a script of twists, or a follower of a curve that sees the true pose.

    follower   twist = R(yaw)^T (rate of the curve + K (curve - pose)),  K [1/s]

A driver answers ``twist(time, pose)`` with a twist in base_link; it keeps no state but the slew of
a script, so it may be asked at any rate, in order of time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from mecanum_base.sim.curves import Curve, Pose

Twist = tuple[float, float, float]


class Driver(Protocol):
    """Anything that says how to drive."""

    def twist(self, time: float, pose: Sequence[float]) -> Twist:
        """Wanted (vx, vy, wz) in base_link at ``time`` [s] since the start, at the true pose."""
        ...


class Idle:
    """Nobody drives."""

    def twist(self, time: float, pose: Sequence[float]) -> Twist:
        """Stand still."""
        return 0.0, 0.0, 0.0


class Script:
    """Twists one after the other, each for some seconds; changes limited by ``accel`` (3,)."""

    def __init__(self, segments: list[tuple[float, Twist]], accel: Twist, *,
                 repeat: bool = False) -> None:
        self._segments, self._accel, self._repeat = segments, accel, repeat
        self._total = sum(seconds for seconds, _ in segments)
        self._time, self._last = 0.0, (0.0, 0.0, 0.0)

    def twist(self, time: float, pose: Sequence[float]) -> Twist:
        """The twist of the segment at ``time``, approached no faster than the limits."""
        wanted = self._wanted(time % self._total if self._repeat and self._total else time)
        step = max(time - self._time, 0.0)
        out = []
        for now, want, limit in zip(self._last, wanted, self._accel):
            change = want - now
            if limit > 0.0:
                change = min(max(change, -limit * step), limit * step)
            out.append(now + change)
        self._time, self._last = time, (out[0], out[1], out[2])
        return self._last

    def _wanted(self, time: float) -> Twist:
        for seconds, twist in self._segments:
            if time < seconds:
                return twist
            time -= seconds
        return 0.0, 0.0, 0.0


class Follower:
    """Follows a curve after standing still for ``wait`` seconds; ``gain`` 1/s pulls it back."""

    def __init__(self, curve: Curve, wait: float, gain: float, limit: Twist) -> None:
        self._curve, self._wait, self._gain, self._limit = curve, wait, gain, limit

    def reference(self, time: float) -> Pose:
        """Where the base should be."""
        return self._curve(max(time - self._wait, 0.0))[0]

    def twist(self, time: float, pose: Sequence[float]) -> Twist:
        """Feed-forward along the curve and feedback towards it, cut at the limits."""
        if time < self._wait:
            return 0.0, 0.0, 0.0
        goal, rate = self._curve(time - self._wait)
        u, v, w = (r + self._gain * (g - float(p)) for r, g, p in zip(rate, goal, pose))
        c, s = math.cos(pose[2]), math.sin(pose[2])
        wanted = (c * u + s * v, c * v - s * u, w)
        vx, vy, wz = (min(max(t, -m), m) for t, m in zip(wanted, self._limit))
        return vx, vy, wz
