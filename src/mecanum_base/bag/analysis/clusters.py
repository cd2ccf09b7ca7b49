"""Stretches of dependent errors: cut where the base moves least.

Start and end of one movement share the creep of the wheels, and the noise of a pose between them
counts once with each sign: both belong into one stretch.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.parameter import FloatArray, IntArray

LENGTH = 4.0  # s: slip and creep last that long
_REACH = 0.4  # of it: how far a cut may be from its place


def clusters(speed: FloatArray, step: float, length: float = LENGTH) -> IntArray:
    """Number (K,) of the stretch that each instant or window belongs to; ``speed`` (K,) is that of
    the base where it begins, every ``step`` s."""
    size = max(round(length / step), 2)
    reach = max(round(_REACH * size), 1)
    number = np.zeros(len(speed), dtype=np.int64)
    for middle in range(size, len(speed) - reach + 1, size):
        first = middle - reach
        number[first + int(np.argmin(speed[first:middle + reach])):] += 1
    return number
