"""How far simulated time may run: it follows real time, and waits where it may.

    target = start + (real time - beginning) * rate_factor            [ns]

Where the simulation is the clock of the other nodes (``sim.publish_clock``) a busy computer makes
time slower instead of making the robot stumble: while wheel commands come, time does not run
further than half of ``sim.command_timeout`` past the last one, unless nobody has sent any for that
long in real time as well. A killed drive_node therefore still stops the wheels. Without
``sim.publish_clock`` time is real time and waits for nobody.

A simulation that is too slow lets time pass instead of piling it up.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from mecanum_base.sim.config import SimConfig

SLOWEST = 0.25  # s of real time the simulation may lie behind before it gives up catching up
STRIDE_NS = 10_000_000  # simulated time between two messages on /clock at most
_NANOSECONDS = 1_000_000_000


class Pace:
    """Targets for simulated time that starts at ``start_ns`` now; ``wall`` gives real seconds."""

    def __init__(self, sim: SimConfig, start_ns: int,
                 wall: Callable[[], float] = time.monotonic) -> None:
        self._wall = wall
        self._is_clock = sim.publish_clock
        self._factor = sim.rate_factor if sim.publish_clock else 1.0
        self._timeout = sim.command_timeout
        self._began, self._start_ns = wall(), start_ns
        self._commanded: tuple[float, int] | None = None
        self.given_up = 0.0  # s of simulated time

    def commanded(self, now_ns: int) -> None:
        """Wheel commands arrived at simulated time ``now_ns``."""
        self._commanded = self._wall(), now_ns

    def strides(self, now_ns: int) -> Iterator[int]:
        """The times to step to, one after the other, from simulated time ``now_ns`` on."""
        target = self.target(now_ns)
        while now_ns < target:
            now_ns = min(now_ns + STRIDE_NS, target)
            yield now_ns

    def target(self, now_ns: int) -> int:
        """The time that simulated time may reach, which is now ``now_ns``; never before it."""
        wall = self._wall()
        target = self._start_ns + round((wall - self._began) * self._factor * _NANOSECONDS)
        excess = target - now_ns - round(SLOWEST * self._factor * _NANOSECONDS)
        if excess > 0:
            self.given_up += excess / _NANOSECONDS
            self._start_ns -= excess
            target -= excess
        if self._is_clock and self._commanded is not None:
            arrived, at_ns = self._commanded
            if wall - arrived < self._timeout:
                target = min(target, at_ns + round(0.5 * self._timeout * _NANOSECONDS))
        return max(target, now_ns)
