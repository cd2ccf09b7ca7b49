"""Velocity of a rectangular base in the terms of source T (T eq. 17-23 corrected).

T numbers the wheels 1 = FR, 2 = FL, 3 = RL, 4 = RR, uses full lengths x (track) and y (wheelbase)
and axes x' = right, y' = forward. Adding the roller speeds v_i = r q_i sin(alpha), as T18 and T19
do, gives 4 sin^2 and 4 cos^2 times the velocity: twice it at 45 degrees, and for other angles even
the direction is wrong. Corrected:

    forward = (r/4) sum q_i                                                        T19
    right   = (r tan(alpha)/4) sum (-1)^i q_i                                      T18
    w       = r (q1 - q2 - q3 + q4) / (4 (lx cot(alpha) + ly))                     T20
    X' = cos(phi) forward + sin(phi) right                                         T21
    Y' = sin(phi) forward - cos(phi) right        (printed with +: wrong)          T22
    beta = atan2(Y', X')                          (printed arctan: wrong quadrant) T23
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.parameter import FloatArray

_EVEN = np.array([-1.0, 1.0, -1.0, 1.0])  # (-1)^i for i = 1..4
_TURN = np.array([1.0, -1.0, -1.0, 1.0])


def roller_speeds(radius: float, angle: float, rates: FloatArray) -> FloatArray:
    """v_i (4,) m/s along the rollers of wheels 1..4 (T17, without SIG: rates are signed)."""
    speed: FloatArray = radius * rates * math.sin(angle)  # T eq. 17
    return speed


def printed_sums(radius: float, angle: float, rates: FloatArray) -> tuple[float, float]:
    """(right, forward) m/s as T18 and T19 add them, T19 without (-1)^i; not velocities."""
    speed = roller_speeds(radius, angle, rates)
    return (float(_EVEN @ speed) * math.cos(angle),  # T eq. 18 as printed, K = 1
            float(np.sum(speed)) * math.sin(angle))  # T eq. 19 without (-1)^i


def twist_from_rates(track: float, wheelbase: float, radius: float, angle: float,
                     rates: FloatArray) -> FloatArray:
    """Twist (3,) in base_link (x forward, y left) from rates (4,) of wheels 1..4 (T18-T20)."""
    forward = radius / 4.0 * float(np.sum(rates))  # T eq. 19 corrected
    right = radius * math.tan(angle) / 4.0 * float(_EVEN @ rates)  # T eq. 18 corrected
    lever = 0.5 * wheelbase / math.tan(angle) + 0.5 * track
    return np.array([forward, -right, radius * float(_TURN @ rates) / (4.0 * lever)])  # T eq. 20


def world_velocity(heading: float, forward: float, right: float) -> FloatArray:
    """(X', Y') m/s; ``heading`` rad from world X to the forward axis (T21, T22 corrected)."""
    c, s = math.cos(heading), math.sin(heading)
    return np.array([c * forward + s * right, s * forward - c * right])  # T eq. 21, 22


def travel_bearing(velocity: FloatArray) -> float:
    """beta [rad] of a world velocity (2,), all four quadrants (T23 corrected)."""
    return math.atan2(float(velocity[1]), float(velocity[0]))  # T eq. 23
