"""Slip of each wheel along its roller axis: Tlale's s and the slip speed (T eq. 4 corrected).

With t = -sign(sin delta) (cos, sin)(alpha + delta), the direction in which a positive rate pushes:

    d    = r u |sin delta| dT         travel the encoder predicts along the roller
    d_r  = (v_A . t) dT               travel of the wheel centre along the roller
    s    = d_r / d                    1 = no slip, < 1 the wheel spins, > 1 it is dragged     (T4)
    sigma = r |sin delta| (u - H V)   slip speed [m/s] = (d - d_r)/dT, finite at u = 0

s is undefined (NaN) where the wheel does not turn. The print of T4 swaps the two travels and
counts n and sin(delta) twice; with the travel of the platform instead of the part along the roller
perfect rolling would give s = 1.41.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray


def push_directions(wheels: Wheels) -> FloatArray:
    """t (W, 2): unit vectors along the rollers in which a positive rate pushes the base."""
    direction = wheels.axle + wheels.roller
    unit = np.column_stack([np.cos(direction), np.sin(direction)])
    pushed: FloatArray = -np.sign(np.sin(wheels.roller))[:, None] * unit
    return pushed


def wheel_travel(wheels: Wheels, rates: FloatArray, interval: float) -> FloatArray:
    """d (W,) m: travel along the rollers that rates (W,) rad/s predict over ``interval`` s."""
    travel: FloatArray = wheels.radius * np.abs(np.sin(wheels.roller)) * rates * interval
    return travel


def real_travel(wheels: Wheels, twist: FloatArray, interval: float, *,
                corrected: bool = True) -> FloatArray:
    """d_r (W,) m: travel of the wheel centres along the rollers at the true ``twist`` (3,).

    ``corrected`` counts sideways travel as the wheel sees it on average (mean contact
    correction); without it this is v_A . t of the nominal roller axis.
    """
    rolling = wheels_from_body(wheels, corrected=corrected) @ twist
    return wheel_travel(wheels, rolling, interval)


def slip_speed(wheels: Wheels, rates: FloatArray, twist: FloatArray, *,
               corrected: bool = True) -> FloatArray:
    """sigma (W,) m/s along the rollers: rim minus ground, finite at any rate."""
    speed: FloatArray = (wheel_travel(wheels, rates, 1.0)
                         - real_travel(wheels, twist, 1.0, corrected=corrected))
    return speed


def slip_ratio(wheels: Wheels, rates: FloatArray, twist: FloatArray, *,
               corrected: bool = True) -> FloatArray:
    """s (W,) = d_r / d (T4 corrected); NaN where the wheel stands. The slip is 1 - s."""
    with np.errstate(divide='ignore', invalid='ignore'):
        ratio = (real_travel(wheels, twist, 1.0, corrected=corrected)
                 / wheel_travel(wheels, rates, 1.0))  # T eq. 4
    return np.where(rates == 0.0, np.nan, ratio)
