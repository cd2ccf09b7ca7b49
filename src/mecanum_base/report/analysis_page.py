"""The HTML page of `mecanum analyze`: findings first, then tables and plots, bag by bag."""

from __future__ import annotations

import html
import math
import pathlib
from collections.abc import Sequence
from typing import Any

import plotly.graph_objects as go

from mecanum_base.report.comparison_sections import comparison_sections
from mecanum_base.report.page import Card, Section, Table, write_page

# distinguishable in light and dark and for colour-blind readers (Okabe and Ito)
COLOURS = ('#0072b2', '#e69f00', '#009e73', '#cc79a7', '#d55e00', '#56b4e9', '#8a8a8a')
_TRUTH = '#8a8a8a'


def write_report(path: pathlib.Path, results: Sequence[dict[str, Any]], title: str) -> None:
    """Write one page over all results of ``analyze``."""
    total = {s: sum(r['counts'][s] for r in results) for s in ('blocker', 'warning', 'note')}
    facts = {'recordings': str(len(results)), 'blockers': str(total['blocker']),
             'warnings': str(total['warning']), 'notes': str(total['note'])}
    sections: list[Section] = []
    if len(results) > 1:
        sections.append(Section('All recordings', table=_overview(results)))
    sections += comparison_sections([r['comparison'] for r in results if 'comparison' in r])
    for result in results:
        sections += _sections(result, prefix=f'{result["name"]}: ' if len(results) > 1 else '')
    robots = sorted({pathlib.PurePath(r['robot_file']).name for r in results if r['robot_file']})
    lead = f'mecanum analyze {results[0]["version"]}' if results else 'mecanum analyze'
    lead += (f'; robot file {", ".join(robots)}' if robots
             else '; no robot file: data findings only')
    write_page(path, title, lead, sections, facts)


def _overview(results: Sequence[dict[str, Any]]) -> Table:
    rows = []
    for result in results:
        drift = {d['name']: d for d in result['drift']}
        rows.append([result['name'], _number(result['duration'], 1),
                     *(str(result['counts'][s]) for s in ('blocker', 'warning', 'note')),
                     *(_number(drift[name]['ate'], 3) if name in drift else '-'
                       for name in ('wheels only', 'estimator'))])
    return Table(['recording', 'seconds', 'blockers', 'warnings', 'notes', 'ATE wheels [m]',
                  'ATE estimator [m]'], rows)


def _sections(result: dict[str, Any], prefix: str) -> list[Section]:
    cards = [Card(f['severity'], f['title'], _span(f), [f['evidence'], f'What to do: '
             f'{f["advice"]}.'] if f['advice'] != 'nothing to do' else [f['evidence']])
             for f in result['findings']]
    sections = [Section(f'{prefix}Findings', cards=cards,
                        text=() if cards else ('Nothing was found.',))]
    if result['drift']:
        sections.append(Section(f'{prefix}Drift against the truth', _drift_text(result),
                                _drift_table(result)))
    plots = result['plots']
    for key, name, make in _PLOTS:
        if plots.get(key):
            sections.append(Section(f'{prefix}{name}', figure=make(plots[key])))
    if result['topics']:
        sections.append(Section(f'{prefix}Topics', table=_topics(result)))
    return sections


def _span(finding: dict[str, Any]) -> str:
    parts = [finding['topic']] if finding['topic'] else []
    spans = finding['spans']
    if spans:
        first = (f'{spans[0][0]:.2f} s' if spans[0][0] == spans[0][1]
                 else f'{spans[0][0]:.2f} to {spans[0][1]:.2f} s')
        parts.append(first if len(spans) == 1 else f'{first} and {len(spans) - 1} more')
    return ', '.join(parts)


def _drift_text(result: dict[str, Any]) -> list[str]:
    alignment = result['drift'][0]['alignment']
    how = ('Both start poses are put on each other; nothing else is fitted.'
           if alignment == 'start' else
           'The truth has no heading: it is turned and shifted for the least error.')
    return [how + ' ATE is the root mean square of the position error; "best" after the best '
            'rotation and shift. RPE is the error over stretches of equal travelled distance.']


