"""When the base may move and why it stands: the stopping rules as one small state machine.

    idle       enabled, no command has arrived yet                        -> stand
    driving    a command arrived within the last ``timeout`` seconds      -> follow it
    timed_out  the last command is older                                  -> decelerate, then zeros
    stopped    a fault or the end of the process; a new command ends it   -> zeros at once
    disabled   switched off; only switching on ends it                    -> zeros at once

Time counts from the arrival of a command, not from its stamp: some publishers repeat old stamps.
A command with a number that is not finite is rejected, and the last valid one runs until its own
time-out. Parts that a planar base cannot serve (linear z, angular x and y) are ignored. Whatever
is rejected or ignored is counted by its reason. After a stop of any kind the old command is
forgotten: only a new one moves the base. Stamps are nanoseconds of any clock that the caller uses
throughout.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.parameter import FloatArray

IDLE, DRIVING, TIMED_OUT, STOPPED, DISABLED = (
    'idle', 'driving', 'timed_out', 'stopped', 'disabled')
AT_ONCE = (IDLE, STOPPED, DISABLED)
"""Modes in which the wheels get zeros without a ramp."""

NOT_FINITE = 'not a finite number'
NOT_PLANAR = 'linear.z, angular.x or angular.y not 0 (ignored)'
WHILE_DISABLED = 'arrived while disabled'


@dataclass(frozen=True, slots=True)
class Transition:
    """A change of mode and its reason, to be logged once."""

    before: str
    mode: str
    reason: str


class Stopping:
    """Follows commands, time and switches; says what is wanted now."""

    def __init__(self, timeout: float, enabled: bool = True) -> None:
        self.timeout = timeout
        self.mode = IDLE if enabled else DISABLED
        self.reason = 'no command yet' if enabled else 'drive.start_enabled is false'
        self.rejected: Counter[str] = Counter()
        self._wanted: FloatArray = np.zeros(3)
        self._arrival_ns = 0
        self._transitions: list[Transition] = []

    @property
    def at_once(self) -> bool:
        """Whether the wheels get zeros without a ramp."""
        return self.mode in AT_ONCE

    def accept(self, linear: FloatArray, angular: FloatArray, now_ns: int) -> bool:
        """Take a command, linear (3,) m/s and angular (3,) rad/s; False where it is rejected."""
        if not (np.isfinite(linear).all() and np.isfinite(angular).all()):
            self.rejected[NOT_FINITE] += 1
            return False
        if linear[2] or angular[0] or angular[1]:
            self.rejected[NOT_PLANAR] += 1
        if self.mode == DISABLED:
            self.rejected[WHILE_DISABLED] += 1
            return False
        self._wanted = np.array([linear[0], linear[1], angular[2]])
        self._arrival_ns = now_ns
        if self.mode != DRIVING:
            self._enter(DRIVING, 'a command arrived')
        return True

    def wanted(self, now_ns: int) -> FloatArray:
        """The twist (3,) wanted at ``now_ns``: of the command, or zero."""
        age = (now_ns - self._arrival_ns) * 1e-9
        if self.mode == DRIVING and age > self.timeout:
            self._enter(TIMED_OUT, f'no command for {self.timeout:g} s: decelerating')
        return self._wanted if self.mode == DRIVING else np.zeros(3)

    def stop(self, reason: str) -> None:
        """Zeros at once, until a new command arrives."""
        if self.mode != DISABLED:
            self._enter(STOPPED, reason)

    def enable(self, on: bool, reason: str) -> None:
        """Switch driving on or off; off means zeros at once."""
        if on and self.mode == DISABLED:
            self._enter(IDLE, reason)
        elif not on and self.mode != DISABLED:
            self._enter(DISABLED, reason)

    def take_transitions(self) -> tuple[Transition, ...]:
        """Changes of mode since the last call."""
        taken = tuple(self._transitions)
        self._transitions.clear()
        return taken

    def _enter(self, mode: str, reason: str) -> None:
        if mode == STOPPED and self.mode == STOPPED and reason == self.reason:
            return
        self._transitions.append(Transition(self.mode, mode, reason))
        self.mode, self.reason = mode, reason
        if mode != DRIVING:
            self._wanted = np.zeros(3)
