"""What differs between two results of `mecanum analyze`, as sections of its page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mecanum_base.bag.analysis.comparison import listed, number, over_all, table_of
from mecanum_base.report.page import Section, Table


def comparison_sections(comparisons: Sequence[dict[str, Any]]) -> list[Section]:
    """Constants once, then figures over all recordings and pair by pair."""
    found: list[Section] = []
    constants = comparisons[0]['constants'] if comparisons else []
    if constants:
        found.append(Section('Constants that differ', table=Table(
            ['parameter', 'first', 'second', 'change'],
            [[_named(row['key'], row['unit']), listed(row['first']), listed(row['second']),
              row['change'] or '-'] for row in constants])))
    if len(comparisons) > 1:
        rows = over_all(comparisons)
        found.append(Section(
            f'Comparison over {len(comparisons)} recordings', ['Means over the recordings.'],
            Table(['figure', 'recordings', 'first', 'second', 'better in', 'worse in'],
                  [[_named(row['figure'], row['unit']), str(row['recordings']),
                    number(row['first']), number(row['second']), str(row['better']),
                    str(row['worse'])] for row in rows],
                  [_tone(row) for row in rows])))
    return found + [section for c in comparisons for section in _pair(c)]


def _pair(comparison: dict[str, Any]) -> list[Section]:
    rows = table_of(comparison)
    text = [f'First: {comparison["first"]}. Second: {comparison["second"]}. '
            'Figures that change by less than 1 % are left out.']
    for word, title in (('gone', 'No longer found'), ('new', 'Found only in the second')):
        if comparison[word]:
            text.append(f'{title}: ' + '; '.join(
                f'{f["severity"]}: {f["title"]}' for f in comparison[word]) + '.')
    table = Table(['figure', 'first', 'second', 'change'],
                  [[*row[:3], ' '.join(cell for cell in row[3:] if cell != '-') or '-']
                   for row in rows],
                  [row[-1] if row[-1] in ('better', 'worse') else '' for row in rows])
    return [Section('Comparison', text, table if rows else None)]


def _named(name: str, unit: str) -> str:
    return f'{name} [{unit}]' if unit else name


def _tone(row: dict[str, Any]) -> str:
    if row['better'] == row['worse']:
        return ''
    return 'better' if row['better'] > row['worse'] else 'worse'
