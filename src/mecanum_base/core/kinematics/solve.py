"""Wheel rates from a twist, the twist from wheel rates, and what the wheels disagree on.

    inverse   u = H V                                        (G eq. 17, R inverse kinematics)
    forward   V = (H^T W H)^-1 H^T W u                       (G eq. 18 for n wheels, R forward)
    residual  e = u - H V,   projector P = I - H H^+         (parity: P u = 0 proves nothing,
                                                              P u != 0 proves slip)

With W = I the residual is minimised in rad/s (the pseudo-inverse); W = diag((r sin d)^2) weighs
slip along the roller axes in m/s instead. For equal wheels both agree.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

WEIGHTINGS = ('rate', 'slip')
LARGEST = 1.0 - 1e-9  # entries this close to the largest count as equal: the first one wins


def weights(wheels: Wheels, weighting: str = 'rate') -> FloatArray:
    """Least-squares weights (W,): 1 for 'rate' [rad/s], (r sin d)^2 for 'slip' [m/s]."""
    if weighting not in WEIGHTINGS:
        raise ValueError(f'weighting must be one of {WEIGHTINGS}, not {weighting!r}')
    if weighting == 'rate':
        return np.ones(wheels.count)
    lever: FloatArray = (wheels.radius * np.sin(wheels.roller)) ** 2
    return lever


def body_from_wheels(matrix: FloatArray, weight: FloatArray | None = None) -> FloatArray:
    """Forward matrix (3, W) of H (W, 3): twist = body_from_wheels(H) @ rates (G eq. 18)."""
    root = np.ones(matrix.shape[0]) if weight is None else np.sqrt(weight)
    inverse: FloatArray = np.linalg.pinv(root[:, None] * matrix) * root
    return inverse


def parity_projector(matrix: FloatArray) -> FloatArray:
    """P = I - H H^+ (W, W): wheel rates that no rigid motion explains."""
    projector: FloatArray = np.eye(matrix.shape[0]) - matrix @ np.linalg.pinv(matrix)
    return projector


def parity_basis(matrix: FloatArray) -> FloatArray:
    """Orthonormal rows (W - rank, W) that span the parities: basis @ u = 0 without slip."""
    left, singular, _ = np.linalg.svd(matrix)
    rank = int(np.sum(singular > singular[0] * 1e-9))
    basis: FloatArray = left[:, rank:].T
    return basis


def null_vector(matrix: FloatArray) -> FloatArray:
    """n (W,) with n @ H = 0, largest entry +1, for a base with one redundant wheel.

    For the rectangular mecanum base in the order FL, FR, RL, RR it is (1, 1, -1, -1), and n @ u
    is the parity of models.md 1.1. Raises ValueError where H (W, 3) has no or several of them.
    """
    basis = parity_basis(matrix)
    if len(basis) != 1:
        raise ValueError(f'{len(basis)} parities, not one: use parity_basis')
    size = np.abs(basis[0])
    largest = int(np.argmax(size > LARGEST * np.max(size)))
    vector: FloatArray = basis[0] / basis[0][largest]
    return vector
