"""Two results of ``analyze`` side by side: other constants, other figures, better or worse.

Either the same recording with two robot files, or two recordings. A figure is better if it is
smaller (errors), nearer to 1 (scales) or nearer to 0 (offsets); changes below 1 % are none.
"""

from __future__ import annotations

import math
import pathlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from mecanum_base.bag.summary import plain
from mecanum_base.robot import BLOCKS, Robot, all_rules
from mecanum_base.robot_file import load_robot

_SAME = 0.01
_LESS, _ONE, _ZERO, _EITHER = 'less', 'one', 'zero', ''
# number of a finding: (codes that carry it, label, unit, factor to that unit, what is better)
_NUMBERS: tuple[tuple[tuple[str, ...], str, str, str, float, str], ...] = (
    *((('scales_off', 'scales_agree', 'scales_unclear'), axis, f'truth over wheels, {axis}', '',
       1.0, _ONE) for axis in ('forward', 'sideways', 'turning', 'distance')),
    (('yaw_scale', 'yaw_agrees', 'yaw_sign', 'yaw_disagrees'), 'scale', 'gyro over wheels, yaw',
     '', 1.0, _ONE),
    (('yaw_scale', 'yaw_agrees', 'yaw_sign', 'yaw_disagrees'), 'fit', 'gyro explained by wheels',
     '%', 100.0, _EITHER),
    (('time_offset',), 'offset', 'gyro behind the wheels', 'ms', 1e3, _ZERO),
    (('parity',), 'rms', 'contradiction of the wheels', 'mm/s', 1e3, _LESS),
    (('slip',), 'episodes', 'slip episodes', '', 1.0, _LESS),
    (('slip',), 'seconds', 'time with slip', 's', 1.0, _LESS),
    (('slip',), 'largest', 'longest slip', 'm', 1.0, _LESS),
    (('gyro_bias',), 'z', 'gyro bias at rest', 'rad/s', 1.0, _ZERO),
    (('gravity_leak',), 'tilt', 'tilt of the IMU', 'deg', 180.0 / math.pi, _ZERO),
    (('vibration',), 'rms', 'vibration', 'm/s2', 1.0, _LESS),
    (('gaps',), 'share', 'messages missing', '%', 100.0, _LESS),
    *((('commands_followed', 'commands_missed', 'commands_ignored'), axis,
       f'done of what was asked, {axis}', '', 1.0, _ONE) for axis in ('vx', 'vy', 'wz')))
_DRIFT = (('ate', 'ATE', 'm', 1.0), ('ate_best', 'ATE, best alignment', 'm', 1.0),
          ('final', 'final error', 'm', 1.0), ('yaw_final', 'final yaw error', 'deg',
                                               180.0 / math.pi),
          ('yaw_rms', 'yaw error rms', 'deg', 180.0 / math.pi))


def compare(results: Sequence[dict[str, Any]], by_file: bool) -> list[dict[str, Any]]:
    """Put a ``comparison`` into one result of each pair, and return all of them.

    ``by_file``: results come in pairs, one recording with two robot files, and get the name of
    the file behind their own; else the last result is compared with each of the others.
    """
    if by_file:
        for result in results:
            result['name'] += f' ({pathlib.PurePath(result["robot_file"]).name})'
    pairs = list(zip(results[::2], results[1::2])) if by_file else [
        (result, results[-1]) for result in results[:-1]]
    found = [compared(a, b, (_robot(a), _robot(b))) for a, b in pairs]
    for (first, second), comparison in zip(pairs, found):
        (second if by_file else first)['comparison'] = comparison
    return found


def _robot(result: dict[str, Any]) -> Robot | None:
    return load_robot(result['robot_file']) if result['robot_file'] else None


def compared(first: dict[str, Any], second: dict[str, Any], robots: tuple[Robot | None,
                                                                         Robot | None]
             ) -> dict[str, Any]:
    """What differs, as JSON values: ``constants``, ``figures``, findings ``gone`` and ``new``."""
    one, other = robots
    before, after = _named(first), _named(second)
    return {
        'first': first['name'], 'second': second['name'],
        'constants': constants(one, other) if one is not None and other is not None else [],
        'figures': figures(first, second),
        'gone': [before[key] for key in before if key not in after],
        'new': [after[key] for key in after if key not in before]}


def constants(first: Robot, second: Robot) -> list[dict[str, Any]]:
    """Parameters that differ: key, unit, both values, and the change in words."""
    found = []
    for key, rule in all_rules().items():
        a, b = (_value(robot, key) for robot in (first, second))
        if a != b:
            found.append({'key': key, 'unit': rule.unit, 'first': a, 'second': b,
                          'change': _change(a, b)})
    return found


