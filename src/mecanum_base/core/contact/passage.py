"""What one roller passing over the ground does to the wheel rate at constant twist (G eq. 15).

Over a passage u = -U ... U, U = pi/k, the exact rate is u'(u) = f + g sec(u) + h tan(u) with

    f = -(p.v_A)/r       g = -(cot(delta) a.v_A)/r       h = w d cot(delta)/r

    mean over the angle   f + g ln((1 + sin U)/(1 - sin U)) / (2 U)
    inner extremum        sin u = -h/g
    hand-over jump        -2 h tan U     (only the yaw rate causes it)
    contact travel        2 d |cot(delta)| tan U

Sideways travel over a roller pitch: 2 r tan(delta) sin(pi/k), nominal 2 r tan(delta) pi/k.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.contact.rate import require_pin_radius
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Passage:
    """Wheel rates (W,) rad/s over one roller at constant twist, and the contact travel (W,) m.

    ``nominal`` G eq. 16; ``low``, ``high`` extremes; ``mean`` over the wheel angle; ``jump`` rate
    just after minus just before the hand-over when the wheel angle grows; ``travel`` of the
    contact point along the axle.
    """

    nominal: FloatArray
    low: FloatArray
    high: FloatArray
    mean: FloatArray
    jump: FloatArray
    travel: FloatArray


def passage(wheels: Wheels, twist: FloatArray) -> Passage:
    """Rates over one roller pitch at the constant ``twist`` (3,); roller counts must be known."""
    require_pin_radius(wheels)
    half = _half_pitch(wheels)
    ca, sa = np.cos(wheels.axle), np.sin(wheels.axle)
    cot = np.cos(wheels.roller) / np.sin(wheels.roller)
    vx, vy = twist[0] - twist[2] * wheels.y, twist[1] + twist[2] * wheels.x
    f = -(ca * vy - sa * vx) / wheels.radius
    g = -cot * (ca * vx + sa * vy) / wheels.radius
    h = twist[2] * wheels.roller_pin_radius * cot / wheels.radius
    ends = [f + g / np.cos(half) + h * np.tan(half), f + g / np.cos(half) - h * np.tan(half)]
    with np.errstate(divide='ignore', invalid='ignore'):
        turning = -h / g
    inside = np.abs(turning) < np.sin(half)  # NaN compares false
    u = np.arcsin(np.where(inside, turning, 0.0))
    inner = np.where(inside, f + g / np.cos(u) + h * np.tan(u), ends[0])
    return Passage(
        nominal=wheels_from_body(wheels, corrected=False) @ twist,
        low=np.minimum(np.minimum(ends[0], ends[1]), inner),
        high=np.maximum(np.maximum(ends[0], ends[1]), inner),
        mean=f + g * np.arctanh(np.sin(half)) / half,
        jump=-2.0 * h * np.tan(half),  # u jumps from +U to -U
        travel=2.0 * np.abs(wheels.roller_pin_radius * cot) * np.tan(half))


def _half_pitch(wheels: Wheels) -> FloatArray:
    if np.any(wheels.roller_count <= 0):
        raise ValueError('the passage of a roller needs the roller count of every wheel')
    half: FloatArray = math.pi / wheels.roller_count.astype(np.float64)
    return half


def lateral_scale(roller_count: int) -> float:
    """Sideways travel over that of nominal kinematics: sin(pi/k)/(pi/k) (models.md 2.1)."""
    half = math.pi / roller_count
    return math.sin(half) / half


def lateral_peak(roller_count: int) -> float:
    """Largest over nominal wheel rate while driving sideways: sec(pi/k)."""
    return 1.0 / math.cos(math.pi / roller_count)


def lateral_travel(wheels: Wheels) -> FloatArray:
    """(W,) m the base moves sideways per roller pitch: 2 r |tan(delta)| sin(pi/k)."""
    half = _half_pitch(wheels)
    travel: FloatArray = 2.0 * wheels.radius * np.abs(np.tan(wheels.roller)) * np.sin(half)
    return travel


def yaw_sawtooth(wheels: Wheels) -> FloatArray:
    """(W,): +- wheel rate per yaw rate at the hand-over, d |cot(delta)| tan(pi/k) / r."""
    require_pin_radius(wheels)
    cot = np.abs(np.cos(wheels.roller) / np.sin(wheels.roller))
    half = _half_pitch(wheels)
    size: FloatArray = wheels.roller_pin_radius * cot * np.tan(half) / wheels.radius
    return size
