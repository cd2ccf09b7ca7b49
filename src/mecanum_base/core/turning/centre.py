"""About which point does the base turn? Instantaneous centre of any twist or wheel rates.

    V = w (P_y, -P_x, 1)  <=>  rotation with w about P = (-vy/w, vx/w)              (T29, exact)

Wheel rates of a rotation about P are H V; the printed T24 and T25 hold only for roller angles
with tan(alpha) = x/y. Where the wheels disagree, the centre is that of the least-squares twist,
and the residual says by how much they disagree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

STRAIGHT = 1e-9  # rad per m of travel below which the path counts as straight


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """A turn of the base.

    ``twist`` (3,) of the geometric centre; ``centre`` (x, y) m in base_link, None for a
    translation; ``radius`` m from the geometric centre, inf for a translation; ``rates`` (W,)
    rad/s; ``residual`` (W,) rad/s by which the rates contradict one rigid motion.
    """

    twist: FloatArray
    centre: tuple[float, float] | None
    radius: float
    rates: FloatArray
    residual: FloatArray


def twist_about(point: FloatArray, yaw_rate: float) -> FloatArray:
    """Twist (3,) of a rotation with ``yaw_rate`` rad/s about ``point`` (2,) m, base_link (T29)."""
    return np.array([yaw_rate * point[1], -yaw_rate * point[0], yaw_rate])


def centre_of(twist: FloatArray) -> tuple[float, float] | None:
    """(x, y) m in base_link about which the base turns; None for a translation or rest."""
    speed, yaw_rate = math.hypot(float(twist[0]), float(twist[1])), float(twist[2])
    if abs(yaw_rate) <= STRAIGHT * speed or yaw_rate == 0.0:
        return None
    return -float(twist[1]) / yaw_rate, float(twist[0]) / yaw_rate


def turn_of_twist(wheels: Wheels, twist: FloatArray) -> Turn:
    """The turn that the ``twist`` (3,) is, with the wheel rates it takes."""
    rates = wheels_from_body(wheels) @ twist
    return _turn(twist, rates, np.zeros(wheels.count))


def turn_of_rates(wheels: Wheels, rates: FloatArray) -> Turn:
    """The turn that wheel rates (W,) rad/s make, least squares where they disagree."""
    matrix = wheels_from_body(wheels)
    twist = body_from_wheels(matrix) @ rates
    return _turn(twist, rates, rates - matrix @ twist)


def _turn(twist: FloatArray, rates: FloatArray, residual: FloatArray) -> Turn:
    centre = centre_of(twist)
    radius = math.inf if centre is None else math.hypot(*centre)
    return Turn(twist, centre, radius, rates, residual)


def velocity_bearing(twist: FloatArray, heading: float) -> float:
    """Bearing [rad] of the centre's velocity in the world, body bearing added (T27, T28).

    T prints the bearing as the heading alone; that holds only for a centre of rotation abeam.
    """
    return heading + math.atan2(float(twist[1]), float(twist[0]))
