"""Rolling constraints of the dual-differential platform and what motions they leave.

State q = (x, y, theta_p, theta_1, theta_2, phi_11, phi_12, phi_21, phi_22), D15, D16.

    A(q) q' = 0   (8, 9), rank 6: the lateral row of a carrier stands twice (once a wheel)     D17
    q' = S(q) V   (9, 3), V = platform twist in platform axes: A S = 0                     D19, D20

Mobility: the lateral rows alone (2, 5) leave 5 - 2 = 3 motions of (x, y, theta_p, theta_1,
theta_2), also with e = 0. That count is no proof: with e = 0 two of the three are steering on the
spot. The platform is omnidirectional where the motions left reach all three of its own twists,
which holds exactly if both axle offsets differ from 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.platform.differential import hinges_from_body, wheels_from_body
from mecanum_base.core.platform.hinges import Hinges, along_and_across

RANK_TOLERANCE = 1e-9  # relative singular value that counts as zero


def _body_from_world(yaw: float) -> FloatArray:
    """(3, 3): twist in platform axes from (x', y', theta_p') in the world; D18 transposed."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def lateral_rows(hinges: Hinges, angles: FloatArray, yaw: float = 0.0) -> FloatArray:
    """C1 (C, 3 + C) on (x', y', theta_p', theta_i') [m/s]: no axle slides sideways (D13).

    ``angles`` (C,) rad hinge angles, ``yaw`` rad heading of the platform in the world.
    """
    _, across = along_and_across(hinges, angles)
    count = len(hinges.x)
    rows = np.zeros((count, 3 + count))
    rows[:, :3] = across
    rows[:, 2] += hinges.axle_offset  # D13: ... + (x c + y s + e) w + e theta'
    rows[:, :3] = rows[:, :3] @ _body_from_world(yaw)
    rows[:, 3:] = np.diag(hinges.axle_offset)
    return rows


def constraint_matrix(carriers: Carriers, angles: FloatArray, yaw: float = 0.0) -> FloatArray:
    """A (8, 9) with A q' = 0: rows lateral and rolling for left_0, right_0, left_1, right_1 (D17).

    ``angles`` (2,) rad hinge angles, ``yaw`` rad platform heading in the world.
    """
    along, _ = along_and_across(carriers.hinges, angles)
    lateral = lateral_rows(carriers.hinges, angles, yaw)
    matrix = np.zeros((8, 9))
    for i in range(2):
        for j, across in enumerate((carriers.half_track[i], -carriers.half_track[i])):
            wheel = 2 * i + j
            matrix[2 * wheel, :5] = lateral[i]  # D13
            rolling = along[i] - np.array([0.0, 0.0, across])  # D14: hX - y_ij w
            matrix[2 * wheel + 1, :3] = rolling @ _body_from_world(yaw)
            matrix[2 * wheel + 1, 3 + i] = -across  # D14: - y_ij theta'
            matrix[2 * wheel + 1, 5 + wheel] = -carriers.wheel_radius[i]  # D14: - r phi'
    return matrix


def state_from_body(carriers: Carriers, angles: FloatArray, yaw: float = 0.0) -> FloatArray:
    """S (9, 3): q' = S @ twist, twist (3,) in platform axes (D19, D20)."""
    return np.vstack([_body_from_world(yaw).T, hinges_from_body(carriers, angles),  # D18
                      wheels_from_body(carriers, angles)])


def rank(matrix: FloatArray) -> int:
    """Number of singular values above :data:`RANK_TOLERANCE` of the largest."""
    singular = np.linalg.svd(matrix, compute_uv=False)
    return int(np.sum(singular > RANK_TOLERANCE * max(float(singular[0]), 1e-300)))


@dataclass(frozen=True, slots=True)
class PlatformMobility:
    """What the axles leave free.

    ``lateral_rank`` of C1; ``degree`` = 5 - lateral_rank (D17); ``twist_dof`` platform twists
    reachable without steering first; ``omnidirectional`` where that is 3.
    """

    lateral_rank: int
    degree: int
    twist_dof: int
    omnidirectional: bool


def assess(hinges: Hinges, angles: FloatArray) -> PlatformMobility:
    """Degrees of mobility at hinge angles (C,) rad (D17 and the condition it omits)."""
    rows = lateral_rows(hinges, angles)
    _, singular, right = np.linalg.svd(rows)
    lateral = int(np.sum(singular > RANK_TOLERANCE * max(float(singular[0]), 1e-300)))
    kernel = right[lateral:]  # orthonormal motions of (twist, hinge rates) the axles allow
    dof = int(np.sum(np.linalg.svd(kernel[:, :3], compute_uv=False) > RANK_TOLERANCE))
    return PlatformMobility(lateral, rows.shape[1] - lateral, dof, dof == 3)
