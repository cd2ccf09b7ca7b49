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
PARALLEL = 1e-3  # sine of the angle below which two columns leave the same trace


@dataclass(frozen=True, slots=True, eq=False)
class Visibility:
    """What one sensor set sees of the slip of W wheels.

    ``parities`` number of independent checks; ``seen`` (W,) bool; ``confused`` for each wheel the
    indices of wheels with the same trace; ``isolable`` (W,) bool: seen and confused with none;
    ``hidden`` (K, W) orthonormal slip patterns in rad/s that no check sees.
    """

    parities: int
    seen: tuple[bool, ...]
    confused: tuple[tuple[int, ...], ...]
    isolable: tuple[bool, ...]
    hidden: FloatArray


def assess_visibility(wheels: Wheels, *, gyro: bool) -> Visibility:
    """What the encoders see of slip, with or without a gyro."""
    matrix = wheels_from_body(wheels)
    if gyro:
        scale = float(np.linalg.norm(matrix[:, 2]))  # rad/s of yaw weighed like wheel rates
        matrix = np.vstack([matrix, [0.0, 0.0, scale]])
    rows = parity_basis(matrix)[:, :wheels.count]
    size = np.linalg.norm(rows, axis=0) if len(rows) else np.zeros(wheels.count)
    seen = tuple(bool(value > FAINT) for value in size)
    confused = tuple(
        tuple(j for j in range(wheels.count)
              if j != i and seen[i] and seen[j] and _same_trace(rows[:, i], rows[:, j]))
        for i in range(wheels.count))
    isolable = tuple(s and not c for s, c in zip(seen, confused))
    return Visibility(len(rows), seen, confused, isolable, _null_space(rows, wheels.count))


def _same_trace(first: FloatArray, second: FloatArray) -> bool:
    cosine = float(first @ second) / float(np.linalg.norm(first) * np.linalg.norm(second))
    return 1.0 - cosine * cosine < PARALLEL ** 2


def _null_space(rows: FloatArray, count: int) -> FloatArray:
    if not len(rows):
        return np.eye(count)
    _, singular, right = np.linalg.svd(rows)
    rank = int(np.sum(singular > FAINT * singular[0]))
    space: FloatArray = right[rank:]
    return space
