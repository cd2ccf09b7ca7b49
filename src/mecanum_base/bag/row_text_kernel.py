"""Text of whole rows of a track in one compiled loop: the bytes of :mod:`.number_text`.

The same digits by the same arithmetic, one number after the other, straight into the text of the
three files. Without numba this is slower than the columns of :mod:`.number_text` by far.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mecanum_base.core.estimation.acceleration import kernel
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
_LEAST, _MOST = -6, 15  # exponents that are written without one
TUM, TRACK, SLIP = range(3)


@kernel
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


@kernel
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


@kernel
def put_float(text: Bytes, at: int, value: float, high: FloatArray, low: FloatArray) -> int:
    """``value`` at ``at``; the place behind it, or -1 for a size that the table does not reach."""
    if value == 0.0:
        text[at], text[at + 1], text[at + 2] = _ZERO, _POINT, _ZERO
        return at + 3
    size = abs(value)
    if not SMALLEST < size < 1.0 / SMALLEST:
        return -1
    if value < 0.0:
        text[at] = _MINUS
        at += 1
    exponent = math.floor(math.log10(size))
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
def rows_text(stamp_ns: IntArray, track: FloatArray, turn: FloatArray, slip: FloatArray,
              source: Bytes, high: FloatArray, low: FloatArray, tum: Bytes, csv: Bytes,
              slips: Bytes, ends: IntArray) -> int:
    """Rows of the three files into their texts, the ends of them into ``ends`` (3,).

    ``track`` (N, C), ``turn`` (N, 2) quaternion z and w, ``slip`` (N, D), ``source`` (N, B) the
    last word, filled up with NUL. Returns the number of rows, or -1 where a number is none.
    """
    a, b, c = 0, 0, 0
    for row in range(len(stamp_ns)):
        begin = a
        a = put_stamp(tum, a, stamp_ns[row])
        for k in range(begin, a):
            csv[b] = slips[c] = tum[k]
            b += 1
            c += 1
        for column in range(track.shape[1]):
            csv[b] = _COMMA
            place = b + 1
            b = put_float(csv, place, track[row, column], high, low)
            if b < 0:
                return -1
            if column < 2:
                tum[a] = _SPACE
                a += 1
                for k in range(place, b):
                    tum[a] = csv[k]
                    a += 1
        csv[b] = _COMMA
        b += 1
        for k in range(source.shape[1]):
            if source[row, k]:
                csv[b] = source[row, k]
                b += 1
        csv[b] = _LINE
        b += 1
        for _ in range(3):
            tum[a], tum[a + 1], tum[a + 2], tum[a + 3] = _SPACE, _ZERO, _POINT, _ZERO
            a += 4
        for column in range(2):
            tum[a] = _SPACE
            a = put_float(tum, a + 1, turn[row, column], high, low)
            if a < 0:
                return -1
        tum[a] = _LINE
        a += 1
        for column in range(slip.shape[1]):
            slips[c] = _COMMA
            c = put_float(slips, c + 1, slip[row, column], high, low)
            if c < 0:
                return -1
        slips[c] = _LINE
        c += 1
    ends[TUM], ends[TRACK], ends[SLIP] = a, b, c
    return len(stamp_ns)
