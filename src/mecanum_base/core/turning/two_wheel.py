"""Turns with two driven wheels, the other two locked or free to turn (T eq. 29-33).

LOCKED idle wheels (hub held, rollers free): each lets the base move only across its roller axis,
so the base turns about the crossing of the two locked roller axes. Exact for every roller angle:

    front or rear pair drives, q opposed:  R = y/2 + (x/2) tan(a)   centre on the x' = 0 line   T31
    left or right pair drives, q equal:    R = x/2 + (y/2) cot(a)                               T33

The other sign contradicts the locked wheels (residual not 0): North, East or stall, not a turn.

FREE idle wheels: two driven wheels fix two of three parts of the twist; rotation about the
crossing of the two DRIVEN roller axes stays undetermined. Viscous drag in the idle wheels settles
it: least sum of squared idle rates. Opposed front pair and equal side pair then stop the idle
wheels and turn as with locked ones; the equal front pair and the opposed side pair translate with
the idle wheels turning along. T's radii survive as minimum-drag motion only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mecanum_base.core.kinematics.lines import roller_lines
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.turning.centre import Turn, turn_of_rates, turn_of_twist, twist_about

PARALLEL = 1e-9  # |sine| between two roller axes that never meet


def crossing(wheels: Wheels, first: int, second: int) -> tuple[float, float] | None:
    """(x, y) m where the roller axes of two wheels meet; None where they are parallel."""
    cross = np.cross(*roller_lines(wheels)[[first, second]])
    if abs(cross[2]) < PARALLEL:
        return None
    # lines c . (I_y, -I_x, 1) = 0: the cross product is proportional to (I_y, -I_x, 1)
    return -float(cross[1] / cross[2]), float(cross[0] / cross[2])


def locked_turn(wheels: Wheels, locked: Sequence[int], yaw_rate: float) -> Turn | None:
    """The turn with two ``locked`` wheels (indices) at ``yaw_rate`` rad/s (T30-T33).

    None where the locked roller axes are parallel: then the base can only translate.
    """
    point = crossing(wheels, locked[0], locked[1])
    if point is None:
        return None
    return turn_of_twist(wheels, twist_about(np.array(point), yaw_rate))


def locked_motion(wheels: Wheels, rates: FloatArray) -> Turn:
    """What rates (W,), 0 for locked wheels, make: least squares; residual 0 = no wheel slips."""
    return turn_of_rates(wheels, rates)


def free_motion(wheels: Wheels, driven: Sequence[int], rates: Sequence[float]) -> Turn:
    """The least-drag motion when only the ``driven`` wheels (indices) are held to ``rates`` rad/s.

    Idle wheels turn freely with equal viscous drag. ``residual`` is not 0 where the driven wheels
    contradict each other; ``Turn.rates`` are those of all wheels in that motion.
    """
    matrix = wheels_from_body(wheels)
    held = list(driven)
    idle = [i for i in range(wheels.count) if i not in held]
    wanted = np.asarray(rates, dtype=np.float64)
    twist = np.linalg.pinv(matrix[held]) @ wanted
    _, singular, right = np.linalg.svd(matrix[held])
    rank = int(np.sum(singular > 1e-9 * singular[0]))
    free = right[rank:].T  # (3, F) motions the driven wheels do not resist
    if free.shape[1] and idle:
        twist = twist - free @ (np.linalg.pinv(matrix[idle] @ free) @ (matrix[idle] @ twist))
    turn = turn_of_twist(wheels, twist)
    residual = np.zeros(wheels.count)
    residual[held] = wanted - turn.rates[held]
    return Turn(turn.twist, turn.centre, turn.radius, turn.rates, residual)


def is_determined(wheels: Wheels, driven: Sequence[int]) -> bool:
    """Do the ``driven`` wheels alone, all others free, fix the twist?"""
    return bool(np.linalg.matrix_rank(wheels_from_body(wheels)[list(driven)]) == 3)


def tlale_radii(track: float, wheelbase: float, angle: float) -> tuple[float, float]:
    """(R m with wheels 3, 4 locked, R m with wheels 2, 3 locked) of source T (T31, T33).

    ``track`` x and ``wheelbase`` y are full lengths [m], ``angle`` |roller angle| rad.
    """
    return (0.5 * wheelbase + 0.5 * track * math.tan(angle),  # T eq. 31
            0.5 * track + 0.5 * wheelbase / math.tan(angle))  # T eq. 33


def tlale_driven_radii(track: float, wheelbase: float, angle: float) -> tuple[float, float]:
    """Distances [m] of the driven wheels from the centre of rotation (T30, T32)."""
    return (math.hypot(0.5 * track, wheelbase + 0.5 * track * math.tan(angle)),  # T eq. 30
            math.hypot(0.5 * wheelbase, track + 0.5 * wheelbase / math.tan(angle)))  # T eq. 32
