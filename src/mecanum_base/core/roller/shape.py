"""The roller that keeps the wheel axis at constant height r (G eq. 1-5).

Frame S: origin in the wheel centre, x along the wheel axle, z up; the roller axis passes through
(0, 0, -d) along (cos delta, sin delta, 0). Frame S*: origin in (0, 0, -d), x* along the roller
axis, z* up. u is the wheel angle, |u| < u_K = acos(d/r); r, d in m, delta in rad.

    contact curve in S    c(u)  = (d cot(delta) tan u, r sin u, -r cos u)                   G2
    ... in S*             c*(u) = (d cos^2/sin tan u + r sin(delta) sin u,                  G3
                                   cos(delta) tan u (r cos u - d), d - r cos u)
    roller surface        c*(u) turned by v about x*                                        G4
    meridian    X*(u) = c*_1(u),  R*(u) = sqrt(cos^2(delta) tan^2 u + 1) (r cos u - d)      G5

For delta = 90 deg the meridian is the circle of radius r itself. Source: Gfrerrer 2008.
Not modelled: flexible rollers, collision of neighbours (see sizing.neighbour_clearance).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray

_PARALLEL = 1e-3  # rad, as for the wheel table: such rollers carry no drive


@dataclass(frozen=True, slots=True)
class RollerShape:
    """``radius`` r of the wheel [m], ``pin_radius`` d [m], ``angle`` delta [rad], any sign.

    Raises ConfigError unless 0 < d < r and the roller is not parallel to the axle.
    """

    radius: float
    pin_radius: float
    angle: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.radius) and self.radius > 0.0):
            raise ConfigError('radius', self.radius, 'must be > 0', 'm')
        if not 0.0 < self.pin_radius < self.radius:
            raise ConfigError('pin_radius', self.pin_radius,
                              f'must be > 0 and below the wheel radius {self.radius:g}', 'm')
        if not (math.isfinite(self.angle) and abs(math.sin(self.angle)) >= _PARALLEL):
            raise ConfigError('angle', self.angle, 'must not be 0 or pi: rollers parallel to the '
                              'axle cannot drive', 'rad')

    @property
    def knot(self) -> float:
        """u_K [rad]: wheel angle at which the roller ends in a point, cos u_K = d/r."""
        return math.acos(self.pin_radius / self.radius)

    @property
    def equator_radius(self) -> float:
        """Radius [m] of the roller in its middle, r - d."""
        return self.radius - self.pin_radius


def contact_curve(shape: RollerShape, u: FloatArray) -> FloatArray:
    """(N, 3) m in S: points of the roller that touch the ground, wheel angle u (N,) (G eq. 2)."""
    cot = math.cos(shape.angle) / math.sin(shape.angle)
    return np.column_stack([shape.pin_radius * cot * np.tan(u), shape.radius * np.sin(u),
                            -shape.radius * np.cos(u)])  # G eq. 2


def contact_curve_of_roller(shape: RollerShape, u: FloatArray) -> FloatArray:
    """(N, 3) m in S*: the same curve in axes of the roller (G eq. 3)."""
    r, d = shape.radius, shape.pin_radius
    sine, cosine = math.sin(shape.angle), math.cos(shape.angle)
    return np.column_stack([
        d * cosine**2 / sine * np.tan(u) + r * sine * np.sin(u),  # G eq. 3
        cosine * np.tan(u) * (r * np.cos(u) - d),
        d - r * np.cos(u)])


def surface(shape: RollerShape, u: FloatArray, v: FloatArray) -> FloatArray:
    """(N, 3) m in S*: roller surface at wheel angles u (N,) and turns v (N,) rad (G eq. 4)."""
    x, y, z = contact_curve_of_roller(shape, u).T
    return np.column_stack([x, y * np.cos(v) - z * np.sin(v), y * np.sin(v) + z * np.cos(v)])


def meridian(shape: RollerShape, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(X* (N,), R* (N,)) m: position along the roller axis and roller radius there (G eq. 5)."""
    along = contact_curve_of_roller(shape, u)[:, 0]
    stretch = np.sqrt(math.cos(shape.angle)**2 * np.tan(u)**2 + 1.0)
    radius: FloatArray = stretch * (shape.radius * np.cos(u) - shape.pin_radius)  # G eq. 5
    return along, radius


def knot_point(shape: RollerShape) -> FloatArray:
    """K (3,) m in S: where the roller would end in a point; the other knot is its mirror image."""
    side = math.sqrt(shape.radius**2 - shape.pin_radius**2)
    cot = math.cos(shape.angle) / math.sin(shape.angle)
    return np.array([side * cot, side, -shape.pin_radius])


def wheel_from_roller(shape: RollerShape, points: FloatArray) -> FloatArray:
    """Points (N, 3) m of S* in axes of S: turned by delta about z, lowered by d."""
    c, s = math.cos(shape.angle), math.sin(shape.angle)
    x, y, z = points.T
    return np.column_stack([c * x - s * y, s * x + c * y, z - shape.pin_radius])
