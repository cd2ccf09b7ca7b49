"""Reference curves a base follows: pose as a smooth function of time, starting at 0, 0, 0.

    legs       straight moves between poses, speed with raised-cosine edges of t_r = pi v / (2 a)
               up to v and down, T = d/v + t_r; short moves reach sqrt(2 a d/pi) only
    circle     (R sin a, R (1 - cos a)), a = v t / R, with its own yaw rate ``spin``
    figure8    (A sin a, (B/2) sin 2a), with its own yaw rate

Curves start from rest by a time warp: time runs at rate t/ramp during the first ``ramp`` seconds.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable
from typing import NamedTuple

Pose = tuple[float, float, float]
Curve = Callable[[float], tuple[Pose, Pose]]  # time [s] -> pose, rate of the pose (floor axes)


class Leg(NamedTuple):
    """One move: from time ``begin`` for ``last`` seconds, edges of ``edge`` seconds."""

    begin: float
    last: float
    edge: float
    start: Pose
    goal: Pose

    def share(self, t: float) -> tuple[float, float]:
        """(share of the way done, its rate [1/s]) ``t`` seconds after the begin."""
        cruise = 1.0 / (self.last - self.edge)
        if t > self.last / 2.0:  # the end is the beginning seen backwards
            done, rate = self.share(self.last - t) if t < self.last else (0.0, 0.0)
            return 1.0 - done, rate
        if t >= self.edge:
            return cruise * (t - self.edge / 2.0), cruise
        turn = math.pi * t / self.edge
        return (cruise / 2.0 * (t - self.edge / math.pi * math.sin(turn)),
                cruise / 2.0 * (1.0 - math.cos(turn)))


def _pace(way: float, speed: float, accel: float) -> tuple[float, float]:
    """(cruise time, edge time) [s] of a move of length ``way``."""
    top = min(speed, math.sqrt(2.0 * accel * way / math.pi))
    return (way / top, math.pi * top / (2.0 * accel)) if top > 0.0 else (0.0, 0.0)


def legs(points: list[tuple[float, float, float, float]], speed: float, turn_speed: float,
         accel: float, *, repeat: bool = False) -> Curve:
    """Moves through ``points`` (x, y, yaw, pause after arrival); ``repeat``: round and round."""
    found: list[Leg] = []
    time, here = 0.0, (0.0, 0.0, 0.0)
    for x, y, yaw, pause in points:
        goal = (x, y, yaw)
        cruise, edge = _pace(math.hypot(x - here[0], y - here[1]), speed, accel)
        turning, bend = _pace(abs(yaw - here[2]), turn_speed, accel * turn_speed / speed)
        edge = max(edge, bend)
        last = max(cruise, turning, edge) + edge
        if last > 0.0:
            found.append(Leg(time, last, edge, here, goal))
        time += last + pause
        here = goal
    begins = [leg.begin for leg in found]
    total = time

    def at(t: float) -> tuple[Pose, Pose]:
        if repeat and total > 0.0:
            t %= total
        k = bisect.bisect_right(begins, t) - 1
        if k < 0:
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        leg = found[k]
        share, rate = leg.share(t - leg.begin)
        dx, dy, dyaw = (g - s for g, s in zip(leg.goal, leg.start))
        x, y, yaw = leg.start
        return ((x + share * dx, y + share * dy, yaw + share * dyaw),
                (rate * dx, rate * dy, rate * dyaw))

    return at


def _warped(ramp: float, curve: Callable[[float], tuple[Pose, Pose]]) -> Curve:
    def at(t: float) -> tuple[Pose, Pose]:
        if t <= 0.0:
            return curve(0.0)[0], (0.0, 0.0, 0.0)
        warped, pace = (t * t / (2.0 * ramp), t / ramp) if t < ramp else (t - ramp / 2.0, 1.0)
        pose, rate = curve(warped)
        return pose, (pace * rate[0], pace * rate[1], pace * rate[2])

    return at


def circle(radius: float, speed: float, spin: float, ramp: float) -> Curve:
    """A circle to the left at ``speed`` [m/s] while yaw turns at ``spin`` [rad/s]."""
    def at(t: float) -> tuple[Pose, Pose]:
        a = speed * t / radius
        return ((radius * math.sin(a), radius * (1.0 - math.cos(a)), spin * t),
                (speed * math.cos(a), speed * math.sin(a), spin))

    return _warped(ramp, at)


def figure8(length: float, width: float, speed: float, spin: float, ramp: float) -> Curve:
    """A lying eight, ``length`` x ``width`` [m], largest speed ``speed``; yaw turns at spin."""
    a0, b0 = length / 2.0, width / 2.0
    omega = speed / math.hypot(a0, 2.0 * b0)

    def at(t: float) -> tuple[Pose, Pose]:
        a = omega * t
        return ((a0 * math.sin(a), b0 * math.sin(2.0 * a), spin * t),
                (a0 * omega * math.cos(a), 2.0 * b0 * omega * math.cos(2.0 * a), spin))

    return _warped(ramp, at)
