"""The keys of a scenario file as text, from the rules that check them."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Iterator
from typing import Any

from mecanum_base.core.parameter import rules
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.driving import Follow, ScriptLimits, Segment
from mecanum_base.sim.faults import DISTURBANCES, FAULTS, Kind
from mecanum_base.sim.floor import Floor, Patch, Ramp, Wall
from mecanum_base.sim.scenario import Scenario

_SECTIONS: tuple[tuple[str, type[Any]], ...] = (
    ('at the top', Scenario), ('floor:', Floor), ('floor: patches: - ', Patch),
    ('floor: ramps: - ', Ramp), ('floor: walls: - ', Wall),
    ('driver: script: - ', Segment), ('driver:, beside script', ScriptLimits),
    ('driver:, beside points: [[x, y, yaw, pause], ...], circle: {}, figure8: {}, wander: {}',
     Follow))


def describe() -> str:
    """Every key with its meaning, unit, range and default, one a line."""
    lines = ['Keys of a scenario file (every one may be left out but those marked "needed"):']
    for title, section in _SECTIONS:
        lines += ['', title, *_keys(section)]
    lines += ['', 'events: - {kind: ..., at: [s], for: [s], wheels: [by index; none = all], '
              'value: ...}']
    for name, kind in {**FAULTS, **DISTURBANCES}.items():
        lines.append(f'  {name:<18} {kind.meaning}{_value(kind)}')
    lines += ['', 'sim: (as in the robot file; what stands here wins)', *_keys(SimConfig)]
    return '\n'.join(lines)


def _keys(section: type[Any]) -> Iterator[str]:
    defaults = {f.name: f.default for f in dataclasses.fields(section)}
    for name, rule in rules(section).items():
        default = defaults[name]
        if default is dataclasses.MISSING:
            shown = 'needed'
        elif isinstance(default, tuple):
            shown = f'default {list(default)}'
        else:
            shown = f'default {default!r}'
        yield from textwrap.wrap(f'{name:<18} {rule.text()} ({shown})', 96, initial_indent='  ',
                                 subsequent_indent=' ' * 21)


def _value(kind: Kind) -> str:
    if kind.vector:
        return f'; value [{kind.unit}]'
    return f'; value [{kind.unit or "-"}], usually {kind.usual:g}' if kind.usual else ''
