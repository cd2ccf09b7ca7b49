"""How long must k rollers be, and what happens where they are too short (models.md 2.2).

    half pitch       U = pi/k                 a roller carries u in [-U, U] if it is long enough
    minimum length   L_min = 2 X*(U)          maximum L_max = 2 X*(u_K), cos u_K = d/r
    existence        d < r cos U              else it ends in a point before the hand-over
    contact ratio    eps = u_max k / pi       u_max of a roller of length L: X*(u_max) = L/2
    short roller     eps < 1: the wheel stands on the end rims (radius rho_e), its axis in mid-gap
               d cos U + (L/2) |sin(delta)| sin U + rho_e sqrt(1 - sin^2(delta) sin^2 U) high

Collision of neighbouring rollers is not treated by the source; :func:`neighbour_clearance` checks
it numerically.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.roller.shape import (
    RollerShape,
    meridian,
    surface,
    wheel_from_roller,
)


@dataclass(frozen=True, slots=True)
class Sizing:
    """Lengths, radii and travel in m, wheel angles in rad, for one number of rollers.

    ``half_range`` = pi/k; ``min_length``, ``max_length``; ``max_half_range`` = u_K; ``length`` as
    given or chosen; ``reach`` = u_max of that length; ``contact_ratio``; ``equator_radius``,
    ``handover_radius``, ``end_radius`` of the roller; ``contact_travel`` along the axle per
    roller; ``axis_drop`` in mid-gap, 0 where the rollers overlap.
    """

    half_range: float
    min_length: float
    max_length: float
    max_half_range: float
    length: float
    reach: float
    contact_ratio: float
    equator_radius: float
    handover_radius: float
    end_radius: float
    contact_travel: float
    axis_drop: float


def require_room(shape: RollerShape, count: int) -> None:
    """ConfigError where fewer than 3 rollers are asked for or d >= r cos(pi/k)."""
    if count < 3:
        raise ConfigError('count', count, 'must be at least 3 rollers')
    limit = shape.radius * math.cos(math.pi / count)
    if shape.pin_radius >= limit:
        raise ConfigError(
            'pin_radius', shape.pin_radius, f'must be below radius*cos(pi/count) = {limit:.6g}: '
            'the roller would end in a point before the next roller takes over', 'm')


def half_length(shape: RollerShape, u: float) -> float:
    """X*(u) [m]: half the length a roller needs to carry the wheel angle u (G eq. 5)."""
    return abs(float(meridian(shape, np.array([u]))[0][0]))


def reach_of_length(shape: RollerShape, length: float) -> float:
    """u_max [rad] with X*(u_max) = length/2; ConfigError where no roller is that long."""
    if not 0.0 < length <= 2.0 * half_length(shape, shape.knot) * (1.0 + 1e-12):
        raise ConfigError('length', length, 'must be > 0 and at most '
                          f'{2.0 * half_length(shape, shape.knot):.6g}, where the roller ends in '
                          'a point', 'm')
    low, high = 0.0, shape.knot
    for _ in range(200):  # X* grows with u: bisection to the last bit
        middle = 0.5 * (low + high)
        if half_length(shape, middle) < 0.5 * length:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def size(shape: RollerShape, count: int, length: float | None = None) -> Sizing:
    """Sizing of ``count`` rollers; without ``length`` [m] the shortest that just takes over.

    Raises ConfigError as :func:`require_room` and :func:`reach_of_length` do.
    """
    require_room(shape, count)
    half = math.pi / count
    shortest = 2.0 * half_length(shape, half)
    chosen = shortest if length is None else length
    reach = half if length is None else reach_of_length(shape, length)
    radii = meridian(shape, np.array([half, reach]))[1]
    cot = abs(math.cos(shape.angle) / math.sin(shape.angle))
    drop = 0.0 if reach >= half else _axis_drop(shape, half, chosen, float(radii[1]))
    return Sizing(
        half_range=half, min_length=shortest, max_length=2.0 * half_length(shape, shape.knot),
        max_half_range=shape.knot, length=chosen, reach=reach, contact_ratio=reach / half,
        equator_radius=shape.equator_radius, handover_radius=float(radii[0]),
        end_radius=float(radii[1]),
        contact_travel=2.0 * shape.pin_radius * cot * math.tan(half), axis_drop=drop)


def _axis_drop(shape: RollerShape, half: float, length: float, end_radius: float) -> float:
    sine = abs(math.sin(shape.angle))
    height = (shape.pin_radius * math.cos(half) + 0.5 * length * sine * math.sin(half)
              + end_radius * math.sqrt(1.0 - (sine * math.sin(half))**2))
    return shape.radius - height


def neighbour_clearance(shape: RollerShape, count: int, length: float, samples: int = 90) -> float:
    """Smallest gap [m] between neighbouring rollers, < 0 where they intersect (our own check).

    The surface of the next roller is sampled and its distance from this roller's axis compared
    with this roller's radius there; accurate to about the sample spacing.
    """
    reach = reach_of_length(shape, length)
    u, v = np.meshgrid(np.linspace(-reach, reach, samples),
                       np.linspace(-math.pi, math.pi, 2 * samples))
    points = wheel_from_roller(shape, surface(shape, u.ravel(), v.ravel()))
    turn = 2.0 * math.pi / count
    c, s = math.cos(turn), math.sin(turn)
    x, y, z = points.T
    y, z = c * y - s * z, s * y + c * z + shape.pin_radius  # next roller, seen from (0, 0, -d)
    cd, sd = math.cos(shape.angle), math.sin(shape.angle)
    along, across = cd * x + sd * y, cd * y - sd * x
    grid = np.linspace(-reach, reach, 2000)
    axis, radius = meridian(shape, grid)
    order = np.argsort(axis)
    own = np.interp(along, axis[order], radius[order])
    gap = np.hypot(across, z) - own
    beside = np.abs(along) <= 0.5 * length
    if not np.any(beside):
        return math.inf
    return float(np.min(gap[beside]))


def clear_pin_radius(shape: RollerShape, count: int, length: float | None) -> float | None:
    """Smallest pin radius [m] at which neighbours do not intersect; None where there is none.

    Same wheel radius and angle; ``length`` m, or None for the shortest that takes over.
    """
    def gap(pin: float) -> float:
        other = RollerShape(shape.radius, pin, shape.angle)
        chosen = size(other, count, None).length if length is None else length
        return neighbour_clearance(other, count, chosen, samples=40)

    low, high = shape.pin_radius, shape.radius * math.cos(math.pi / count) * (1.0 - 1e-6)
    try:
        if gap(high) < 0.0:
            return None
        for _ in range(20):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if gap(middle) >= 0.0 else (middle, high)
    except ConfigError:  # so long a roller would end in a point
        return None
    return high
