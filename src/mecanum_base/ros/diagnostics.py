"""What a node publishes on /diagnostics: one status a source, readable by a person.

A node gives a function that returns its statuses; :class:`Diagnostics` calls it once a second on a
clock that neither stops nor jumps with simulated time, so that a stopped /clock is reported too.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock
from rclpy.clock_type import ClockType

from mecanum_base import messages
from mecanum_base.ros.qos import RELIABLE

OK, WARN, ERROR, STALE = 0, 1, 2, 3
PERIOD = 1.0  # s
STALE_AFTER = 1.0  # s without a message
BUSY = 0.9  # of one core


@dataclass(frozen=True, slots=True)
class Status:
    """One entry of /diagnostics; ``level`` is OK, WARN, ERROR or STALE."""

    name: str
    level: int
    message: str
    values: Mapping[str, object] = field(default_factory=dict)
    hardware_id: str = ''


class Source:
    """Arrivals of one input: count, rate, age and latency since the last report."""

    def __init__(self, name: str, topic: str) -> None:
        self.name, self.topic = name, topic
        self.received = 0
        self.rejected: dict[str, int] = {}
        self._reported: tuple[float, int, int] = (time.monotonic(), 0, 0)
        self._arrival = float('-inf')
        self._latency: list[float] = []

    def arrived(self, latency: float | None = None) -> None:
        """Count a message; ``latency`` [s] from its stamp to now on the node's clock."""
        self.received += 1
        self._arrival = time.monotonic()
        if latency is not None:
            self._latency.append(latency)

    def reject(self, reason: str) -> None:
        """Count a message that could not be used, by its reason."""
        self.rejected[reason] = self.rejected.get(reason, 0) + 1

    def report(self, *, rejected: Mapping[str, int] | None = None, needed: bool = True,
               silent: str = '', values: Mapping[str, object] | None = None) -> Status:
        """OK while messages come and all are used, WARN when some, ERROR when all are rejected.

        Without a message for a second the level is STALE if the source is ``needed``, else WARN
        with the text ``silent``. ``rejected`` replaces the own counters.
        """
        counters = dict(self.rejected if rejected is None else rejected)
        now, refused = time.monotonic(), sum(counters.values())
        before, received_before, refused_before = self._reported
        received, new = self.received - received_before, refused - refused_before
        self._reported = (now, self.received, refused)
        shown: dict[str, object] = {'topic': self.topic, 'received': self.received}
        shown |= {f'rejected: {reason}': n for reason, n in sorted(counters.items())}
        if now > before:
            shown['rate [Hz]'] = f'{received / (now - before):.1f}'
        if self._latency:
            shown['latency [ms]'] = f'{1e3 * sum(self._latency) / len(self._latency):.2f}'
            shown['latency max [ms]'] = f'{1e3 * max(self._latency):.2f}'
            self._latency = []
        shown |= values or {}
        level, text = OK, 'receiving'
        if now - self._arrival > STALE_AFTER:
            level = STALE if needed else WARN
            text = silent or (f'no message on {self.topic}' if not self.received else
                              f'silent for {now - self._arrival:.1f} s')
        elif new > 0:
            level = ERROR if new >= received else WARN
            latest = max(counters, key=lambda reason: counters[reason])
            text = f'{new} of {received} rejected, most often: {latest}'
        return Status(self.name, level, text, shown)


class Diagnostics:
    """Publishes the statuses of one node on /diagnostics, about once a second.

    Two statuses are added to those of ``collect``: the load of the executor's thread, and the
    clock where the node runs on simulated time.
    """

    def __init__(self, node: Any, collect: Callable[[], Sequence[Status]],
                 hardware_id: str = 'mecanum_base') -> None:
        self._node, self._collect, self._hardware = node, collect, hardware_id
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', RELIABLE)
        self._timer = node.create_timer(PERIOD, self.publish,
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._before = (time.monotonic(), time.thread_time(), 0)

    def publish(self) -> tuple[Status, ...]:
        """Collect and send now; returns what was sent."""
        prefix = self._node.get_name()
        statuses = tuple(
            Status(f'{prefix}: {s.name}', s.level, s.message, s.values,
                   s.hardware_id or self._hardware) for s in (*self._collect(), *self._process()))
        stamp = self._node.get_clock().now().nanoseconds
        self._publisher.publish(messages.write_diagnostics(
            stamp, statuses, DiagnosticArray(), DiagnosticStatus, KeyValue))
        return statuses

    def _process(self) -> list[Status]:
        wall, cpu, ros = self._before
        clock = self._node.get_clock()
        self._before = time.monotonic(), time.thread_time(), clock.now().nanoseconds
        passed = self._before[0] - wall
        load = (self._before[1] - cpu) / passed if passed > 0.0 else 0.0
        found = [Status('executor', WARN if load > BUSY else OK,
                        f'{100.0 * load:.0f} % of one core', {'load': f'{load:.3f}'})]
        if clock.ros_time_is_active:
            stopped = self._before[2] == ros
            text = 'simulated time stands still' if stopped else 'simulated time advances'
            if self._before[2] == 0:
                text = 'use_sim_time is set and nothing was heard on /clock'
            found.append(Status('clock', STALE if stopped else OK, text,
                                {'time [s]': f'{1e-9 * self._before[2]:.3f}'}))
        return found