def _drift_table(result: dict[str, Any]) -> Table:
    lengths = sorted({length for d in result['drift'] for length in d['rpe']}, key=float)
    rows = []
    for drift in result['drift']:
        yaw = drift['yaw_final']
        rows.append([drift['name'], _number(drift['path'], 1), _number(drift['ate'], 3),
                     _number(drift['ate_best'], 3), _number(drift['final'], 3),
                     _number(100 * drift['final_share'], 1),
                     '-' if yaw is None else f'{math.degrees(yaw):+.1f}',
                     *(_number(100 * drift['rpe'][n]['share'], 1) if n in drift['rpe'] else '-'
                       for n in lengths)])
    return Table(['track', 'path [m]', 'ATE [m]', 'best [m]', 'final [m]', 'final [%]',
                  'final yaw [deg]', *(f'RPE {n} m [%]' for n in lengths)], rows)


def _topics(result: dict[str, Any]) -> Table:
    rows = [[t['topic'], t['type'], str(t['count']), _number(t['rate'], 1),
             _number(t['jitter'] and 1e3 * t['jitter'], 2),
             _number(t['largest_gap'] and 1e3 * t['largest_gap'], 0),
             _number(t['delay'] and 1e3 * t['delay'], 1), str(t['rejected'])]
            for t in result['topics']]
    return Table(['topic', 'type', 'messages', 'rate [Hz]', 'jitter [ms]', 'largest gap [ms]',
                  'delay [ms]', 'unreadable'], rows)


def _number(value: float | None, digits: int) -> str:
    return '-' if value is None else f'{value:.{digits}f}'


def _figure(x: str, y: str, height: int = 340) -> go.Figure:
    figure = go.Figure()
    figure.update_layout(height=height, xaxis_title=x, yaxis_title=y, colorway=list(COLOURS))
    return figure


def _line(figure: go.Figure, name: str, data: dict[str, list[float]], index: int,
          **options: Any) -> None:
    line = dict(width=1.6, color=_TRUTH if name == 'truth' else COLOURS[index % len(COLOURS)],
                dash='dot' if name == 'truth' else 'solid')
    figure.add_trace(go.Scatter(x=data['x'], y=data['y'], name=html.escape(name), mode='lines',
                                line=line, **options))


def _paths(data: dict[str, Any]) -> go.Figure:
    figure = _figure('x [m]', 'y [m]', 460)
    for index, (name, columns) in enumerate(data.items()):
        _line(figure, name, columns, index)
    figure.update_yaxes(scaleanchor='x', scaleratio=1)
    return figure


def _over_time(label: str, limits: tuple[float, float] | None = None) -> Any:
    def make(data: dict[str, Any]) -> go.Figure:
        figure = _figure('time [s]', label)
        for index, (name, columns) in enumerate(data.items()):
            _line(figure, name, columns, index)
        figure.update_layout(showlegend=True)
        if limits is not None:
            figure.update_yaxes(range=limits)
        return figure
    return make


def _spread(data: dict[str, Any]) -> go.Figure:
    figure = _figure('time [s]', 'standard deviation')
    for index, (name, label) in enumerate((('position', 'position [m]'), ('yaw', 'yaw [deg]'))):
        _line(figure, label, {'x': data['x'], 'y': data[name]}, index)
    return figure


_PLOTS = (
    ('paths', 'Tracks', _paths),
    ('errors', 'Position error', _over_time('error [m]')),
    ('slip', 'Slip probability', _over_time('probability', (0.0, 1.0))),
    ('sigma', 'Stated uncertainty of the estimator', _spread),
    ('wheels', 'Wheel rates', _over_time('rate [rad/s]')),
    ('yaw', 'Yaw of gyro and wheels', _over_time('yaw [deg]')),
    ('periods', 'Encoder period', _over_time('period [ms]')),
)
