"""Robust least squares with intervals that hold for errors that last for seconds.

    minimise  sum_k w_k |y_k - X_k b|^2  + sum_j (b_j - b0_j)^2 / s_j^2      (priors s_j)

Weights: Huber's to get near, then Tukey's biweight, so that slip, which always errs to one side,
pulls not at all. The covariance is the jackknife over clusters of neighbouring windows (each left
out in turn), which stays honest with few and unequal clusters, and the interval uses Student's t
with one degree of freedom less than clusters that carry the value. Sources: Huber (1964); Beaton
and Tukey (1974); Bell and McCaffrey (2002).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.parameter import FloatArray, IntArray

_HUBER = 2.0  # robust standard deviations
_TUKEY = 4.685  # 95 % as good as least squares for normal errors
_ROUNDS = 14


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """``value`` (P,), ``covariance`` (P, P), residual ``scale``, and the effective number of
    ``clusters`` (P,) that carry each value."""

    value: FloatArray
    covariance: FloatArray
    clusters: IntArray
    scale: float

    @property
    def sigma(self) -> FloatArray:
        """Standard deviations (P,)."""
        found: FloatArray = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return found

    def half_width(self, index: int, level: float = 0.9) -> float:
        """Half the width of the interval that covers the truth with probability ``level``."""
        return float(self.sigma[index]) * student(level, int(self.clusters[index]) - 1)


def robust_fit(design: FloatArray, target: FloatArray, cluster: IntArray,
               prior: FloatArray | None = None, spread: FloatArray | None = None) -> Fit | None:
    """Fit target (K,) by design (K, P) @ value; ``prior`` (P,) with ``spread`` (P,), inf = none.

    None where fewer clusters than parameters + 2 carry anything.
    """
    count = design.shape[1]
    centre = np.zeros(count) if prior is None else prior
    ridge = np.zeros(count) if spread is None else 1.0 / np.asarray(spread) ** 2
    groups = np.unique(cluster)
    if len(groups) < count + 2 or not np.isfinite(design).all():
        return None
    size = np.abs(design[:, 0])
    live = size > 0.3 * float(np.percentile(size, 95))  # errors grow with the motion: judge there
    if live.sum() < 10:
        live = np.ones(len(target), dtype=bool)
    weight = np.ones(len(target))
    value, scale = centre.copy(), 1.0
    for turn in range(_ROUNDS):
        normal, right = _normal(design, target, weight / scale**2, ridge, centre)
        value = _solved(normal, right)
        rest = np.abs(target - design @ value)
        scale = max(1.4826 * float(np.median(rest[live])), 1e-9)
        if turn < _ROUNDS // 2:
            weight = np.minimum(1.0, _HUBER / np.maximum(rest / scale, 1e-12))
        else:
            weight = np.maximum(0.0, 1.0 - (rest / (_TUKEY * scale)) ** 2) ** 2
    normal, right = _normal(design, target, weight / scale**2, ridge, centre)
    value = _solved(normal, right)
    share = np.array([[(weight[cluster == g] * design[cluster == g, j] ** 2).sum()
                       for g in groups] for j in range(count)])
    covariance: FloatArray = np.zeros((count, count))
    for group in groups:
        own = cluster == group
        part, pull = _normal(design[own], target[own], weight[own] / scale**2, 0.0 * ridge,
                             centre)
        without = _solved(normal - part, right - pull)
        step: FloatArray = without - value
        covariance += np.outer(step, step)
    covariance *= (len(groups) - 1) / len(groups)
    total = np.maximum(share.sum(axis=1), 1e-300)
    carried = np.maximum(2, np.round(total**2 / np.maximum((share**2).sum(axis=1), 1e-300)))
    return Fit(value, covariance, carried.astype(np.int64), scale)


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-12)[0], dtype=np.float64)


def _normal(design: FloatArray, target: FloatArray, weight: FloatArray, ridge: FloatArray,
            centre: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Normal matrix (P, P) and right side (P,) of the weighted problem with its priors."""
    matrix = design.T @ (design * weight[:, None]) + np.diag(ridge)
    return matrix, design.T @ (target * weight) + ridge * centre


def student(level: float, freedom: int) -> float:
    """Two-sided quantile of Student's t (Cornish-Fisher; within 1 % from 3 degrees on)."""
    z = _normal_quantile(0.5 + level / 2.0)
    n = max(freedom, 1)
    return (z + (z**3 + z) / (4.0 * n) + (5 * z**5 + 16 * z**3 + 3 * z) / (96.0 * n**2)
            + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384.0 * n**3))


def _normal_quantile(p: float) -> float:
    """Inverse of the normal distribution by bisection of the error function."""
    low, high = -10.0, 10.0
    for _ in range(80):
        middle = (low + high) / 2.0
        if 0.5 * (1.0 + math.erf(middle / math.sqrt(2.0))) < p:
            low = middle
        else:
            high = middle
    return (low + high) / 2.0
