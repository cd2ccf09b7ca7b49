"""Where wheels contradict each other more than usual: one of them slips."""

from __future__ import annotations

from typing import Any

import numpy as np

from mecanum_base.core.kinematics.solve import parity_basis
from mecanum_base.core.parameter import FloatArray

_CONTRADICT = 4.0  # times the usual contradiction
_LIVE = 0.3  # of the liveliest motion


def agreeing(wheel: FloatArray, matrix: FloatArray) -> Any:
    """Flag (K,): the wheels do not contradict each other more than usual; ``wheel`` (K, W) angles
    turned or rates, ``matrix`` H (W, 3).

    All rows with three wheels, which cannot contradict each other.
    """
    rest = wheel @ parity_basis(matrix).T
    if not rest.shape[1]:
        return np.ones(len(wheel), dtype=bool)
    size = np.linalg.norm(rest, axis=1)
    turned = np.linalg.norm(wheel, axis=1)
    live = turned > _LIVE * float(np.percentile(turned, 95))
    if live.sum() < 10:
        return np.ones(len(wheel), dtype=bool)
    usual = float(np.median(size[live] / turned[live]))
    return size < _CONTRADICT * usual * np.maximum(turned, float(np.median(turned[live])))
