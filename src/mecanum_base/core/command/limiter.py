"""Limits on velocity, acceleration and jerk of the twist as one vector.

Every limit is three numbers m = (m_x, m_y, m_yaw) that span a convex body around zero:

    n(v; m) = sqrt( (v_x/m_x)^2 + (v_y/m_y)^2 + (w/m_yaw)^2 )   ellipse
    n(v; m) = max( |v_x/m_x|, |v_y/m_y|, |w/m_yaw| )            box
    allowed: n(v; m) <= 1

A vector that is too long is scaled as a whole, so the base keeps its direction and no wheel runs
ahead of the others. From one twist v to the next wanted one v*, the twist moves along the straight
line d = v* - v. Without a jerk limit each step uses the full deceleration until the point of the
line that is nearest to zero (measured in deceleration), the full acceleration beyond it.

With a jerk limit the acceleration a is a state of its own. Let D = n(d; jerk) [s^2]. Accelerations
A, A - dt, ... in jerk units [s], one a step, end at v* with less than one step's jerk left if

    k = ceil((sqrt(1 + 8 D/dt^2) - 1) / 2),   A = D/(k dt) + (k - 1) dt/2     (their sum is D/dt)

so a is moved towards min(limit, A) along d, by at most dt jerk units. From rest this reaches v*
without overshoot. A sudden change of the wanted twist can overshoot by what the jerk limit leaves
no choice about; while a deceleration turns into an acceleration the larger of both limits holds.

Not modelled: the grip of the wheels (choose the limits below it), load, slope.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.command.drive import DriveConfig
from mecanum_base.core.parameter import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class TwistLimits:
    """Largest velocity, acceleration, deceleration, jerk, each (3,), and the shape they span."""

    velocity: FloatArray
    acceleration: FloatArray
    deceleration: FloatArray
    jerk: FloatArray
    shape: str = 'ellipse'

    @classmethod
    def from_config(cls, drive: DriveConfig) -> TwistLimits:
        """The limits of block ``drive``."""
        return cls(drive.max_velocity, drive.max_acceleration, drive.max_deceleration,
                   drive.max_jerk, drive.limit_shape)

    def norm(self, vector: FloatArray, maxima: FloatArray) -> float:
        """n(vector; maxima): 1 on the surface of the allowed body, 0 where nothing is limited."""
        parts = np.abs(vector) / maxima
        return float(np.max(parts) if self.shape == 'box' else math.sqrt(float(parts @ parts)))

    def within_velocity(self, twist: FloatArray) -> FloatArray:
        """``twist`` (3,) scaled down as a whole to the velocity limit."""
        size = self.norm(twist, self.velocity)
        return twist / size if size > 1.0 else twist


class TwistLimiter:
    """The twist (3,) that is told to the base, following a wanted one within the limits."""

    def __init__(self, limits: TwistLimits) -> None:
        self.limits = limits
        self.twist: FloatArray = np.zeros(3)
        self.acceleration: FloatArray = np.zeros(3)

    def reset(self, twist: FloatArray | None = None) -> None:
        """Stand still at once, or go on from ``twist``, without acceleration."""
        self.twist = np.zeros(3) if twist is None else np.array(twist)
        self.acceleration = np.zeros(3)

    def step(self, wanted: FloatArray, dt: float) -> FloatArray:
        """The twist after ``dt`` s on the way to ``wanted`` (3,); dt = 0 changes nothing."""
        if dt <= 0.0:
            return self.twist
        before = self.twist
        if np.all(np.isinf(self.limits.jerk)):
            self.twist = self._ramp(wanted, dt)
            self.acceleration = (self.twist - before) / dt
        else:
            self.twist = self._smooth_ramp(wanted, dt)
        return self.twist

    def _slowing_part(self, path: FloatArray) -> float:
        """The fraction of ``path`` on which the base gets slower, measured in deceleration."""
        unit = np.where(np.isinf(self.limits.deceleration), self.limits.acceleration,
                        self.limits.deceleration)
        scale = 1.0 / np.where(np.isinf(unit), 1.0, unit)
        length = float((scale * path) @ (scale * path))
        if length == 0.0:
            return 0.0
        return min(1.0, max(0.0, -float((scale * self.twist) @ (scale * path)) / length))

    def _ramp(self, wanted: FloatArray, dt: float) -> FloatArray:
        path, limits = wanted - self.twist, self.limits
        slowing = self._slowing_part(path)
        time_down = slowing * limits.norm(path, limits.deceleration)
        slope_up = limits.norm(path, limits.acceleration)
        time_up = (1.0 - slowing) * slope_up
        if dt >= time_down + time_up:
            return np.array(wanted)
        if dt < time_down:
            return self.twist + path * (slowing * dt / time_down)
        return self.twist + path * (slowing + (dt - time_down) / slope_up)

    def _smooth_ramp(self, wanted: FloatArray, dt: float) -> FloatArray:
        path, limits = wanted - self.twist, self.limits
        jerk_time = limits.norm(path, limits.jerk)  # D [s^2]
        goal = np.zeros(3)
        if jerk_time > 0.0:
            slowing = self._slowing_part(path) > 0.0
            bound = limits.norm(path, limits.deceleration if slowing else limits.acceleration)
            steepest = math.inf if bound == 0.0 else 1.0 / bound
            goal = path * min(steepest, _fading(jerk_time, dt) / jerk_time)
        change = goal - self.acceleration
        size = limits.norm(change, limits.jerk)
        if size > dt * (1.0 + 1e-9):
            self.acceleration = self.acceleration + change * (dt / size)
            return self.twist + self.acceleration * dt
        self.acceleration = goal
        reached = self.twist + goal * dt
        arrived = limits.norm(wanted - reached, limits.jerk) < 1e-9 * dt * dt
        return np.array(wanted) if arrived else reached


def _fading(distance: float, dt: float) -> float:
    """A [s]: the acceleration from which fading by ``dt`` a step covers ``distance`` [s^2]."""
    steps = math.ceil((math.sqrt(1.0 + 8.0 * distance / (dt * dt)) - 1.0) / 2.0 - 1e-9)
    steps = max(1, steps)
    return distance / (steps * dt) + (steps - 1) * dt / 2.0
