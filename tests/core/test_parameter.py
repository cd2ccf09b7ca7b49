"""Fields of configuration sections: conversion, rules, errors that name what is wrong."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import Rule, convert, parameter, read_section, rules


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    speed: float = parameter('float', 'm/s', 'how fast', low=0.0, open_low=True, high=5.0)
    count: int = parameter('int', '', 'how many', default=3, low=0)
    mode: str = parameter('str', '', 'which way', default='auto', choices=('auto', 'hand'))
    flags: Any = parameter('ints', '', 'signs', default=())
    names: Any = parameter('strs', '', 'names', default=())
    on: bool = parameter('bool', '', 'is it on', default=True)
    gains: Any = parameter('floats', 's', 'gains', default=(), low=-1.0)
    scale: Any = parameter('float_or_floats', 'm', 'one or many', default=1.0)


def test_defaults_are_used_and_integers_are_taken_for_floats():
    section = read_section(Section, {'speed': 2}, 'block')
    assert section.speed == 2.0 and isinstance(section.speed, float)
    assert (section.count, section.mode, section.on) == (3, 'auto', True)


def test_lists_become_read_only_arrays():
    section = read_section(Section, {'speed': 1.0, 'gains': [1, 2.5], 'flags': [1, -1],
                                     'names': ['a', 'b'], 'scale': [1, 2]}, 'block')
    assert section.gains.dtype == np.float64 and section.flags.dtype == np.int64
    assert section.names == ('a', 'b') and section.scale.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match='read-only'):
        section.gains[0] = 0.0
    assert read_section(Section, {'speed': 1.0, 'scale': 2}, 'b').scale == 2.0


@pytest.mark.parametrize(('values', 'text'), [
    ({}, r'block\.speed: is missing and has no default: how fast \[m/s\]'),
    ({'speed': 0.0}, r'block\.speed = 0\.0: must be > 0 and <= 5 \[m/s\]'),
    ({'speed': 5.1}, 'must be > 0 and <= 5'),
    ({'speed': float('nan')}, 'must be finite'), ({'speed': float('inf')}, 'must be finite'),
    ({'speed': 'fast'}, 'must be a number'), ({'speed': True}, 'must be a number'),
    ({'speed': [1.0]}, 'must be a number'), ({'speed': None}, 'must be a number'),
    ({'speed': 1.0, 'count': 1.5}, 'must be a whole number'),
    ({'speed': 1.0, 'count': -1}, 'must be >= 0'),
    ({'speed': 1.0, 'mode': 'atuo'}, 'must be one of auto, hand'),
    ({'speed': 1.0, 'mode': 3}, 'must be a text'),
    ({'speed': 1.0, 'on': 1}, 'must be true or false'),
    ({'speed': 1.0, 'gains': 1.0}, 'must be a list'), ({'speed': 1.0, 'gains': 'abc'}, 'a list'),
    ({'speed': 1.0, 'gains': [0.0, -1.5]}, r'gains\[1\] = -1\.5: must be >= -1'),
    ({'speed': 1.0, 'flags': [1, 0.5]}, r'flags\[1\].*whole number'),
    ({'speed': 1.0, 'names': ['a', 3]}, r'names\[1\] = 3: must be a text'),
    ({'speed': 1.0, 'cuont': 3}, r"block\.cuont.*did you mean 'count'"),
    ([1, 2], 'must be a block'), (None, 'must be a block')])
def test_a_wrong_value_is_named_with_its_key_value_rule_and_unit(values, text):
    with pytest.raises(ConfigError, match=text):
        read_section(Section, values, 'block')


def test_rules_carry_unit_meaning_and_range_for_ros_descriptors():
    found = rules(Section)
    assert list(found)[:2] == ['speed', 'count']
    assert found['speed'].text() == 'how fast [m/s] must be > 0 and <= 5'
    assert found['mode'].text() == 'which way one of auto, hand'


def test_values_are_never_repaired():
    rule = Rule('float', 'm', 'x', low=0.0)
    with pytest.raises(ConfigError):
        convert(-1e-12, rule, 'x')
    assert convert(0.0, rule, 'x') == 0.0


def test_an_unknown_kind_is_a_mistake_of_the_programmer():
    with pytest.raises(ValueError, match='unknown kind'):
        parameter('double', '', 'x')


def test_errors_of_a_section_get_the_path_of_the_block():
    @dataclass(frozen=True)
    class Picky:
        x: float = parameter('float', '', 'x')

        def __post_init__(self):
            raise ConfigError('x', self.x, 'must be nicer')

    with pytest.raises(ConfigError, match=r'^outer\.x = 1\.0: must be nicer$'):
        read_section(Picky, {'x': 1.0}, 'outer')
