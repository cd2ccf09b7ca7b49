"""Turn about the contact point of one wheel (T eq. 24-28 corrected).

The pivot wheel stands, the others run at rates in the ratio of their levers; for pivot wheel 3 of
source T (RL)

    w = r q1 / (x + y cot a) = -r q2 tan(a) / y = r q4 / x                         T25 corrected
    v = |w| R,   R = sqrt(x^2 + y^2) / 2 from the pivot to the centre              T26

Equal rates "+-0+" do not satisfy it: their parity is -1, something slips. Works for any base;
exact for every roller angle.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.turning.centre import Turn, turn_of_twist, twist_about


def pivot_turn(wheels: Wheels, pivot: int, yaw_rate: float) -> Turn:
    """The turn with ``yaw_rate`` rad/s about the wheel with index ``pivot``."""
    point = np.array([wheels.x[pivot], wheels.y[pivot]])
    return turn_of_twist(wheels, twist_about(point, yaw_rate))


def pivot_yaw_rate(track: float, wheelbase: float, angle: float, radius: float,
                   opposite_rate: float) -> float:
    """w [rad/s] about RL from the rate q1 [rad/s] of the wheel diagonally opposite (T25).

    ``track`` x and ``wheelbase`` y are full lengths [m], ``angle`` rad, ``radius`` m.
    """
    return radius * opposite_rate / (track + wheelbase / math.tan(angle))  # T eq. 25 corrected


def spin_yaw_rate(track: float, wheelbase: float, angle: float, radius: float,
                  rates: FloatArray) -> float:
    """w [rad/s] about the centre from the rates (4,) of wheels 1..4 of source T (T20, T24)."""
    lever = 0.5 * (track + wheelbase / math.tan(angle))  # ly + lx cot
    return float(radius * (rates @ np.array([1.0, -1.0, -1.0, 1.0])) / (4.0 * lever))
