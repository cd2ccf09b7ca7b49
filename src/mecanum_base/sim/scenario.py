"""A scenario: robot, floor, driver, events, seed and duration of one simulated run."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import (
    Rule,
    convert,
    nearest,
    parameter,
    read_section,
    rules,
)
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.driver import Driver
from mecanum_base.sim.driving import Driving, read_driving
from mecanum_base.sim.faults import KINDS, NANOSECONDS, Event, make_event
from mecanum_base.sim.floor import Floor, Patch, Ramp, Wall

_NUMBER, _WHEELS = Rule('float', '', ''), Rule('ints', '', '', low=0)


@dataclass(frozen=True, slots=True, eq=False)
class Scenario:
    """What happens in one run; the default is a bare level floor and nobody driving.

    ``sim`` holds the values of block ``sim`` that the scenario replaces; :meth:`settings` applies
    them. ``driving`` makes the driver of a headless run; sim_node uses floor and events only.
    """

    title: str = parameter('str', '', 'what it shows, in one line', default='')
    robot: str = parameter('str', '', 'robot file beside this file, or a shipped one',
                           default='mecanum4.yaml')
    duration: float = parameter('float', 's', 'how long it lasts', default=10.0, low=0.0,
                                open_low=True, high=86400.0)
    seed: int = parameter('int', '', 'seed of every random number', default=1, low=0)
    name: str = 'bare'
    sim: Mapping[str, Any] = field(default_factory=dict)
    floor: Floor = field(default_factory=Floor)
    driving: Driving = field(default_factory=Driving)
    events: tuple[Event, ...] = ()

    def settings(self, config: SimConfig) -> SimConfig:
        """``config`` with the values this scenario replaces."""
        return dataclasses.replace(config, **self.sim)

    def driver(self, seed: int | None = None) -> Driver:
        """A fresh driver; ``twist(time [s], true pose)`` says how to drive."""
        return self.driving.driver(self.seed if seed is None else seed)

    def replace(self, **changes: Any) -> Scenario:
        """A copy with some fields replaced."""
        return dataclasses.replace(self, **changes)


def scenario_from_mapping(mapping: object, name: str) -> Scenario:
    """Check and assemble; ConfigError names key path, value, rule and unit."""
    if not isinstance(mapping, Mapping):
        raise ConfigError('scenario', mapping, 'must be a block of keys and values')
    blocks = ('sim', 'floor', 'driver', 'events')
    known = [*rules(Scenario), *blocks]
    for key in mapping:
        if key not in known:
            raise ConfigError(str(key), mapping[key], f'unknown key, {nearest(str(key), known)}')
    plain = {key: mapping[key] for key in rules(Scenario) if key in mapping}
    head = {key: convert(value, rules(Scenario)[key], key) for key, value in plain.items()}
    return Scenario(**head, name=name, sim=_replaced(mapping.get('sim', {})),
                    floor=_floor(mapping.get('floor', {})),
                    driving=read_driving(mapping['driver'], 'driver') if 'driver' in mapping
                    else Driving(),
                    events=_events(mapping.get('events', [])))


def _replaced(block: object) -> dict[str, Any]:
    section = read_section(SimConfig, block, 'sim')
    assert isinstance(block, Mapping)
    return {key: getattr(section, key) for key in block}


def _floor(block: object) -> Floor:
    if not isinstance(block, Mapping):
        raise ConfigError('floor', block, 'must be a block of keys and values')
    lists: dict[str, type[Any]] = {'patches': Patch, 'ramps': Ramp, 'walls': Wall}
    plain = {key: value for key, value in block.items() if key not in lists}
    parts: dict[str, Any] = {}
    for key, section in lists.items():
        entries = block.get(key, [])
        if not isinstance(entries, list):
            raise ConfigError(f'floor.{key}', entries, 'must be a list')
        parts[key] = tuple(read_section(section, entry, f'floor.{key}[{i}]')
                           for i, entry in enumerate(entries))
    for key in plain:
        if key not in rules(Floor):
            raise ConfigError(f'floor.{key}', plain[key],
                              f'unknown key, {nearest(str(key), [*rules(Floor), *lists])}')
    return dataclasses.replace(read_section(Floor, plain, 'floor'), **parts)


def _events(block: object) -> tuple[Event, ...]:
    if not isinstance(block, list):
        raise ConfigError('events', block, 'must be a list')
    return tuple(_event(entry, f'events[{i}]') for i, entry in enumerate(block))


def _event(entry: object, path: str) -> Event:
    if not isinstance(entry, Mapping):
        raise ConfigError(path, entry, 'must be a block of keys and values')
    keys = ('kind', 'at', 'for', 'wheels', 'value')
    for key in entry:
        if key not in keys:
            raise ConfigError(f'{path}.{key}', entry[key],
                              f'unknown key, {nearest(str(key), list(keys))}')
    for key, meaning in (('kind', 'one of ' + ', '.join(KINDS)), ('at', 'when it begins')):
        if key not in entry:
            raise ConfigError.missing(f'{path}.{key}', meaning, 's' if key == 'at' else '')
    seconds = {key: convert(entry.get(key, 0.0), Rule('float', 's', '', low=0.0), f'{path}.{key}')
               for key in ('at', 'for')}
    wheels = tuple(int(w) for w in convert(entry.get('wheels', []), _WHEELS, f'{path}.wheels'))
    kind, value = entry['kind'], entry.get('value')
    if not isinstance(kind, str):
        raise ConfigError(f'{path}.kind', kind, 'must be a text')
    if value is not None:
        unit = KINDS[kind].unit if kind in KINDS else ''
        number = Rule('floats' if isinstance(value, list) else 'float', unit, '')
        value = convert(value, number, f'{path}.value')
    start = round(seconds['at'] * NANOSECONDS)
    try:
        return make_event(kind, start, start + round(seconds['for'] * NANOSECONDS), wheels, value)
    except ConfigError as error:
        raise error.under(path) from None
