"""Rows of a track as the text of its three files: by columns, or compiled; the same bytes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mecanum_base.bag.number_text import (
    FLOAT_WIDTH,
    STAMP_WIDTH,
    float_text,
    powers,
    squeezed,
    stamp_text,
)
from mecanum_base.bag.row_text_kernel import SLIP, TRACK, TUM, Bytes, rows_text
from mecanum_base.core.parameter import FloatArray, IntArray


def texts_by_columns(stamp_ns: IntArray, track: FloatArray, turn: FloatArray, slip: FloatArray,
                     source: Bytes) -> tuple[bytes, bytes, bytes]:
    """Texts of odometry.tum, track.csv and slip.csv, for any numbers.

    ``stamp_ns`` (N,), ``track`` (N, C) columns between stamp and source, ``turn`` (N, 2)
    quaternion z and w, ``slip`` (N, D), ``source`` (N, B) the last word, filled up with NUL.
    """
    stamp, cells, turned = stamp_text(stamp_ns), _texts(track), _texts(turn)
    zero = np.broadcast_to(np.frombuffer(b'0.0', dtype=np.uint8), (len(stamp_ns), 3))
    return (_joined([stamp, cells[0], cells[1], zero, zero, zero, *turned], ' '),
            _joined([stamp, *cells, source], ','), _joined([stamp, *_texts(slip)], ','))


def _texts(values: FloatArray) -> list[Bytes]:
    """Text of each column of (N, C)."""
    text = float_text(np.ascontiguousarray(values.T).reshape(-1))
    rows, columns = values.shape
    return list(text.reshape(columns, rows, text.shape[1]))


def _joined(cells: Sequence[Bytes], separator: str) -> bytes:
    rows = len(cells[0])
    width = sum(cell.shape[1] + 1 for cell in cells)
    text: Bytes = np.zeros((rows, width), dtype=np.uint8)
    at = 0
    for cell in cells:
        text[:, at:at + cell.shape[1]] = cell
        at += cell.shape[1] + 1
        text[:, at - 1] = ord(separator)
    text[:, -1] = ord('\n')
    return squeezed(text)


def texts_of(stamp_ns: IntArray, track: FloatArray, turn: FloatArray, slip: FloatArray,
             source: Bytes) -> tuple[Bytes, Bytes, Bytes] | None:
    """The same as :func:`texts_by_columns`; None where a number is none or of no usual size."""
    value = np.concatenate([track, turn, slip], axis=1)
    goal = np.repeat([TRACK, TUM, SLIP], [track.shape[1], turn.shape[1], slip.shape[1]])
    widths = np.array([6, track.shape[1], slip.shape[1]]) * (FLOAT_WIDTH + 1)
    sizes = len(value) * (widths + STAMP_WIDTH + source.shape[1] + 2)
    text = np.empty(sizes.sum(), dtype=np.uint8)
    begins = np.cumsum(sizes) - sizes
    ends = begins.copy()
    high, low = powers()
    done = rows_text(stamp_ns, value, value.view(np.int64), goal, source, high, low, text, ends)
    if done < 0:
        return None
    tum, csv, slips = (text[begin:end] for begin, end in zip(begins, ends))
    return tum, csv, slips
