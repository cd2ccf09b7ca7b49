"""A torus instead of the exact roller: easy to turn, and good to a few micrometres (G eq. 6-9).

The torus that has third-order contact with the roller in its middle (G Theorem 1):

    r_t = d / sin^2(delta)          radius of the centre circle, on the far side of the axis   G8
    r_m = r + d cot^2(delta)        radius of the meridian circle (spindle torus: r_m > r_t)    G9
    f(u) = X*^2 + (Z* - r_t)^2 - r_m^2 = 0 to third order, Z* = -R* of the meridian        G6, G7
    meridian deviation  ~ d cos^2(delta) u^4 / 8
    axis height         H(u) = d cos u + r_m - r_t sqrt(1 - sin^2(delta) sin^2 u), dip as above
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.roller.shape import RollerShape, meridian


@dataclass(frozen=True, slots=True)
class Torus:
    """``centre_radius`` r_t [m] and ``meridian_radius`` r_m [m]."""

    centre_radius: float
    meridian_radius: float


def torus_of(shape: RollerShape) -> Torus:
    """The torus that osculates the roller in its middle (G eq. 8, 9)."""
    sine = math.sin(shape.angle)
    cot = math.cos(shape.angle) / sine
    return Torus(shape.pin_radius / sine**2,  # G eq. 8
                 shape.radius + shape.pin_radius * cot**2)  # G eq. 9


def torus_equation(shape: RollerShape, u: FloatArray) -> FloatArray:
    """f (N,) m^2 at the exact meridian: 0 where it lies on the torus (G eq. 6, 7)."""
    torus = torus_of(shape)
    along, radius = meridian(shape, u)
    value: FloatArray = (along**2 + (-radius - torus.centre_radius)**2
                         - torus.meridian_radius**2)  # G eq. 6
    return value


def meridian_deviation(shape: RollerShape, u: FloatArray) -> FloatArray:
    """(N,) m: distance of the exact meridian from the torus, > 0 where the torus is inside."""
    torus = torus_of(shape)
    along, radius = meridian(shape, u)
    gap: FloatArray = np.hypot(along, radius + torus.centre_radius) - torus.meridian_radius
    return gap


def axis_height_error(shape: RollerShape, u: FloatArray) -> FloatArray:
    """(N,) m: height of the wheel axis on torus rollers minus r, at wheel angles u (N,) rad."""
    torus = torus_of(shape)
    sine = math.sin(shape.angle)
    height = (shape.pin_radius * np.cos(u) + torus.meridian_radius
              - torus.centre_radius * np.sqrt(1.0 - (sine * np.sin(u))**2))
    error: FloatArray = height - shape.radius
    return error


def axis_height_error_leading(shape: RollerShape, u: FloatArray) -> FloatArray:
    """(N,) m: leading term of the same, -d cos^2(delta) u^4 / 8 (G Theorem 1: order 3)."""
    value: FloatArray = -shape.pin_radius * math.cos(shape.angle)**2 * u**4 / 8.0
    return value


def torus_radius(shape: RollerShape, along: FloatArray) -> FloatArray:
    """(N,) m: radius of the torus roller at positions (N,) m along its axis (G eq. 6 solved)."""
    torus = torus_of(shape)
    radius: FloatArray = np.sqrt(torus.meridian_radius**2 - along**2) - torus.centre_radius
    return radius
