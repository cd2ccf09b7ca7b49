"""The clock a node measures durations with.

On simulated time this is the node's own clock, so that a simulation may run at any speed. Without
it a steady clock is used that nobody can set: a step of the system clock (NTP) neither triggers a
time-out nor holds one back.
"""

from __future__ import annotations

import time

from rclpy.clock import Clock, ROSClock
from rclpy.clock_type import ClockType
from rclpy.node import Node


class TimeBase:
    """Durations of a node, and whether its clock still runs."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self.steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.simulated = self._is_simulated()
        self._seen_ns, self._changed_at = -1, time.monotonic()
        self.stood_still()

    @property
    def clock(self) -> Clock:
        """The clock for timers and durations."""
        return self._node.get_clock() if self.simulated else self.steady

    def now_ns(self) -> int:
        """Nanoseconds of :attr:`clock`."""
        return int(self.clock.now().nanoseconds)

    def switched(self) -> bool:
        """Whether use_sim_time was changed since the last call; :attr:`clock` follows."""
        before, self.simulated = self.simulated, self._is_simulated()
        return before != self.simulated

    def stood_still(self) -> float:
        """For how long [s of real time] the clock has shown the same time, seen at the calls."""
        now, wall = self.now_ns(), time.monotonic()
        if now != self._seen_ns:
            self._seen_ns, self._changed_at = now, wall
        return wall - self._changed_at

    def _is_simulated(self) -> bool:
        clock = self._node.get_clock()
        return isinstance(clock, ROSClock) and bool(clock.ros_time_is_active)
