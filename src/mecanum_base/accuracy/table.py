"""Figures as text: one table to read on a terminal and in markdown, and plain JSON."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

from mecanum_base.accuracy.summary import (
    BAR_ORACLE,
    BAR_TWIST,
    SLACK,
    WORSE,
    ScenarioFigures,
    overall,
)
from mecanum_base.accuracy.trial import METHODS

Row = Sequence[str]


def tables(scenarios: Sequence[ScenarioFigures]) -> str:
    """Markdown tables, aligned so that they read well as plain text too."""
    parts = ['Segment drift over 5 m [% of distance, RMS over segments and seeds]',
             _method_table(scenarios, lambda e: _two(e.drift)),
             'Position error over the whole run, ATE RMS [m]',
             _method_table(scenarios, lambda e: f'{e.ate:.3f}'),
             'Final position [% of path] / final yaw [deg], RMS over seeds',
             _method_table(scenarios, lambda e: f'{e.final:.2f} / {e.yaw:.1f}'),
             'Ours: consistency and slip', _own_table(scenarios), 'Summary',
             _lines(scenarios)]
    return '\n\n'.join(parts) + '\n'


def as_mapping(scenarios: Sequence[ScenarioFigures], setting: dict[str, Any]) -> dict[str, Any]:
    """Everything, for JSON."""
    return {'setting': setting, 'summary': overall(scenarios),
            'scenarios': [dataclasses.asdict(s) for s in scenarios]}


def _method_table(scenarios: Sequence[ScenarioFigures], cell: Callable[[Any], str]) -> str:
    rows = [[_title(s), *(cell(s.errors[m]) for m in METHODS)] for s in scenarios]
    return aligned(['scenario', *METHODS], rows)


def _own_table(scenarios: Sequence[ScenarioFigures]) -> str:
    head = ['scenario', 'seeds', 'path m', 'slip %', 'NEES xy', 'told', 'in 95 % xy', 'NEES v',
            'in 95 % v', 'F1', 'latency ms', 'missed %', 'false/h', 'diagonal']
    rows = [[_title(s), str(s.seeds), f'{s.path:.1f}', f'{100.0 * s.slip_share:.1f}',
             _two(s.nees_position), _two(s.nees_told), _two(s.coverage_position),
             _two(s.nees_velocity), _two(s.coverage_velocity), _three(s.f1),
             '-' if s.latency is None else f'{1000.0 * s.latency:.0f}',
             '-' if s.missed_share is None else f'{100.0 * s.missed_share:.1f}',
             f'{s.false_per_hour:.1f}', _three(s.diagonal)] for s in scenarios]
    return aligned(head, rows)


def _lines(scenarios: Sequence[ScenarioFigures]) -> str:
    found = overall(scenarios)
    if not found['slip_scenarios']:
        return '- no slip scenario among these'
    lines = ['- slip scenarios (marked *): ' + ', '.join(found['slip_scenarios'])]
    for key, text, bar in (
            ('ours_over_oracle_times', 'ours over the oracle told when wheels slip',
             f'; bar: mean <= {BAR_ORACLE}'),
            ('ours_over_oracle', 'ours over the oracle told the slip travel', ''),
            ('rl_over_ours', 'rl-style over ours', f'; bar: least >= {BAR_TWIST}'),
            ('ours_over_wheels_gyro', 'ours over wheels + gyro, all scenarios', '')):
        for title, what in (('', 'RMS'), ('_median', 'median seed')):
            value = found[key + title]
            if value is not None:
                least, most = value['least'], value['most']
                lines.append(f'- {text}, drift ({what}): geometric mean '
                             f'{value["geometric_mean"]:.2f}, least {least[0]:.2f} ({least[1]}), '
                             f'most {most[0]:.2f} ({most[1]}){bar}')
    single = found['worse_than_wheels_gyro']
    named = ', '.join(f'{name} {seed}: {ratio:.2f} times' for ratio, name, seed in single['worse'])
    lines.append(f'- single runs in which ours drifts more than {WORSE:g} times as far as wheels '
                 f'+ gyro, {SLACK:g} % aside: {len(single["worse"])} of {single["runs"]}'
                 + (f' ({named})' if named else ''))
    return '\n'.join(lines)


def aligned(head: Row, rows: Sequence[Row]) -> str:
    """A markdown table with padded columns; the first to the left, others to the right."""
    width = [max(3, *(len(row[i]) for row in (head, *rows))) for i in range(len(head))]

    def line(row: Row) -> str:
        return '| ' + ' | '.join(cell.ljust(width[i]) if i == 0 else cell.rjust(width[i])
                                 for i, cell in enumerate(row)) + ' |'

    rule = '|' + '|'.join(('-' * (w + 2)) if i == 0 else ('-' * (w + 1) + ':')
                          for i, w in enumerate(width)) + '|'
    return '\n'.join([line(head), rule, *map(line, rows)])


def _title(scenario: ScenarioFigures) -> str:
    return scenario.name + (' *' if scenario.slips else '')


def _two(value: float | None) -> str:
    return '-' if value is None else f'{value:.2f}'


def _three(value: float | None) -> str:
    return '-' if value is None else f'{value:.3f}'
