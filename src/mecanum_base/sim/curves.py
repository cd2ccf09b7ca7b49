"""Reference curves a base follows: pose as a smooth function of time, starting at 0, 0, 0.

    legs       straight moves between poses; share s(t) = t/T - sin(2 pi t/T) / (2 pi), so speed
               and acceleration start and end at zero: T = max(2 d/v_max, sqrt(2 pi d/a_max))
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
    """One move: from time ``begin`` for ``last`` seconds from one pose to the next."""

    begin: float
    last: float
    start: Pose
    goal: Pose


def legs(points: list[tuple[float, float, float, float]], speed: float, turn_speed: float,
         accel: float, *, repeat: bool = False) -> Curve:
    """Moves through ``points`` (x, y, yaw, pause after arrival); ``repeat``: round and round."""
    found: list[Leg] = []
    time, here = 0.0, (0.0, 0.0, 0.0)
    for x, y, yaw, pause in points:
        goal = (x, y, yaw)
        way = math.hypot(x - here[0], y - here[1])
        turn = abs(yaw - here[2])
        angular = accel * turn_speed / speed
        last = max(2.0 * way / speed, math.sqrt(2.0 * math.pi * way / accel),
                   2.0 * turn / turn_speed, math.sqrt(2.0 * math.pi * turn / angular))
        if last > 0.0:
            found.append(Leg(time, last, here, goal))
        time += last + pause
        here = goal
    begins = [leg.begin for leg in found]
    total, end = time, here

    def at(t: float) -> tuple[Pose, Pose]:
        if repeat and total > 0.0:
            t %= total
        k = bisect.bisect_right(begins, t) - 1
        if k < 0:
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        leg = found[k]
        u = (t - leg.begin) / leg.last
        if u >= 1.0:
            return (leg.goal if k + 1 < len(found) else end), (0.0, 0.0, 0.0)
        share = u - math.sin(2.0 * math.pi * u) / (2.0 * math.pi)
        rate = (1.0 - math.cos(2.0 * math.pi * u)) / leg.last
        change = [g - s for g, s in zip(leg.goal, leg.start)]
        x, y, yaw = (s + share * c for s, c in zip(leg.start, change))
        return (x, y, yaw), (rate * change[0], rate * change[1], rate * change[2])

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
