"""Text of whole rows of a track in one compiled loop: the bytes of :mod:`.number_text`.

The same digits by the same arithmetic, one number after the other, straight into the text of the
three files. Without numba this is slower than the columns of :mod:`.number_text` by far.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.parameter import FloatArray, IntArray

Bytes = NDArray[np.uint8]

DIGITS = 17
TABLE_REACH = 240  # largest power of ten in the table, see number_text.powers
SMALLEST = 1e-200  # numbers below it and above its reciprocal are left to Python
_SPLIT = 134217729.0  # 2**27 + 1, Dekker's constant
_FRACTION = -(-(1 << 57) // 10**8)
_BELOW = (1 << 57) - 1
_LOW, _HIGH = 10 ** (DIGITS - 1), 10**DIGITS
_ZERO, _POINT, _MINUS, _PLUS, _E = (ord(c) for c in '0.-+e')
_COMMA, _SPACE, _LINE = (ord(c) for c in ', \n')
_LOG_2 = math.log10(2.0)
_LEAST, _MOST = -6, 15  # exponents that are written without one
TUM, TRACK, SLIP = range(3)


@part
def scaled(size: float, high: float, low: float) -> int:
    """The whole number nearest to ``size`` * (``high`` + ``low``); Dekker's product."""
    product = size * high
    a = size * _SPLIT
    a_high = a - (a - size)
    a_low = size - a_high
    b = high * _SPLIT
    b_high = b - (b - high)
    b_low = high - b_high
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return int(product) + int(np.rint(error + size * low))


@kernel
def put_whole(text: Bytes, at: int, number: int, places: int) -> int:
    """``number`` with leading zeros in ``places`` digits at ``at``; the place behind it."""
    rest = number
    for k in range(at + places - 1, at - 1, -1):
        higher = rest // 10
        text[k] = _ZERO + rest - 10 * higher
        rest = higher
    return at + places


@part
def put_digits(text: Bytes, at: int, digits: int) -> int:
    """The 17 digits of ``digits`` at ``at``; the place behind them.

    Two halves side by side; each is a fraction of 2**57, of which ten times is taken again and
    again. It is rounded up by 1.7e-10 at most, which is less than the last of its digits.
    """
    first = digits // 10**16
    rest = digits - first * 10**16
    left = rest // 10**8
    right = (rest - left * 10**8) * _FRACTION
    left *= _FRACTION
    text[at] = _ZERO + first
    for k in range(at + 1, at + 9):
        left *= 10
        right *= 10
        text[k] = _ZERO + (left >> 57)
        text[k + 8] = _ZERO + (right >> 57)
        left &= _BELOW
        right &= _BELOW
    return at + DIGITS


@part
def put_float(text: Bytes, at: int, value: float, bits: int, high: FloatArray,
              low: FloatArray) -> int:
    """``value`` at ``at``; the place behind it, or -1 for a size that the table does not reach.

    ``bits`` are those of the number: they tell its power of two.
    """
    size = abs(value)
    if size == 0.0:
        text[at] = _ZERO
        text[at + 1] = _POINT
        text[at + 2] = _ZERO
        return at + 3
    if not SMALLEST < size < 1.0 / SMALLEST:
        return -1
    if bits < 0:
        text[at] = _MINUS
        at += 1
    exponent = math.floor((((bits >> 52) & 2047) - 1023) * _LOG_2)
    if size >= high[TABLE_REACH + exponent + 1]:
        exponent += 1
    middle = TABLE_REACH + DIGITS - 1
    digits = scaled(size, high[middle - exponent], low[middle - exponent])
    if digits >= _HIGH or digits < _LOW:
        exponent += 1 if digits >= _HIGH else -1
        digits = scaled(size, high[middle - exponent], low[middle - exponent])
    if digits >= _HIGH:  # rounded up to the next power of ten
        digits = _LOW
        exponent += 1
    if _LEAST <= exponent < 0:
        text[at] = _ZERO
        text[at + 1] = _POINT
        for k in range(at + 2, at + 1 - exponent):
            text[k] = _ZERO
        end = put_digits(text, at + 1 - exponent, digits)
        while text[end - 1] == _ZERO:
            end -= 1
        return end
    whole = 1 + exponent if 0 <= exponent <= _MOST else 1
    end = put_digits(text, at + 1, digits)
    for k in range(at, at + whole):
        text[k] = text[k + 1]
    text[at + whole] = _POINT
    while text[end - 1] == _ZERO and end > at + whole + 2:
        end -= 1
    if _LEAST <= exponent <= _MOST:
        return end
    text[end] = _E
    text[end + 1] = _MINUS if exponent < 0 else _PLUS
    return put_whole(text, end + 2, abs(exponent), 3 if abs(exponent) > 99 else 2)


@kernel
def put_stamp(text: Bytes, at: int, stamp_ns: int) -> int:
    """Seconds with nine decimals at ``at``; the place behind it."""
    if stamp_ns < 0:
        text[at] = _MINUS
        at += 1
    size = abs(stamp_ns)
    seconds = size // 10**9
    places, above = 1, 10
    while seconds >= above:
        places, above = places + 1, 10 * above
    at = put_whole(text, at, seconds, places)
    text[at] = _POINT
    return put_whole(text, at + 1, size - 10**9 * seconds, 9)


@kernel
def rows_text(stamp_ns: IntArray, value: FloatArray, bits: IntArray, goal: IntArray,
              source: Bytes, high: FloatArray, low: FloatArray, text: Bytes,
              ends: IntArray) -> int:
    """Rows of the three files, each in its part of ``text``, from and to ``ends`` (3,).

    ``value`` (N, V) numbers of a row and their ``bits``, each for the file ``goal`` (V,): first
    those of track.csv, then those of odometry.tum (quaternion z and w), then those of slip.csv;
    x and y go to odometry.tum as well. ``source`` (N, B) is the last word in track.csv, filled up
    with NUL. Returns the number of rows, or -1 where a number is none.
    """
    for row in range(len(stamp_ns)):
        begin = ends[TUM]
        ends[TUM] = put_stamp(text, begin, stamp_ns[row])
        for k in range(begin, ends[TUM]):
            for file in (TRACK, SLIP):
                text[ends[file]] = text[k]
                ends[file] += 1
        for column in range(value.shape[1]):
            file = goal[column]
            begin = ends[file]
            text[begin] = _SPACE if file == TUM else _COMMA
            end = put_float(text, begin + 1, value[row, column], bits[row, column], high, low)
            if end < 0:
                return -1
            ends[file] = end
            if column > 1:
                continue
            at = ends[TUM]
            text[at] = _SPACE
            for k in range(begin + 1, end):
                at += 1
                text[at] = text[k]
            at += 1
            if column == 1:
                for _ in range(3):
                    text[at] = _SPACE
                    text[at + 1] = _ZERO
                    text[at + 2] = _POINT
                    text[at + 3] = _ZERO
                    at += 4
            ends[TUM] = at
        at = ends[TRACK]
        text[at] = _COMMA
        at += 1
        for k in range(source.shape[1]):
            if source[row, k]:
                text[at] = source[row, k]
                at += 1
        ends[TRACK] = at
        for file in (TUM, TRACK, SLIP):
            text[ends[file]] = _LINE
            ends[file] += 1
    return len(stamp_ns)
