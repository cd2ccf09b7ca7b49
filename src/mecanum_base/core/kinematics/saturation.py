"""Bring wheel rates below their limits without bending the path of the base.

All rates are scaled by one factor, so the twist keeps its direction in (vx, vy, wz):

    factor = min(1, min_i limit_i / |u_i|)

With ``keep_yaw`` the yaw rate is served first and only the translation is scaled: useful where the
heading matters more than the speed along the path.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.parameter import FloatArray


def scale_to_limits(rates: FloatArray, limits: FloatArray) -> float:
    """The largest factor in [0, 1] that brings every |rate| (W,) to its limit (W,), rad/s."""
    size = np.abs(rates)
    over = size > limits
    if not np.any(over):
        return 1.0
    return float(np.min(limits[over] / size[over]))


def desaturate(matrix: FloatArray, twist: FloatArray, limits: FloatArray,
               keep_yaw: bool = False) -> FloatArray:
    """The twist (3,) nearest to ``twist`` in its own direction that H (W, 3) can serve.

    ``limits`` (W,) rad/s. With ``keep_yaw`` the yaw rate is kept if it alone fits and the
    translation is scaled by the largest factor that still fits; otherwise yaw alone is scaled.
    """
    if not keep_yaw:
        return twist * scale_to_limits(matrix @ twist, limits)
    yaw = np.array([0.0, 0.0, twist[2]])
    yaw = yaw * scale_to_limits(matrix @ yaw, limits)
    push = np.array([twist[0], twist[1], 0.0])
    turning, pushing = matrix @ yaw, matrix @ push
    with np.errstate(divide='ignore', invalid='ignore'):
        room = np.where(pushing > 0.0, (limits - turning) / pushing,
                        np.where(pushing < 0.0, (-limits - turning) / pushing, np.inf))
    factor = min(1.0, max(0.0, float(np.min(room))))
    served: FloatArray = yaw + factor * push
    return served


def fastest(matrix: FloatArray, direction: FloatArray, limits: FloatArray) -> float:
    """Largest factor on the twist ``direction`` (3,) that H (W, 3) serves within limits (W,).

    inf where no wheel that turns has a limit.
    """
    share = np.abs(matrix @ direction) / limits
    largest = float(np.max(share))
    return 1.0 / largest if largest > 0.0 else float('inf')