def _value(robot: Robot, key: str) -> Any:
    """Value of a parameter as JSON; None where this kind of base has none."""
    block, _, name = key.rpartition('.')
    if block in ('wheels', 'carriers'):
        return plain(getattr(robot.base, name)) if isinstance(robot.base, BLOCKS[block]) else None
    section = getattr(robot, block) if block else robot.frames
    return plain(getattr(section, name))


def _change(first: Any, second: Any) -> str:
    """In percent where every number changes by a factor, else by how much at most."""
    try:
        a, b = np.array(first, dtype=float).ravel(), np.array(second, dtype=float).ravel()
    except (TypeError, ValueError):
        return ''
    if a.shape != b.shape or not len(a):
        return ''
    if (a * b > 0.0).all():
        low, high = 100.0 * float((b / a).min() - 1.0), 100.0 * float((b / a).max() - 1.0)
        return f'{low:+.2f} %' if high - low < 0.005 else f'{low:+.2f} to {high:+.2f} %'
    return f'by up to {float(np.abs(b - a).max()):.4g}'


def figures(first: dict[str, Any], second: dict[str, Any]) -> list[dict[str, Any]]:
    """All figures of both: name, unit, both values, their difference and the verdict."""
    a, b = _figures(first), _figures(second)
    found = []
    for name in [*a, *(n for n in b if n not in a)]:
        unit, rule = (a.get(name) or b[name])[1:]
        old, new = (side[name][0] if name in side else None for side in (a, b))
        found.append({'figure': name, 'unit': unit, 'first': old, 'second': new,
                      'change': None if old is None or new is None else new - old,
                      'verdict': verdict(old, new, rule)})
    return found


def verdict(first: float | None, second: float | None, rule: str) -> str:
    """'better', 'worse', 'same', or empty where neither can be said."""
    if first is None or second is None:
        return ''
    if abs(second - first) <= _SAME * max(abs(first), abs(second)):
        return 'same'
    if rule == _EITHER:
        return ''
    ideal = 1.0 if rule == _ONE else 0.0
    return 'better' if abs(second - ideal) < abs(first - ideal) else 'worse'


def _figures(result: dict[str, Any]) -> dict[str, tuple[float, str, str]]:
    """{name: (value, unit, what is better)} of one result."""
    found: dict[str, tuple[float, str, str]] = {
        f'{severity}s': (float(result['counts'][severity]), '', _LESS)
        for severity in ('blocker', 'warning')}
    for drift in result['drift']:
        for key, label, unit, factor in _DRIFT:
            if drift[key] is not None:
                found[f'{drift["name"]}: {label}'] = (abs(drift[key]) * factor, unit, _LESS)
        for length, values in drift['rpe'].items():
            found[f'{drift["name"]}: RPE over {length} m'] = (100.0 * values['share'], '%', _LESS)
    for finding in result['findings']:
        for codes, key, label, unit, factor, rule in _NUMBERS:
            value = finding['numbers'].get(key)
            if finding['code'] in codes and value is not None:
                where = f' ({finding["topic"]})' if finding['code'] == 'gaps' else ''
                found[label + where] = (value * factor, unit, rule)
    return found


def _named(result: dict[str, Any]) -> dict[tuple[str, str, str], dict[str, str]]:
    """Findings that are more than notes, by code, topic and title."""
    return {(f['code'], f['topic'], f['title']): {'severity': f['severity'], 'title': f['title']}
            for f in result['findings'] if f['severity'] != 'note'}


def over_all(comparisons: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Each figure over several recordings: means, and in how many it is better or worse."""
    rows: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for comparison in comparisons:
        for row in comparison['figures']:
            if row['change'] is not None:
                rows.setdefault((row['figure'], row['unit']), []).append(row)
    return [{'figure': name, 'unit': unit, 'recordings': len(group),
             'first': float(np.mean([r['first'] for r in group])),
             'second': float(np.mean([r['second'] for r in group])),
             **{word: sum(r['verdict'] == word for r in group) for word in ('better', 'worse')}}
            for (name, unit), group in rows.items()]


def table_of(comparison: dict[str, Any]) -> list[list[str]]:
    """The changed figures as text rows: figure, first, second, change, verdict."""
    return [[row['figure'] + (f' [{row["unit"]}]' if row['unit'] else ''), number(row['first']),
             number(row['second']), '-' if row['change'] is None else f'{row["change"]:+.3g}',
             row['verdict'] or '-']
            for row in comparison['figures'] if row['verdict'] != 'same']


def number(value: float | None) -> str:
    """Four digits, or a dash."""
    return '-' if value is None else f'{value:.4g}'


def listed(value: Any) -> str:
    """A constant as text; a list of equal numbers as one."""
    if isinstance(value, list) and len(value) > 2 and all(v == value[0] for v in value):
        return f'{listed(value[0])} (all {len(value)})'
    if isinstance(value, list):
        return '[' + ', '.join(listed(v) for v in value) + ']'
    return f'{value:.6g}' if isinstance(value, float) else '-' if value is None else str(value)
