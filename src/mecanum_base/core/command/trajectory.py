"""Circle with constant spin: the experiment of source D (eq. 24).

    x = R sin(Om t),  y = R cos(Om t)     clockwise from (0, R);     yaw = yaw_0 + spin t

in the world; the twist in platform axes is Rz(-yaw) (x', y'), its speed R Om throughout. The scan
of D24 keeps digits and loses letters: R = 25 is read as cm, the argument as pi t / 7 (t / 7 is as
possible), the spin as pi/30 rad/s. All three are parameters; the defaults are that assumption.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core import se2
from mecanum_base.core.parameter import FloatArray


@dataclass(frozen=True, slots=True)
class CircleSpin:
    """``radius`` R m, ``angular_rate`` Om rad/s clockwise, ``spin`` rad/s, start ``yaw`` rad."""

    radius: float = 0.25
    angular_rate: float = math.pi / 7.0
    spin: float = math.pi / 30.0
    yaw: float = 0.0

    def pose(self, time: float) -> FloatArray:
        """(x m, y m, yaw rad) in the world at ``time`` s (D24); yaw is not wrapped."""
        angle = self.angular_rate * time
        return np.array([self.radius * math.sin(angle), self.radius * math.cos(angle),  # D24
                         self.yaw + self.spin * time])

    def velocity(self, time: float) -> FloatArray:
        """(x' m/s, y' m/s, yaw' rad/s) in world axes at ``time`` s."""
        angle = self.angular_rate * time
        speed = self.radius * self.angular_rate
        return np.array([speed * math.cos(angle), -speed * math.sin(angle), self.spin])

    def twist(self, time: float) -> FloatArray:
        """Twist (3,) in platform axes that follows the reference exactly."""
        velocity = self.velocity(time)
        planar = se2.rotation(-float(self.pose(time)[2])) @ velocity[:2]
        return np.array([planar[0], planar[1], velocity[2]])
