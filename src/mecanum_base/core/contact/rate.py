"""Exact wheel rate with the contact point where it really is under the roller (G eq. 10-15).

With u the wheel angle since this roller was central, a the axle, p = a turned by +90 deg, A the
wheel centre, v_A = (vx - w y, vy + w x), d the pin radius (wheel axis to roller axis):

    C(u)  = A - d cot(delta) tan(u) a                                       contact point    G11
    b(u)  = (ca cd - sa sd cu, sa cd + ca sd cu, sd su)                     roller axis      G10
    u'    = -(1/r) [ p.v_A + (cot(delta)/cos u) a.v_A - w d cot(delta) tan(u) ]              G15
    lam   = a.v_A / (sin(delta) cos u)                                      [m/s]            G14
    spin  = lam / (r - d / cos u)      roller about b, relative to the wheel             [rad/s]

Wheel angles are counted from the instant a roller is central under the axle (index pulse); u is
that angle modulo 2 pi/k in [-pi/k, pi/k). A wheel with roller_count 0 stays at u = 0.
Not modelled: both rollers in contact at the hand-over, sinking in, floor unevenness.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

SWEDISH = 1e-9  # |cot delta| below which the contact point does not wander


def require_pin_radius(wheels: Wheels) -> None:
    """ConfigError where rollers are counted but their distance from the axle is unknown."""
    cot = np.abs(np.cos(wheels.roller) / np.sin(wheels.roller))
    for index, count in enumerate(wheels.roller_count):
        if count and cot[index] > SWEDISH and wheels.roller_pin_radius[index] <= 0.0:
            raise ConfigError(f'wheels.roller_pin_radius[{index}]',
                              float(wheels.roller_pin_radius[index]),
                              'must be known (> 0) for the exact contact model', 'm')


def phase(wheels: Wheels, angles: FloatArray) -> FloatArray:
    """u (W,) rad: wheel angles (W,) from the index, reduced to [-pi/k, pi/k); 0 if k unknown."""
    known = wheels.roller_count > 0
    pitch = 2.0 * math.pi / np.where(known, wheels.roller_count, 1)
    reduced = angles - pitch * np.floor(angles / pitch + 0.5)
    return np.where(known, reduced, 0.0)


def contact_points(wheels: Wheels, angles: FloatArray) -> FloatArray:
    """C (W, 2) m in base_link at wheel angles (W,) rad from the index (G eq. 11)."""
    require_pin_radius(wheels)
    u = phase(wheels, angles)
    cot = np.cos(wheels.roller) / np.sin(wheels.roller)
    shift = -wheels.roller_pin_radius * cot * np.tan(u)  # G eq. 11: C = A - d cot tan(u) a
    return np.column_stack([wheels.x + shift * np.cos(wheels.axle),
                            wheels.y + shift * np.sin(wheels.axle)])


def roller_axes(wheels: Wheels, angles: FloatArray) -> FloatArray:
    """b (W, 3): unit vectors of the rollers on the ground, base_link axes (G eq. 10)."""
    u = phase(wheels, angles)
    ca, sa = np.cos(wheels.axle), np.sin(wheels.axle)
    cd, sd = np.cos(wheels.roller), np.sin(wheels.roller)
    cu, su = np.cos(u), np.sin(u)
    return np.column_stack([ca * cd - sa * sd * cu, sa * cd + ca * sd * cu, sd * su])  # G eq. 10


def wheels_from_body(wheels: Wheels, angles: FloatArray) -> FloatArray:
    """Exact H (W, 3) at wheel angles (W,) rad from the index: rates = H @ twist (G eq. 15).

    Raises ConfigError where a pin radius is needed and unknown.
    """
    require_pin_radius(wheels)
    u = phase(wheels, angles)
    ca, sa = np.cos(wheels.axle), np.sin(wheels.axle)
    cot = np.cos(wheels.roller) / np.sin(wheels.roller)
    along = cot / np.cos(u)
    east, north = along * ca - sa, along * sa + ca  # p.v_A + (cot / cos u) a.v_A
    drift = wheels.roller_pin_radius * cot * np.tan(u)
    turn = north * wheels.x - east * wheels.y - drift  # ... - w d cot tan(u)
    matrix: FloatArray = -np.column_stack([east, north, turn]) / wheels.radius[:, None]  # G eq. 15
    return matrix


def roller_speeds(wheels: Wheels, angles: FloatArray, twist: FloatArray) -> FloatArray:
    """lambda (W,) m/s: speed factor of the roller surface at the ground (G eq. 14)."""
    u = phase(wheels, angles)
    vx, vy = twist[0] - twist[2] * wheels.y, twist[1] + twist[2] * wheels.x
    along = np.cos(wheels.axle) * vx + np.sin(wheels.axle) * vy
    speed: FloatArray = along / (np.sin(wheels.roller) * np.cos(u))  # G eq. 14
    return speed


def roller_spins(wheels: Wheels, angles: FloatArray, twist: FloatArray) -> FloatArray:
    """Spin (W,) rad/s of the roller on the ground about b, relative to the wheel."""
    require_pin_radius(wheels)
    reach = wheels.radius - wheels.roller_pin_radius / np.cos(phase(wheels, angles))
    spin: FloatArray = roller_speeds(wheels, angles, twist) / reach  # Omega = lam / (r - d/cos u)
    return spin


def local_radii(wheels: Wheels, angles: FloatArray) -> FloatArray:
    """(W,) m: radius of the roller where it touches the ground (models.md 2.2)."""
    require_pin_radius(wheels)
    u = phase(wheels, angles)
    reach = wheels.radius - wheels.roller_pin_radius / np.cos(u)
    radius: FloatArray = reach * np.sqrt(1.0 - (np.sin(wheels.roller) * np.sin(u)) ** 2)
    return radius
