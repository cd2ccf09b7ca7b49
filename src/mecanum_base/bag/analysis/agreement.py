"""Do wheels and gyro tell the same yaw: time offset, scale, sign, and how well they agree.

Without a robot file the yaw rate is the best linear combination of the wheel rates (every rolling
base has one); with one it is the third row of the forward matrix. The offset is refined by

    gyro(t + offset) = wheels(t) b + late * d/dt (wheels(t) b)       offset += late, until it is 0

robustly, because slip would pull it, and with errors that last for seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.clusters import LENGTH, clusters
from mecanum_base.bag.analysis.contradiction import agreeing
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.bag.analysis.robust_fit import robust_fit
from mecanum_base.core.parameter import FloatArray, IntArray

GRID = 0.02  # s
REACH = 0.3  # s: offsets tried
_WINDOW = 0.1  # s of smoothing for both: encoders are coarse
_STEP = 0.01  # s
_ROUNDS = 4
_SETTLED = 1e-5  # s


@dataclass(frozen=True, slots=True, eq=False)
class YawAgreement:
    """``offset`` s: the gyro is late by this much; ``offset_sigma`` its standard deviation,
    ``offset_half`` half the width of its interval of 90 %, both infinite where it cannot be told;
    ``scale``: gyro over wheels (1 with right geometry, NaN without a robot file); ``fit``: share
    of the gyro's variance that the wheels explain; ``turned`` rad: how much the robot turned in
    all; ``bias`` rad/s: constant part of the gyro that the wheels do not show."""

    offset: float
    offset_sigma: float
    offset_half: float
    scale: float
    scale_sigma: float
    fit: float
    turned: float
    bias: float


def on_grid(stamp_ns: IntArray, integral: FloatArray, start: float, stop: float,
            origin_ns: int, shift: float = 0.0) -> FloatArray:
    """Mean rates on a grid from an integral (N, ...) sampled at stamps: differences over
    ``_WINDOW``."""
    seconds = (stamp_ns - origin_ns) / 1e9
    grid = np.arange(start, stop, GRID)
    columns = integral.reshape(len(seconds), -1)
    ahead = np.column_stack([np.interp(grid + shift + _WINDOW / 2, seconds, c)
                             for c in columns.T])
    behind = np.column_stack([np.interp(grid + shift - _WINDOW / 2, seconds, c)
                              for c in columns.T])
    found: FloatArray = (ahead - behind) / _WINDOW
    return found


def yaw_integral(gyro: Gyro) -> FloatArray:
    """Integral (N,) of gyro z [rad], trapezoidal, gaps bridged."""
    rate = np.nan_to_num(gyro.rate[:, 2])
    step = np.diff(gyro.stamp_ns) / 1e9
    return np.concatenate(([0.0], np.cumsum(step * (rate[1:] + rate[:-1]) / 2.0)))


def yaw_agreement(motion: WheelMotion, gyro: Gyro, row: FloatArray | None = None,
                  matrix: FloatArray | None = None) -> YawAgreement | None:
    """Compare them; ``row`` (W,) gives the yaw rate from wheel rates. None without turning.

    With ``matrix`` H (W, 3) the offset is told where the wheels agree with each other; the few
    clusters in which one slips would make its interval too wide (Student's t is cautious where
    single clusters carry most of the variance).
    """
    origin = int(motion.stamp_ns[0])
    start = max(0.0, (int(gyro.stamp_ns[0]) - origin) / 1e9) + REACH + _WINDOW
    stop = min(int(motion.stamp_ns[-1]) - origin,
               int(gyro.stamp_ns[-1]) - origin) / 1e9 - REACH - _WINDOW
    if stop - start < 2.0:
        return None
    wheels = on_grid(motion.stamp_ns, motion.angle, start, stop, origin)
    agree = np.ones(len(wheels), dtype=bool) if matrix is None else agreeing(wheels, matrix)
    if row is not None:
        wheels = wheels @ row[:, None]
    integral = yaw_integral(gyro)
    base = np.column_stack([wheels, np.ones(len(wheels))])
    if np.abs(wheels).max() < 1e-6:
        return None
    shifts = np.arange(-REACH, REACH + 1e-9, _STEP)
    left, singular, _ = np.linalg.svd(base, full_matrices=False)
    left = left[:, singular > singular[0] * 1e-9]
    targets = [on_grid(gyro.stamp_ns, integral, start, stop, origin, s)[:, 0] for s in shifts]
    cost = np.array([np.sum((t - left @ (left.T @ t)) ** 2) for t in targets])
    best = int(np.argmin(cost))
    target = targets[best]
    spread = float(np.sum((target - target.mean()) ** 2))
    if spread < 1e-9 or np.sqrt(spread / len(target)) < 0.02:
        return None
    offset, sigma, half = float(shifts[best]), float('inf'), float('inf')
    if 0 < best < len(shifts) - 1:
        offset, sigma, half = _refined(
            lambda at: on_grid(gyro.stamp_ns, integral, start, stop, origin, at)[:, 0],
            left * np.sqrt(len(target)), offset, agree)
    solved = np.linalg.lstsq(base, target, rcond=None)[0]
    rest = float(cost[best])
    scale = scale_sigma = float('nan')
    if row is not None:
        scale = float(solved[0])
        centred = wheels[:, 0] - wheels[:, 0].mean()
        scale_sigma = float(np.sqrt(rest / len(target) * (_WINDOW / GRID)
                                    / max(float(centred @ centred), 1e-12)))
    return YawAgreement(offset, sigma, half, scale, scale_sigma, 1.0 - rest / spread,
                        float(np.sum(np.abs(target - solved[-1])) * GRID), float(solved[-1]))


def _refined(rate_at: Callable[[float], FloatArray], wheels: FloatArray, offset: float,
             agree: Any) -> tuple[float, float, float]:
    """(offset, standard deviation, half width of 90 %) near a first guess; ``rate_at`` gives the
    gyro's rates (K,) at an offset, ``wheels`` (K, P) what they are explained by where they
    ``agree`` (flag each)."""
    plain = wheels @ np.linalg.lstsq(wheels, rate_at(offset), rcond=None)[0]
    length = min(LENGTH, len(wheels) * GRID / (2.0 * wheels.shape[1] + 4.0))
    cluster = clusters(np.abs(plain), GRID, length)
    fit = None
    for _ in range(_ROUNDS):
        rate = rate_at(offset)
        best = wheels @ (fit.value[1:] if fit is not None
                         else np.linalg.lstsq(wheels, rate, rcond=None)[0])
        design = np.column_stack([np.gradient(best, GRID), wheels])
        fit = robust_fit(design[agree], rate[agree], cluster[agree], dense=True)
        if fit is None:
            return offset, float('inf'), float('inf')
        late = float(np.clip(-fit.value[0], -_STEP, _STEP))
        offset += late
        if abs(late) < _SETTLED:
            break
    assert fit is not None
    return offset, float(fit.sigma[0]), fit.half_width(0)
