"""Can the platform reach every posture? Lie algebra of its three control fields.

Posture p = (x, y, theta_p, theta_1, theta_2); fields g1, g2, g3 = first five rows of the columns
of S (D19): platform motion along its x, along its y, its yaw, the hinges following. With

    [g_a, g_b] = (D g_b) g_a - (D g_a) g_b

the first brackets raise the rank from 3 to 5 in every posture exactly if the two hinges are
distinct, so every posture, steering angles included, can be reached (rank 5, section 4 of
models.md):

    [g1,g2]      = (0, 0, 0, 1/e1^2,  1/e2^2)
    [g1,g3] + g2 = (0, 0, 0, x1/e1^2, x2/e2^2)
    [g2,g3] - g1 = (0, 0, 0, y1/e1^2, y2/e2^2)

The Jacobians below are exact, not numerical.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform.constraints import rank
from mecanum_base.core.platform.hinges import Hinges, along_and_across


def fields(hinges: Hinges, angles: FloatArray, yaw: float) -> FloatArray:
    """(5, 3): columns g1, g2, g3 at hinge angles (2,) and platform heading ``yaw`` rad (D19)."""
    c, s = np.cos(yaw), np.sin(yaw)
    _, across = along_and_across(hinges, angles)
    steering = -across / hinges.axle_offset[:, None]
    steering[:, 2] -= 1.0
    return np.vstack([[[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], steering])


def _jacobians(hinges: Hinges, angles: FloatArray, yaw: float) -> FloatArray:
    """(3, 5, 5): derivative of each field by the posture."""
    c, s = np.cos(yaw), np.sin(yaw)
    along, _ = along_and_across(hinges, angles)
    slope = np.zeros((3, 5, 5))
    slope[0, :2, 2] = (-s, c)
    slope[1, :2, 2] = (-c, -s)
    for i in range(2):  # d(across)/d(theta_i) = -along
        slope[:, 3 + i, 3 + i] = along[i] / hinges.axle_offset[i]
    return slope


def bracket(hinges: Hinges, angles: FloatArray, yaw: float, first: int, second: int) -> FloatArray:
    """(5,): [g_first, g_second], indices 0..2."""
    g = fields(hinges, angles, yaw)
    slope = _jacobians(hinges, angles, yaw)
    result: FloatArray = slope[second] @ g[:, first] - slope[first] @ g[:, second]
    return result


def reachable_rank(hinges: Hinges, angles: FloatArray, yaw: float = 0.0) -> tuple[int, int]:
    """(rank of the fields, rank with their first brackets); (3, 5) where all is reachable."""
    g = fields(hinges, angles, yaw)
    brackets = [bracket(hinges, angles, yaw, a, b) for a, b in ((0, 1), (0, 2), (1, 2))]
    return rank(g), rank(np.column_stack([g, *brackets]))
