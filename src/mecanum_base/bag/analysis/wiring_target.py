"""How well wheels explain a signal, from second moments alone.

    cost = n/2 log((mse + floor) / (best mse + floor))

n counts independent stretches, best is that of any linear combination of the wheels, floor stands
for what no model of the wheels explains.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.bag.analysis.wiring_signals import GRID
from mecanum_base.core.parameter import FloatArray

STRETCH, MOST = 0.4, 60  # s of a stretch, most stretches
MISFIT = 0.05  # of the signal


class Target:
    """A signal that the wheels should explain; only second moments of the columns are kept.

    ``free`` (K, W) are the columns of which every model is a linear combination, ``real`` (K,).
    """

    def __init__(self, free: FloatArray, real: FloatArray) -> None:
        rows = max(len(real), 1)
        self._square = free.T @ free / rows
        self._cross = free.T @ real / rows
        self.spread = float(real @ real) / rows
        solved = np.linalg.lstsq(self._square, self._cross, rcond=1e-9)[0]
        self._best = max(self.spread - float(self._cross @ solved), 0.0)
        self._count = min(MOST, rows * GRID / STRETCH) if rows * GRID > 1.0 else 0.0

    def cost(self, weights: FloatArray) -> float:
        """Cost of the model free @ weights."""
        power = float(weights @ self._square @ weights)
        mse = max(self.spread - 2.0 * float(weights @ self._cross) + power, 0.0)
        floor = MISFIT**2 * max(self.spread, power) + 1e-12
        return 0.5 * self._count * max(0.0, math.log((mse + floor) / (self._best + floor)))

    def scale(self, weights: FloatArray) -> float:
        """The factor that fits free @ weights best; 1 where there is nothing to fit."""
        product, power = self.products(weights)
        return product / power if power > 1e-12 else 1.0

    def products(self, weights: FloatArray) -> tuple[float, float]:
        """Mean of (free @ weights) * real and of (free @ weights)^2."""
        return float(weights @ self._cross), float(weights @ self._square @ weights)
