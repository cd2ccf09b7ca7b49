"""Which faults and disturbances act now, and their effect on the tables of the plant."""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.parameter import FloatArray
from mecanum_base.sim import layout as at
from mecanum_base.sim.encoder import Encoders
from mecanum_base.sim.faults import NANOSECONDS, Event, make_event
from mecanum_base.sim.plant import Plant

NEVER = 1 << 62  # ns, later than any run


class Injection:
    """The events of a scenario and those injected while it runs, for a base of W wheels."""

    def __init__(self, events: tuple[Event, ...], count: int) -> None:
        for event in events:  # a scenario file does not know how many wheels the robot has
            make_event(event.kind, event.start_ns, event.end_ns, event.wheels,
                       event.vector if event.kind in ('push', 'shove') else event.value,
                       count=count)
        self._planned, self._count = events, count
        self._held: Event | None = None
        self.restart()

    def restart(self) -> None:
        """Forget what was injected; the scenario's events and the held fault will act again."""
        self._events = list(self._planned)
        self._begun: set[int] = set()
        self.active: dict[str, Event] = {}
        self.clock_offset_ns = 0
        self.gains = [1.0] * self._count
        if self._held is not None:
            self._events.append(self._held)

    def add(self, kind: str, elapsed_ns: int, duration: float, wheels: tuple[int, ...],
            value: float | FloatArray | None) -> Event:
        """Add an event from now on for ``duration`` [s]; ConfigError where it is bad."""
        end = NEVER if math.isinf(duration) else elapsed_ns + round(duration * NANOSECONDS)
        event = make_event(kind, elapsed_ns, end, wheels, value, count=self._count)
        self._events.append(event)
        return event

    def hold(self, kind: str, elapsed_ns: int, wheels: tuple[int, ...],
             value: float | None) -> None:
        """Replace the held fault: it lasts until the next call ('none' ends it)."""
        if self._held is not None:
            self._events.remove(self._held)
            self._held = None
        if kind != 'none':
            self._held = self.add(kind, elapsed_ns, math.inf, wheels, value)

    def apply(self, plant: Plant, encoders: Encoders, elapsed_ns: int) -> int:
        """Write the effects that hold from now on; returns the time of the next change (ns)."""
        self.active = {}
        self.gains = [1.0] * self._count
        change = NEVER
        inputs, push = plant.inputs, plant.push
        total = np.zeros(5)
        for i in range(self._count):
            row = i * at.INPUT
            inputs[row + at.I_GRIP], inputs[row + at.I_DROP] = 1.0, 0.0
            inputs[row + at.I_JAM], inputs[row + at.I_FREE] = 0.0, 0.0
        for event in self._events:
            if event.start_ns > elapsed_ns:
                change = min(change, event.start_ns)
                continue
            if id(event) not in self._begun:
                self._begun.add(id(event))
                self._begin(event, encoders)
            if event.end_ns <= elapsed_ns:
                continue
            change = min(change, event.end_ns)
            self.active[event.kind] = event
            if event.kind == 'push':
                total[:3] += event.vector
            elif event.kind == 'shove':
                total[2:] += event.vector[[2, 0, 1]]
            for i in range(self._count):
                if event.concerns(i):
                    self._act(event, i, inputs, i * at.INPUT)
        for k in range(5):
            push[k] = float(total[k])
        return change

    def _begin(self, event: Event, encoders: Encoders) -> None:
        if event.kind == 'time_jump':
            self.clock_offset_ns += round(event.value * NANOSECONDS)
        elif event.kind == 'encoder_reset':
            for i in range(self._count):
                if event.concerns(i):
                    encoders.reset(i)

    def _act(self, event: Event, wheel: int, inputs: list[float], row: int) -> None:
        if event.kind == 'encoder_stuck':
            self.gains[wheel] = 0.0
        elif event.kind == 'encoder_reversed':
            self.gains[wheel] = -1.0
        elif event.kind == 'jam':
            inputs[row + at.I_JAM] = 1.0
        elif event.kind == 'free':
            inputs[row + at.I_FREE] = 1.0
        elif event.kind == 'lift':
            inputs[row + at.I_DROP] = event.value
        elif event.kind == 'grip':
            inputs[row + at.I_GRIP] *= event.value
