"""Do the carriers trail like good casters or will they flip round?

The heading psi = theta_p + theta of a carrier, pulled by its hinge with speed v along the
bearing beta, obeys (D13 with both wheels rolling)

    psi' = -(v / e) sin(a),  a = beta - psi,     tan(a/2) = tan(a0/2) exp(v t / e)

e < 0 (axle trails): the misalignment a decays within |e|/v. e > 0 (axle leads): aligned driving
is unstable and the carrier turns round until it trails the other way. During a flip the wheels
peak at (v / r) sqrt(1 + (b/e)^2).
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform.carriers import Carriers


def heading_rate(axle_offset: float, speed: float, misalignment: float) -> float:
    """psi' [rad/s] of a carrier whose hinge moves with ``speed`` [m/s] at bearing psi + a."""
    return -(speed / axle_offset) * math.sin(misalignment)  # D13: psi' = -hY / e


def misalignment_after(axle_offset: float, speed: float, start: float, time: float) -> float:
    """Misalignment a [rad] after ``time`` s of steady pulling from ``start`` rad, |start| < pi."""
    return 2.0 * math.atan(math.tan(start / 2.0) * math.exp(speed * time / axle_offset))


def misalignment(carriers: Carriers, angles: FloatArray, twist: FloatArray) -> FloatArray:
    """(C,) rad: bearing of the hinge velocity minus carrier heading, in [-pi, pi]; NaN at rest."""
    vx = twist[0] - twist[2] * carriers.y
    vy = twist[1] + twist[2] * carriers.x
    gap = np.arctan2(vy, vx) - angles
    wrapped: FloatArray = np.arctan2(np.sin(gap), np.cos(gap))
    return np.where(np.hypot(vx, vy) > 0.0, wrapped, np.nan)


def will_flip(carriers: Carriers, angles: FloatArray, twist: FloatArray) -> tuple[bool, ...]:
    """For each carrier: is it pulled the way it cannot stay, e cos(a) > 0? False at rest."""
    gap = misalignment(carriers, angles, twist)
    return tuple(bool(value > 0.0) for value in carriers.axle_offset * np.cos(gap))


def flip_peak_rate(axle_offset: float, half_track: float, radius: float, speed: float) -> float:
    """Largest wheel rate [rad/s] while a carrier flips at hinge speed ``speed`` [m/s]."""
    return abs(speed) / radius * math.hypot(1.0, half_track / axle_offset)
