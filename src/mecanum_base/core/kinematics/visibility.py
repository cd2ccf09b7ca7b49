"""What slip can encoders see, alone and with a gyro, and which wheel can they blame?

Slip s (W,) rad/s adds to the rates of rolling, u = H V + s. The encoders see it through the
parities N u with N H = 0; a gyro adds the row (0, 0, 1) V = w, hence more parities:

    N [H; 0 0 1] = 0,      seen: N_wheels s,      hidden: the null space of N_wheels

A hidden pattern is one that looks like motion of the base. A wheel is seen if its column of
N_wheels is not 0, and can be blamed if no other column is parallel to its own: wheels with
parallel columns leave the same trace. On the rectangular mecanum base encoders alone give one
parity (no wheel can be blamed); encoders and gyro tell the two diagonals apart, not their wheels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import parity_basis
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

FAINT = 1e-6  # columns below this share of the largest are not seen
PARALLEL = 1e-3  # rad between two columns below which they leave the same trace


@dataclass(frozen=True, slots=True, eq=False)
class Visibility:
    """What one sensor set sees of the slip of W wheels.

    ``parities`` number of independent checks; ``seen`` (W,) bool; ``confused`` for each wheel the
    indices of wheels with the same trace; ``isolable`` (W,) bool: seen and confused with none;
    ``separation`` (W,) rad between a wheel's trace and the nearest other one, small = easily
    confused in noise; ``hidden`` (K, W) orthonormal slip patterns in rad/s that no check sees.
    """

    parities: int
    seen: tuple[bool, ...]
    confused: tuple[tuple[int, ...], ...]
    isolable: tuple[bool, ...]
    separation: FloatArray
    hidden: FloatArray


def assess_visibility(wheels: Wheels, *, gyro: bool) -> Visibility:
    """What the encoders see of slip, with or without a gyro."""
    matrix = wheels_from_body(wheels)
    if gyro:
        scale = float(np.linalg.norm(matrix[:, 2]))  # rad/s of yaw weighed like wheel rates
        matrix = np.vstack([matrix, [0.0, 0.0, scale]])
    rows = parity_basis(matrix)[:, :wheels.count]
    size = np.linalg.norm(rows, axis=0)
    seen = size > FAINT
    angle = _angles(rows / np.where(seen, size, 1.0))
    angle[~np.outer(seen, seen)] = np.pi / 2.0  # an unseen wheel is confused with none
    confused = tuple(tuple(int(j) for j in np.flatnonzero(row < PARALLEL)) for row in angle)
    return Visibility(len(rows), tuple(seen.tolist()), confused,
                      tuple(bool(s) and not c for s, c in zip(seen, confused)),
                      np.min(angle, axis=1), _null_space(rows, wheels.count))


def _angles(units: FloatArray) -> FloatArray:
    """(W, W) rad in [0, pi/2] between the lines along the columns; pi/2 on the diagonal."""
    angle: FloatArray = np.arccos(np.clip(np.abs(units.T @ units), 0.0, 1.0))
    np.fill_diagonal(angle, np.pi / 2.0)
    return angle


def _null_space(rows: FloatArray, count: int) -> FloatArray:
    if not len(rows):
        return np.eye(count)
    _, singular, right = np.linalg.svd(rows)
    rank = int(np.sum(singular > FAINT * singular[0]))
    space: FloatArray = right[rank:]
    return space
