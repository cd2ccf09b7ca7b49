"""Comparisons of `mecanum analyze` as lines for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from mecanum_base.bag.analysis.comparison import listed, number, over_all, table_of
from mecanum_base.cli.columns import align

_SHOWN = 3  # recordings whose own table is printed; the files hold all


def comparison_lines(comparisons: Sequence[dict[str, Any]]) -> Iterator[str]:
    """Tables of constants, figures and findings that differ."""
    yield from _constants(comparisons[0]['constants'])
    for comparison in comparisons[:_SHOWN]:
        yield f'{comparison["first"]}  against  {comparison["second"]}:'
        rows = table_of(comparison)
        if rows:
            yield from align([['figure', 'first', 'second', 'change', ''], *rows])
        else:
            yield '  no figure differs by more than 1 %'
        for word, title in (('gone', 'no longer found'), ('new', 'found only in the second')):
            for finding in comparison[word]:
                yield f'  {title}: {finding["severity"]}: {finding["title"]}'
    if len(comparisons) > 1:
        yield f'over all {len(comparisons)} (means):'
        yield from align([
            ['figure', 'recordings', 'first', 'second', 'better in', 'worse in'],
            *([row['figure'] + (f' [{row["unit"]}]' if row['unit'] else ''),
               str(row['recordings']), number(row['first']), number(row['second']),
               str(row['better']), str(row['worse'])] for row in over_all(comparisons))])


def _constants(rows: Sequence[dict[str, Any]]) -> Iterator[str]:
    if rows:
        yield 'constants that differ:'
        yield from align([['parameter', 'first', 'second', 'change'],
                          *([row['key'] + (f' [{row["unit"]}]' if row['unit'] else ''),
                             listed(row['first']), listed(row['second']), row['change'] or '-']
                            for row in rows)])
