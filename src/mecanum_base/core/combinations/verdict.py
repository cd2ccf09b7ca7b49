"""What one combination of wheel rates does to a base, and whether it can do it without slip.

With H V = u + slip, n the null vector of H (n H = 0, four wheels) and u the rates, idle wheels 0:

    parity      n . u: 0 = the rates fit one rigid motion with the idle wheels locked (no slip)
    twist       least squares, idle wheels held, slip shared
    stalls      idle wheels locked, equal loads, Coulomb friction: the roller forces can only
                balance in the pattern c n, so the base stays at rest exactly if all driven
                entries agree in sign with n, or all with -n
    free idle   idle wheels turning freely: the driven wheels alone fix the twist ('unique'),
                leave some of it open ('underdetermined'), contradict each other ('slip'), or none
                is driven ('stop')

Not modelled: unequal loads, rolling resistance, idle-wheel drag (models.md section 5 says how far
each of them moves the counts).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels, null_vector
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

TOLERANCE = 1e-9  # relative: below this a rate, parity or twist counts as 0


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """One combination of rates (4,) rad/s.

    ``driven`` number of wheels that turn; ``parity`` n . u rad/s; ``twist`` (3,) least squares,
    base_link; ``bearing`` rad from base_link x of the translation, NaN without one; ``no_slip``,
    ``stalls`` with idle wheels locked; ``free_idle`` unique, underdetermined, slip or stop.
    """

    rates: FloatArray
    driven: int
    parity: float
    twist: FloatArray
    bearing: float
    no_slip: bool
    stalls: bool
    free_idle: str

    @property
    def moves(self) -> bool:
        """The least-squares twist is not 0."""
        return bool(np.any(self.twist))


def judge(wheels: Wheels, rates: FloatArray) -> Verdict:
    """The verdict on rates (4,) rad/s, 0 = not driven; ValueError unless the base has 4 wheels."""
    if wheels.count != 4:
        raise ValueError(f'combinations are defined for 4 wheels, not {wheels.count}')
    matrix = wheels_from_body(wheels)
    null = null_vector(matrix)
    size = float(np.max(np.abs(rates))) or 1.0
    parity = float(null @ rates)
    parity = parity if abs(parity) > TOLERANCE * size else 0.0
    twist = _clean(body_from_wheels(matrix) @ rates, matrix, size)
    still = math.hypot(twist[0], twist[1]) == 0.0
    signs = np.sign(np.where(np.abs(null) > TOLERANCE, null, 0.0)) * np.sign(rates)
    driven = rates != 0.0
    return Verdict(
        rates=rates, driven=int(np.sum(driven)), parity=parity, twist=twist,
        bearing=math.nan if still else math.atan2(twist[1], twist[0]),
        no_slip=parity == 0.0,
        stalls=bool(np.all(signs[driven] > 0.0) or np.all(signs[driven] < 0.0)),
        free_idle=_free_idle(matrix[driven], rates[driven], size))


def _clean(twist: FloatArray, matrix: FloatArray, size: float) -> FloatArray:
    """Parts of the twist that are rounding, judged by the wheel rates they would cause, as 0."""
    effect = np.abs(twist) * np.max(np.abs(matrix), axis=0)
    return np.where(effect > TOLERANCE * size, twist, 0.0)


def _free_idle(matrix: FloatArray, rates: FloatArray, size: float) -> str:
    if not len(rates):
        return 'stop'
    residual = rates - matrix @ (np.linalg.pinv(matrix) @ rates)
    if float(np.max(np.abs(residual))) > TOLERANCE * size:
        return 'slip'
    return 'unique' if np.linalg.matrix_rank(matrix) == 3 else 'underdetermined'
