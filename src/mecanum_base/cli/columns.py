"""Text columns of equal width for terminal tables."""

from __future__ import annotations

from collections.abc import Sequence


def align(rows: Sequence[Sequence[str]], *, indent: str = '  ') -> list[str]:
    """Lines with every column padded to its widest cell; the last one is not padded."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [indent + '  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip()
            for row in rows]
