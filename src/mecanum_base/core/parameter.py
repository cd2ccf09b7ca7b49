"""Fields of configuration sections: one place for default, unit, meaning and rule of a value.

A section of the robot file is a frozen dataclass whose fields are made by :func:`parameter`.
:func:`read_section` turns a mapping (from YAML or from ROS 2 parameters) into such a dataclass;
every violation is a :class:`~mecanum_base.core.errors.ConfigError` with key path, value, rule and
unit. Values are never repaired. Integers are accepted where floats are meant, because YAML and
ROS 2 write ``1`` for ``1.0``.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mecanum_base.core.errors import ConfigError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Section = TypeVar('Section')

KINDS = ('float', 'int', 'bool', 'str', 'floats', 'ints', 'strs', 'float_or_floats')


@dataclass(frozen=True, slots=True)
class Rule:
    """What is known of one parameter: its kind, unit, meaning and allowed values.

    ``low`` and ``high`` are inclusive unless ``open_low`` is set; they apply to each element of an
    array. ``live`` parameters may be changed while a node runs, all others only at start-up.
    """

    kind: str
    unit: str
    meaning: str
    low: float | None = None
    high: float | None = None
    open_low: bool = False
    choices: tuple[str, ...] = ()
    live: bool = False

    def text(self) -> str:
        """Meaning, unit and range in one line, as shown in ROS 2 parameter descriptions."""
        parts = [self.meaning]
        if self.unit:
            parts.append(f'[{self.unit}]')
        if self.choices:
            parts.append('one of ' + ', '.join(self.choices))
        elif self.low is not None or self.high is not None:
            parts.append(self.range_text())
        return ' '.join(parts)

    def range_text(self) -> str:
        """The allowed range in words, for instance ``must be > 0``."""
        low = None if self.low is None else f'{">" if self.open_low else ">="} {self.low:g}'
        high = None if self.high is None else f'<= {self.high:g}'
        return 'must be ' + ' and '.join(part for part in (low, high) if part)


def parameter(
    kind: str,
    unit: str,
    meaning: str,
    *,
    default: Any = dataclasses.MISSING,
    low: float | None = None,
    high: float | None = None,
    open_low: bool = False,
    choices: Sequence[str] = (),
    live: bool = False,
) -> Any:
    """Return a dataclass field that carries its :class:`Rule`; without ``default`` it is required.

    ``kind`` is one of :data:`KINDS`; ``float_or_floats`` accepts a number or one number a wheel.
    """
    if kind not in KINDS:
        raise ValueError(f'unknown kind {kind!r}')
    rule = Rule(kind, unit, meaning, low, high, open_low, tuple(choices), live)
    return dataclasses.field(default=default, metadata={'rule': rule})


def rules(section: type[Any]) -> dict[str, Rule]:
    """Rules of all fields of a section class, by field name, in the order of the file."""
    return {f.name: f.metadata['rule'] for f in dataclasses.fields(section)
            if 'rule' in f.metadata}


def nearest(key: str, known: Sequence[str]) -> str:
    """A hint that names the known key nearest to ``key``."""
    close = difflib.get_close_matches(key, known, n=1, cutoff=0.0)
    return f'did you mean {close[0]!r}?' if close else 'no keys are known here'


def read_section(section: type[Section], mapping: object, path: str) -> Section:
    """Build ``section`` from ``mapping``; ``path`` is the key path shown in errors.

    Raises ConfigError for unknown keys (naming the nearest known one), missing values, wrong types
    and values out of range, and re-raises errors of the section's own checks under ``path``.
    """
    known = rules(section)
    if not isinstance(mapping, Mapping):
        raise ConfigError(path, mapping, 'must be a block of keys and values')
    for key in mapping:
        if key not in known:
            raise ConfigError(f'{path}.{key}', mapping[key],
                              f'unknown key, {nearest(str(key), list(known))}')
    values: dict[str, Any] = {}
    for name, rule in known.items():
        if name in mapping:
            values[name] = convert(mapping[name], rule, f'{path}.{name}')
    for item in dataclasses.fields(section):  # type: ignore[arg-type]
        if item.name in known and item.name not in values and item.default is dataclasses.MISSING:
            rule = known[item.name]
            raise ConfigError.missing(f'{path}.{item.name}', rule.meaning, rule.unit)
    try:
        return section(**values)
    except ConfigError as error:
        raise error.under(path) from None


def convert(value: object, rule: Rule, key: str) -> Any:
    """``value`` checked against ``rule`` and turned into float, int, bool, str or array."""
    if rule.kind == 'float_or_floats':
        if isinstance(value, (str, Mapping)) or not isinstance(value, Sequence):
            if not isinstance(value, np.ndarray):
                return _number(value, rule, key)
        return _array(value, rule, key, np.float64)
    if rule.kind == 'floats':
        return _array(value, rule, key, np.float64)
    if rule.kind == 'ints':
        return _array(value, rule, key, np.int64)
    if rule.kind == 'strs':
        items = _items(value, rule, key)
        return tuple(_text(item, rule, f'{key}[{i}]') for i, item in enumerate(items))
    if rule.kind == 'bool':
        if not isinstance(value, (bool, np.bool_)):
            raise ConfigError(key, value, 'must be true or false')
        return bool(value)
    if rule.kind == 'str':
        return _text(value, rule, key)
    number = _number(value, rule, key)
    if rule.kind == 'int':
        return _whole(number, rule, key)
    return number


def _items(value: object, rule: Rule, key: str) -> list[object]:
    if isinstance(value, (str, bytes, Mapping)) or not hasattr(value, '__iter__'):
        raise ConfigError(key, value, 'must be a list', rule.unit)
    return list(value)


def _array(value: object, rule: Rule, key: str, dtype: Any) -> NDArray[Any]:
    numbers = [_number(item, rule, f'{key}[{i}]')
               for i, item in enumerate(_items(value, rule, key))]
    if dtype is np.int64:
        numbers = [_whole(number, rule, f'{key}[{i}]') for i, number in enumerate(numbers)]
    array = np.array(numbers, dtype=dtype)
    array.setflags(write=False)
    return array


def _number(value: object, rule: Rule, key: str) -> float:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.number)):
        raise ConfigError(key, value, 'must be a number', rule.unit)
    number = float(value)
    if not math.isfinite(number):
        raise ConfigError(key, value, 'must be finite', rule.unit)
    low_broken = rule.low is not None and (number <= rule.low if rule.open_low
                                           else number < rule.low)
    if low_broken or (rule.high is not None and number > rule.high):
        raise ConfigError(key, value, rule.range_text(), rule.unit)
    return number


def _whole(number: float, rule: Rule, key: str) -> int:
    if number != math.floor(number):
        raise ConfigError(key, number, 'must be a whole number', rule.unit)
    if rule.choices and str(int(number)) not in rule.choices:
        raise ConfigError(key, int(number), 'must be one of ' + ', '.join(rule.choices), rule.unit)
    return int(number)


def _text(value: object, rule: Rule, key: str) -> str:
    if not isinstance(value, str):
        raise ConfigError(key, value, 'must be a text', rule.unit)
    if rule.choices and value not in rule.choices:
        raise ConfigError(key, value, 'must be one of ' + ', '.join(rule.choices))
    return value


def frozen_floats(value: object) -> FloatArray:
    """A read-only float64 copy of ``value``."""
    array: FloatArray = np.array(value, dtype=np.float64)
    array.setflags(write=False)
    return array
