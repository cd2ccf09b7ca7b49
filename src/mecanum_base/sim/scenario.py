"""A scenario: robot, floor, driver, events, seed and duration of one simulated run."""

from __future__ import annotations

from dataclasses import dataclass, field

from mecanum_base.sim.faults import Event
from mecanum_base.sim.floor import Floor


@dataclass(frozen=True, slots=True, eq=False)
class Scenario:
    """What happens in one run; the default is a bare level floor and nobody driving."""

    name: str = 'bare'
    title: str = ''
    robot: str = 'mecanum4.yaml'
    duration: float = 10.0
    seed: int = 1
    floor: Floor = field(default_factory=Floor)
    events: tuple[Event, ...] = ()
