"""`mecanum combos`: what each of the 81 wheel combinations does, or one with unequal speeds."""

from __future__ import annotations

import argparse
import csv
import json
import math
import pathlib
from typing import Any

import numpy as np

from mecanum_base.cli.columns import align
from mecanum_base.core.combinations.table import (
    CAVEAT,
    Combination,
    Counts,
    Numbering,
    combine,
    count,
    drive_of,
    number_wheels,
    survey,
)
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import null_vector
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.turning.centre import turn_of_rates
from mecanum_base.core.turning.two_wheel import free_motion
from mecanum_base.robot_file import load_robot, shipped

HELP = 'what each of the 81 wheel combinations (+, 0, -) of a four-wheel base does'
EXAMPLE = """mecanum combos
mecanum combos --robot my_robot.yaml --csv combos.csv --json combos.json
mecanum combos --speeds 2,1,2,-1        # one combination, unequal speeds [rad/s]"""
FREE = {'unique': 'moves', 'underdetermined': 'open', 'slip': 'slips', 'stop': 'stop'}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the verb."""
    parser.add_argument('--robot', metavar='FILE', help='robot file with four wheels (default: '
                        'the shipped mecanum4.yaml)')
    parser.add_argument('--speeds', metavar='A,B,C,D', type=_speeds,
                        help='one combination instead of the table: wheel rates [rad/s] in the '
                        'order of wheels.joint (write --speeds=-1,... for a negative first one)')
    parser.add_argument('--rate', metavar='RAD/S', type=float, default=1.0,
                        help='wheel rate of the table (default %(default)s)')
    parser.add_argument('--csv', metavar='FILE', type=pathlib.Path, help='write the table as CSV')
    parser.add_argument('--json', metavar='FILE', type=pathlib.Path,
                        help='write table and counts as JSON')


def _speeds(text: str) -> np.ndarray:
    try:
        values = [float(part) for part in text.split(',')]
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r} is no list of numbers') from None
    if len(values) != 4 or not all(math.isfinite(value) for value in values):
        raise argparse.ArgumentTypeError('needs four finite numbers, as in 2,1,2,-1')
    return np.array(values)


def run(options: argparse.Namespace) -> int:
    """Print and write; ConfigError for a robot without exactly four roller wheels."""
    path = options.robot or shipped() / 'mecanum4.yaml'
    wheels = load_robot(path).base
    if not isinstance(wheels, Wheels) or wheels.count != 4:
        raise ConfigError(str(path), None, 'must describe a base with four roller wheels')
    if not (math.isfinite(options.rate) and options.rate > 0.0):
        raise ConfigError('--rate', options.rate, 'must be > 0', 'rad/s')
    numbering = number_wheels(wheels)
    print('\n'.join(_header(wheels, numbering)))
    if options.speeds is not None:
        found: tuple[Combination, ...] = (combine(wheels, drive_of(numbering, options.speeds)),)
        counts = None
        print('\n'.join(_one(wheels, found[0])))
    else:
        found = survey(wheels, options.rate)
        counts = count(found)
        print('\n'.join([*_table(found), '', *_summary(counts)]))
    if options.csv:
        _write_csv(options.csv, wheels, found)
        print(f'written: {options.csv}')
    if options.json:
        _write_json(options.json, wheels, numbering, found, counts)
        print(f'written: {options.json}')
    return 0


def _header(wheels: Wheels, numbering: Numbering) -> list[str]:
    names = ', '.join(f'{i + 1} = {wheels.joint[k]}' for i, k in enumerate(numbering.order))
    null = null_vector(wheels_from_body(wheels))[list(numbering.order)] * numbering.forward
    order = 'as source T' if numbering.tlale else 'order of the file: not one wheel a quadrant'
    return [f'wheels ({order}): {names}',
            'sign: + drives forward; parity = n . rates, n = '
            + ', '.join(f'{value:+.4g}' for value in null)]


def _table(found: tuple[Combination, ...]) -> list[str]:
    rows = [['combo', 'driven', 'parity', 'vx [m/s]', 'vy [m/s]', 'wz [rad/s]', 'bearing [deg]',
             'no slip', 'stalls', 'idle free', 'Table I']]
    for item in found:
        verdict = item.verdict
        rows.append([item.pattern, str(verdict.driven), f'{verdict.parity:+.3g}',
                     *(f'{value:+.4f}' for value in verdict.twist), _bearing(item),
                     'yes' if verdict.no_slip else '-', 'yes' if verdict.stalls else '-',
                     FREE[verdict.free_idle], item.label or '-'])
    return align(rows, indent='')


def _bearing(item: Combination) -> str:
    bearing = item.verdict.bearing
    return '-' if math.isnan(bearing) else f'{math.degrees(bearing):+.1f}'


def _summary(counts: Counts) -> list[str]:
    return [
        'twist: least squares, idle wheels held, mean contact correction included; bearing from '
        'forward, counter-clockwise',
        'no slip, stalls: idle wheels locked, equal loads; idle free: idle wheels turn freely',
        '',
        f'{counts.total} combinations',
        f'  {counts.no_slip:3d}  fit one rigid motion without slip, idle wheels locked (stop '
        'included)',
        f'  {counts.parity_within_one:3d}  |parity| <= rate',
        f'  {counts.stalled:3d}  stall: driven, but at rest with idle wheels locked',
        f'  {counts.not_stalled:3d}  do not stall (stop included)',
        f'  {counts.no_twist:3d}  least-squares twist 0 (stop included)',
        f'  {counts.free_unique:3d} / {counts.free_open} / {counts.free_slip}  with free idle '
        'wheels: move / leave a motion open / slip',
        CAVEAT]


def _one(wheels: Wheels, item: Combination) -> list[str]:
    verdict = item.verdict
    turn = turn_of_rates(wheels, verdict.rates)
    centre = ('none, it translates' if turn.centre is None else
              f'({_clean(turn.centre[0]):.4g}, {_clean(turn.centre[1]):.4g}) m, '
              f'{turn.radius:.4g} m from the middle')
    rows = [['wheel', 'rate [rad/s]', 'slip [rad/s]']]
    for k, name in enumerate(wheels.joint):
        rows.append([name, f'{verdict.rates[k]:+.4g}', f'{_clean(turn.residual[k]):+.4g}'])
    lines = ['', *align(rows), '', f'  pattern     {item.pattern} (wheels 1 to 4)',
             f'  parity      {verdict.parity:+.4g} rad/s: '
             + ('no slip' if verdict.no_slip else 'the rates contradict each other: slip'),
             f'  twist       {_twist(verdict.twist)} (least squares, idle wheels held)',
             f'  bearing     {_bearing(item)} deg from forward',
             f'  centre      {centre}',
             f'  idle locked {"stalls" if verdict.stalls else "moves"}',
             f'  idle free   {verdict.free_idle}']
    if item.label:
        lines.append(f'  Table I     {item.label}')
    driven = [i for i in range(4) if verdict.rates[i] != 0.0]
    if 0 < len(driven) < 4 and verdict.free_idle == 'underdetermined':
        free = free_motion(wheels, driven, verdict.rates[driven].tolist())
        lines.append(f'              least drag of the idle wheels: {_twist(free.twist)}')
    return lines


def _clean(value: float) -> float:
    """Without rounding noise, for people."""
    return round(float(value), 9) + 0.0


def _twist(twist: np.ndarray) -> str:
    vx, vy, wz = (_clean(value) for value in twist)
    return f'vx {vx:+.4f} m/s, vy {vy:+.4f} m/s, wz {wz:+.4f} rad/s'


def _record(item: Combination, wheels: Wheels) -> dict[str, Any]:
    verdict = item.verdict
    bearing = None if math.isnan(verdict.bearing) else math.degrees(verdict.bearing)
    return {'combination': item.pattern, 'driven': verdict.driven,
            **{f'{name}.rate': float(rate) for name, rate in zip(wheels.joint, verdict.rates)},
            'parity': verdict.parity, 'vx': float(verdict.twist[0]), 'vy': float(verdict.twist[1]),
            'wz': float(verdict.twist[2]), 'bearing_deg': bearing, 'no_slip': verdict.no_slip,
            'stalls_if_idle_wheels_locked': verdict.stalls, 'idle_free': verdict.free_idle,
            'table_I': item.label}


def _write_csv(path: pathlib.Path, wheels: Wheels, found: tuple[Combination, ...]) -> None:
    records = [_record(item, wheels) for item in found]
    with _open(path) as file:
        writer = csv.DictWriter(file, list(records[0]))
        writer.writeheader()
        writer.writerows(records)


def _write_json(path: pathlib.Path, wheels: Wheels, numbering: Numbering,
                found: tuple[Combination, ...], counts: Counts | None) -> None:
    document = {
        'units': 'm, rad, s; bearing_deg from forward, counter-clockwise',
        'wheels': {str(i + 1): wheels.joint[k] for i, k in enumerate(numbering.order)},
        'combinations': [_record(item, wheels) for item in found]}
    if counts is not None:
        document['counts'] = {key: getattr(counts, key) for key in counts.__slots__}
        document['caveat'] = CAVEAT
    with _open(path) as file:
        json.dump(document, file, indent=1)
        file.write('\n')


def _open(path: pathlib.Path) -> Any:
    try:
        return path.open('w', encoding='utf-8', newline='')
    except OSError as error:
        raise ConfigError(str(path), None, f'cannot be written: {error.strerror}') from None
