"""The goal that is pursued now and what it asks of the base."""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core import se2
from mecanum_base.core.command.potential_field import GoalField
from mecanum_base.core.parameter import FloatArray
from mecanum_base.messages import MalformedMessage
from mecanum_base.ros.world_frames import WorldFrames

MOVING_GOAL = 0.5  # s; goals that follow each other faster are one moving goal
STUCK_SPEED, STUCK_TIME = 1e-3, 5.0  # m/s, s: standing away from the goal is reported
_ZERO = np.zeros(3)


class Pursuit:
    """One goal at a time; ``state`` says in words what happens with it."""

    def __init__(self, field: GoalField) -> None:
        self.field = field
        self.active = False
        self.state = 'no goal'
        self.distance = math.nan
        self._frame, self._goal = '', _ZERO
        self._velocity, self._goal_ns = _ZERO, 0
        self._standing_since: int | None = None

    def start(self, frame: str, goal: FloatArray, frames: WorldFrames, now_ns: int) -> None:
        """Pursue ``goal`` (3,) of ``frame``; raises MalformedMessage for an unknown frame."""
        origin = frames.origin(frame)
        if frames.is_base(frame):  # fixed where it was when it came
            frame, goal = '', se2.compose(origin, goal)
        elapsed = (now_ns - self._goal_ns) * 1e-9
        moving = self.active and frame == self._frame and 0.0 < elapsed < MOVING_GOAL
        self._velocity = _rate(self._goal, goal, elapsed) if moving else _ZERO
        self._frame, self._goal, self._goal_ns = frame, goal, now_ns
        if not self.active:
            self._standing_since = None
        self.active, self.state = True, 'pursuing a goal'

    def cancel(self) -> None:
        """Give the goal up."""
        self.active, self.state = False, 'no goal'

    def twist(self, frames: WorldFrames, obstacles: FloatArray, fresh: bool,
              now_ns: int) -> FloatArray:
        """Twist (3,) to command now; zero, and no longer active, once the goal is reached."""
        if not fresh or frames.base is None:
            self.state = 'waiting: odom is too old'
            return _ZERO
        try:
            origin = frames.origin(self._frame) if self._frame else _ZERO
        except MalformedMessage as error:
            self.state = f'waiting: {error}'
            return _ZERO
        goal = se2.compose(origin, self._goal)
        self.distance = math.hypot(*(goal - frames.base)[:2])
        lead = self._lead(origin, now_ns)
        if lead is None and self.field.reached(frames.base, goal, float(goal[2])):
            self.active, self.state = False, 'goal reached'
            return _ZERO
        found = self.field.twist(frames.base, goal, float(goal[2]), lead, obstacles)
        self.state = 'pursuing a goal'
        if self._stands(found, now_ns):
            self.state = 'stuck: obstacles leave no way to the goal'
        return found

    def _lead(self, origin: FloatArray, now_ns: int) -> FloatArray | None:
        """Velocity (3,) of a moving goal in odom, where it is to be fed forward."""
        recent = 0.0 <= (now_ns - self._goal_ns) * 1e-9 < MOVING_GOAL  # < 0: clock jumped back
        if not self.field.config.feed_forward or not recent or not np.any(self._velocity):
            return None
        turned = se2.rotation(float(origin[2])) @ self._velocity[:2]
        return np.array([turned[0], turned[1], self._velocity[2]])

    def _stands(self, twist: FloatArray, now_ns: int) -> bool:
        if math.hypot(twist[0], twist[1]) > STUCK_SPEED or (
                self.distance <= self.field.config.position_tolerance):
            self._standing_since = None
            return False
        if self._standing_since is None or now_ns < self._standing_since:
            self._standing_since = now_ns
        return (now_ns - self._standing_since) * 1e-9 > STUCK_TIME


def _rate(before: FloatArray, after: FloatArray, elapsed: float) -> FloatArray:
    gap = after - before
    gap[2] = se2.wrap_angle(float(gap[2]))
    return gap / elapsed
