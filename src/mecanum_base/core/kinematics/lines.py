"""Roller axes on the ground as lines, and the motion they leave free (G eq. 17, Theorem 2).

Row i of M describes the line through the wheel centre along the roller axis, s = alpha + delta:

    M_i = (cos s, sin s, x sin s - y cos s)    [-, -, m]       H = -diag(1/(r sin delta)) M

M V is the velocity of the wheel centres along the rollers. Where M V = 0 for some V, no wheel
resists V, the self-motion: a rotation if all lines meet in one point, a translation across them if
all are parallel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

TURNING = 1e-6  # share of the yaw part of a twist below which it counts as a translation


@dataclass(frozen=True, slots=True, eq=False)
class SelfMotion:
    """A motion in words and numbers.

    ``kind`` rotation or translation; ``twist`` (3,): for a rotation per rad/s of yaw, for a
    translation of 1 m/s; ``centre`` (x, y) m in base_link of a rotation, else None.
    """

    kind: str
    twist: FloatArray
    centre: tuple[float, float] | None

    def text(self) -> str:
        """For instance: rotation about the point (0.1, 0) m."""
        if self.centre is not None:
            x, y = (round(value, 9) + 0.0 for value in self.centre)
            return f'rotation about the point ({x:.4g}, {y:.4g}) m'
        bearing = math.degrees(math.atan2(self.twist[1], self.twist[0])) % 180.0
        return f'translation along the bearing {bearing:.4g} deg'


def roller_lines(wheels: Wheels) -> FloatArray:
    """M (W, 3): roller axes on the ground, nominal contact (G eq. 17)."""
    direction = wheels.axle + wheels.roller
    sine, cosine = np.sin(direction), np.cos(direction)
    return np.column_stack([cosine, sine, wheels.x * sine - wheels.y * cosine])  # G eq. 17


def name_motion(twist: FloatArray, reach: float = 1.0) -> SelfMotion:
    """The twist (3,) as rotation or translation; ``reach`` m weighs yaw against translation."""
    turn = float(twist[2]) * reach
    if abs(turn) > TURNING * math.hypot(float(twist[0]), float(twist[1]), turn):
        scaled = twist / twist[2]
        # Theorem 2: V ~ (I_y, -I_x, 1) turns about I
        return SelfMotion('rotation', scaled, (-float(scaled[1]), float(scaled[0])))
    straight = np.array([twist[0], twist[1], 0.0])
    return SelfMotion('translation', straight / np.linalg.norm(straight), None)
