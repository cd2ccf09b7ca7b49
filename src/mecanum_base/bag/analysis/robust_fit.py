"""Robust least squares with intervals that hold for errors that last for seconds.

    minimise  sum_k rho(y_k - X_k b)  + sum_j (b_j - b0_j)^2 / s_j^2      (priors s_j)

rho is Huber's to get near, then Tukey's biweight, so that slip, which always errs to one side,
pulls not at all. The covariance is the sandwich of the estimating equation sum psi x = 0,

    V = C^-1 (sum_g u_g u_g^T + ridge) C^-1      u_g = X_g^T (I - H_gg)^-1/2 psi_g
    C = sum psi' x x^T + ridge                   H_gg = X_g (sum psi / r x x^T + ridge)^-1 X_g^T

over clusters g of neighbouring windows: errors within one may depend on each other, and the factor
with H takes off the bias of few and unequal clusters. psi' is less than psi / r, because other
errors would also change the weights. Of dense rows, much closer than their errors last, only the
slope along the first value and those square to it are taken from C: what C has across is chance
then, and the inverse of a random matrix is too large (30 % in the variance of a time offset). The
interval uses Student's t with the degrees of freedom that this variance would have if all errors
were alike. Sources: Huber (1964); Beaton and Tukey (1974); Bell and McCaffrey (2002); Imbens and
Kolesar (2016).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.parameter import FloatArray, IntArray

_HUBER = 2.0  # robust standard deviations
_TUKEY = 4.685  # 95 % as good as least squares for normal errors
_ROUNDS = 14
_LEAST_CURVE = 0.4  # of sum psi' x x^T over sum psi / r x x^T; 0.83 for normal errors
_MOST = 1.0 - 1e-6  # of the information in one cluster


@dataclass(frozen=True, slots=True, eq=False)
class Sandwich:
    """``covariance`` (P, P) of the values; what each cluster contributes to a variance and to the
    fit, ``spread`` and ``pull`` (G, P, P), in coordinates that ``back`` (P, P) turns into values.
    """

    covariance: FloatArray
    spread: FloatArray
    pull: FloatArray
    back: FloatArray

    def freedom(self, direction: FloatArray) -> float:
        """Degrees of freedom of the variance of a linear combination (P,) of the values."""
        along = self.back.T @ direction
        own = np.einsum('gij,i,j->g', self.spread, along, along)
        pull = self.pull @ along
        form = np.diag(own) - pull @ pull.T
        return max(float(np.trace(form)) ** 2 / max(float(np.sum(form**2)), 1e-300), 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """``value`` (P,), residual ``scale``, the effective number of ``clusters`` (P,) that carry
    each value, and how sure it is."""

    value: FloatArray
    clusters: IntArray
    scale: float
    sandwich: Sandwich

    @property
    def sigma(self) -> FloatArray:
        """Standard deviations (P,)."""
        found: FloatArray = np.sqrt(np.maximum(np.diag(self.sandwich.covariance), 0.0))
        return found

    def half_width(self, index: int, level: float = 0.9) -> float:
        """Half the width of the interval that covers the truth with probability ``level``."""
        return self.half_width_along(np.eye(len(self.value))[index], level)

    def half_width_along(self, direction: FloatArray, level: float = 0.9) -> float:
        """The same for a linear combination (P,) of the values."""
        variance = float(direction @ self.sandwich.covariance @ direction)
        freedom = self.sandwich.freedom(direction)
        return math.sqrt(max(variance, 0.0)) * student(level, freedom)


def robust_fit(design: FloatArray, target: FloatArray, cluster: IntArray,
               prior: FloatArray | None = None, spread: FloatArray | None = None,
               dense: bool = False) -> Fit | None:
    """Fit target (K,) by design (K, P) @ value; ``prior`` (P,) with ``spread`` (P,), inf = none;
    ``dense``: rows are much closer than their errors last, and the first value is what counts.

    None where fewer clusters than parameters + 2 carry anything.
    """
    count = design.shape[1]
    centre = np.zeros(count) if prior is None else prior
    ridge = np.zeros(count) if spread is None else 1.0 / np.asarray(spread) ** 2
    groups, group = np.unique(cluster, return_inverse=True)
    if len(groups) < count + 2 or not np.isfinite(design).all():
        return None
    size = np.abs(design[:, 0])
    live = size > 0.3 * float(np.percentile(size, 95))  # errors grow with the motion: judge there
    if live.sum() < 10:
        live = np.ones(len(target), dtype=bool)
    weight = np.ones(len(target))
    value, scale = centre.copy(), 1.0
    for turn in range(_ROUNDS):
        value = _solved(design, target, weight / scale**2, ridge, centre)
        rest = np.abs(target - design @ value)
        scale = max(1.4826 * float(np.median(rest[live])), 1e-9)
        if turn < _ROUNDS // 2:
            weight = np.minimum(1.0, _HUBER / np.maximum(rest / scale, 1e-12))
        else:
            weight = np.maximum(0.0, 1.0 - (rest / (_TUKEY * scale)) ** 2) ** 2
    value = _solved(design, target, weight / scale**2, ridge, centre)
    share = np.zeros((len(groups), count))
    np.add.at(share, group, weight[:, None] * design**2)
    total = np.maximum(share.sum(axis=0), 1e-300)
    carried = np.maximum(2, np.round(total**2 / np.maximum((share**2).sum(axis=0), 1e-300)))
    rest = (target - design @ value) / scale
    return Fit(value, carried.astype(np.int64), scale,
               _sandwich(design, rest, weight, scale, group, ridge, dense))


def _solved(design: FloatArray, target: FloatArray, weight: FloatArray, ridge: FloatArray,
            centre: FloatArray) -> FloatArray:
    """Weighted least squares with priors."""
    matrix = design.T @ (design * weight[:, None]) + np.diag(ridge)
    right = design.T @ (target * weight) + ridge * centre
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-12)[0], dtype=np.float64)


def _sandwich(design: FloatArray, rest: FloatArray, weight: FloatArray, scale: float,
              group: IntArray, ridge: FloatArray, dense: bool) -> Sandwich:
    """``rest`` (K,) residuals over ``scale``, ``weight`` (K,) psi over these."""
    count = design.shape[1]
    rows = design * (np.sqrt(weight) / scale)[:, None]
    plain = rows.T @ rows + np.diag(ridge)
    white = _whitening(plain)
    seen = rows @ white
    groups = int(group.max()) + 1
    square = np.zeros((groups, count, count))
    np.add.at(square, group, seen[:, :, None] * seen[:, None, :])
    score = np.zeros((groups, count))
    np.add.at(score, group, seen * (rest * np.sqrt(weight))[:, None])
    part, turn = np.linalg.eigh(square)
    part = np.clip(part, 0.0, _MOST)
    flip = np.swapaxes(turn, 1, 2)
    wide = 1.0 / np.sqrt(1.0 - part)
    spread = (turn * (part * wide**2)[:, None, :]) @ flip
    pull = (turn * (part * wide)[:, None, :]) @ flip
    scores = ((turn * wide[:, None, :]) @ flip @ score[:, :, None])[:, :, 0]
    inner = 1.0 - (rest / _TUKEY) ** 2
    slope = np.where(inner > 0.0, inner * (5.0 * inner - 4.0), 0.0)  # psi'
    curve = white.T @ (design.T @ (design * slope[:, None]) / scale**2 + np.diag(ridge)) @ white
    if dense:
        axes = np.linalg.qr(np.column_stack([white[0], np.eye(count)]))[0]  # first along value 0
        bend = np.diag(axes.T @ curve @ axes)
    else:
        bend, axes = np.linalg.eigh(curve)
    back = white @ (axes / np.clip(bend, _LEAST_CURVE, 1.0)) @ axes.T
    middle = scores.T @ scores + white.T @ np.diag(ridge) @ white
    return Sandwich(back @ middle @ back.T, spread, pull, back)


def _whitening(matrix: FloatArray) -> FloatArray:
    """F (P, P) with F^T M F = 1 for a symmetric M; 0 along what it tells nothing of."""
    size = np.sqrt(np.diag(matrix))
    back = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    own, axes = np.linalg.eigh(matrix * np.outer(back, back))
    root = np.sqrt(np.where(own > 1e-12 * own[-1], own, 0.0))
    found: FloatArray = back[:, None] * axes * np.divide(1.0, root, out=np.zeros_like(root),
                                                         where=root > 0.0)
    return found


def student(level: float, freedom: float) -> float:
    """Two-sided quantile of Student's t (Cornish-Fisher; within 1 % from 3 degrees on)."""
    z = _normal_quantile(0.5 + level / 2.0)
    n = max(float(freedom), 1.0)
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
