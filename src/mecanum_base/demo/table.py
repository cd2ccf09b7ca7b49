"""The table a demo ends with, as text."""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.demo.result import DemoResult, Phase

YAW_LIMIT = 0.5  # deg: largest yaw allowed in a translation-only square without slip


def table(result: DemoResult) -> str:
    """Errors of wheel-only and fused odometry against the truth, and the slip score."""
    rows = [('', 'wheel-only', 'fused'), *error_rows(result)]
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    lines = [f'{result.name}: {result.path_length:.2f} m driven in '
             f'{_seconds(result):.1f} s of simulated time; errors against the truth', '']
    for index, row in enumerate(rows):
        lines.append(f'  {row[0]:<{widths[0]}}  {row[1]:>{widths[1]}}  {row[2]:>{widths[2]}}')
        if index == 0:
            lines.append('  ' + '-' * (sum(widths) + 4))
    return '\n'.join([*lines, '', *_slip(result), *_squares(result)])


def error_rows(result: DemoResult) -> list[tuple[str, str, str]]:
    """(what, wheel-only, fused) as texts with their units, a row each."""
    wheel, fused = result.wheel_only_error, result.fused_error
    rows = []
    for phase in result.phases:
        at = [error.distance[np.searchsorted(error.stamp_ns, phase.end_ns, side='right') - 1]
              for error in (wheel, fused)]
        rows.append((f'position error after {phase.name} [m]', f'{at[0]:.3f}', f'{at[1]:.3f}'))
    return [*rows,
            ('position error, RMS [m]', f'{wheel.rms_distance:.3f}', f'{fused.rms_distance:.3f}'),
            ('yaw error at the end [deg]', f'{math.degrees(wheel.final_yaw):+.2f}',
             f'{math.degrees(fused.final_yaw):+.2f}')]


def _slip(result: DemoResult) -> list[str]:
    score = result.score
    text = f'  slip episodes: {len(score.true)} true, {score.found} found, ' \
           f'{len(score.false)} false'
    if score.delays:
        text += f'; median delay {1000 * float(np.median(score.delays)):.0f} ms'
    sharp = f'  covariance: median of e\'P^-1 e for (x, y) is {result.consistency():.2f} ' \
            '(1.39 is perfect, larger is too sure)'
    return [text, sharp]


def _squares(result: DemoResult) -> list[str]:
    return [_square(result, phase) for phase in result.phases if phase.name == 'square']


def _square(result: DemoResult, phase: Phase) -> str:
    true, fused = (math.degrees(v) for v in result.largest_yaw(phase))
    verdict = 'ok' if max(true, fused) <= YAW_LIMIT else 'TOO LARGE'
    return f'  largest yaw in the translation-only square: truth {true:.2f} deg, ' \
           f'odometry {fused:.2f} deg (at most {YAW_LIMIT:g}): {verdict}'


def _seconds(result: DemoResult) -> float:
    return float(result.truth.stamp_ns[-1] - result.truth.stamp_ns[0]) * 1e-9
