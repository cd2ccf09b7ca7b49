"""Wheel rates for a twist, for both kinds of base, behind one face.

    rates = matrix() @ twist      matrix (W, 3): H of the roller wheels, fixed, or
                                  H(theta) of the carriers, which changes with their hinge angles

Hinge angles are measured where the carrier has a hinge joint, else integrated from what the wheels
were told (midpoint rule on theta' = hinges_from_body(theta) twist; source D, equation 19). With
trailing axles the integral forgets its start, since the carriers align like casters.
"""

from __future__ import annotations

from typing import Protocol, Union

import numpy as np

from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform import differential
from mecanum_base.core.platform.carriers import Carriers


class Geometry(Protocol):
    """What the driver needs to know of a base; ``limits`` (W,) rad/s."""

    limits: FloatArray

    def matrix(self) -> FloatArray:
        """H (W, 3) now: wheel rates = H @ twist."""

    def move(self, twist: FloatArray, dt: float) -> None:
        """Take over that the base was told ``twist`` (3,) for ``dt`` s."""

    def measure(self, angles: FloatArray) -> None:
        """Take over measured hinge angles (C,) rad; NaN = not measured."""


class RollerGeometry:
    """A base on roller wheels: one matrix for all time."""

    def __init__(self, wheels: Wheels) -> None:
        self.limits = wheels.max_speed
        self._matrix = wheels_from_body(wheels)

    def matrix(self) -> FloatArray:
        """H (W, 3), the contact correction included."""
        return self._matrix

    def move(self, twist: FloatArray, dt: float) -> None:
        """Nothing changes."""

    def measure(self, angles: FloatArray) -> None:
        """Roller wheels have no hinges."""


class HingedGeometry:
    """A platform on hinged carriers: the matrix follows the hinge angles."""

    def __init__(self, carriers: Carriers) -> None:
        self._carriers = carriers
        self.limits: FloatArray = np.repeat(carriers.max_speed, 2)
        self.angles: FloatArray = np.array(carriers.initial_angle)

    def matrix(self) -> FloatArray:
        """H (W, 3) at the present hinge angles."""
        return differential.wheels_from_body(self._carriers, self.angles)

    def move(self, twist: FloatArray, dt: float) -> None:
        """Integrate the hinge angles by one midpoint step."""
        slope = differential.hinges_from_body(self._carriers, self.angles) @ twist
        middle = self.angles + slope * (dt / 2.0)
        self.angles = self.angles + dt * (
            differential.hinges_from_body(self._carriers, middle) @ twist)

    def measure(self, angles: FloatArray) -> None:
        """Replace the angles that were measured."""
        self.angles = np.where(np.isnan(angles), self.angles, angles)


def geometry_of(base: Union[Wheels, Carriers]) -> Geometry:
    """The geometry of a wheel or carrier table."""
    return RollerGeometry(base) if isinstance(base, Wheels) else HingedGeometry(base)
