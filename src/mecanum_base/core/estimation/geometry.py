"""The base as the filter sees it: travel along the roller axis of each wheel, as rows of A.

    z_i = c_i * angle_i,  c_i = r_i |sin d_i|          A_i = c_i H_i  (unit vector, lever)

For a mecanum or omni base A is constant. For carriers (source D, section 4 of models.md) it
depends on the hinge angles: a plain wheel rolls along its carrier and the axle holds sideways, so
with the steering rate eliminated (D13, D20)

    c_ij = r_i,   A_ij V = hX_i + (y_ij/e_i) hY_i
    hX = cos t (vx - w y) + sin t (vy + w x),  hY = -sin t (vx - w y) + cos t (vy + w x)

and the hinge angles follow t_i' = -w - hY_i/e_i, unless they are measured.
"""

from __future__ import annotations

from typing import Union

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel
from mecanum_base.core.kinematics.matrix import effective_roller, wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform.carriers import Carriers

Base = Union[Wheels, Carriers]


def travel_per_radian(base: Base) -> FloatArray:
    """c (W,) m of travel along the roller axis (carriers: along the ground) per rad."""
    if isinstance(base, Carriers):
        return np.repeat(base.wheel_radius, 2)
    travel: FloatArray = base.radius * np.abs(np.sin(effective_roller(base)))
    return travel


def rolling_rows(base: Base, hinge: FloatArray | None = None) -> FloatArray:
    """A (W, 3) [m/s per m/s, m/s per rad/s]; ``hinge`` (C,) rad for carriers."""
    if isinstance(base, Carriers):
        return carrier_rows(carrier_table(base),
                            base.initial_angle if hinge is None else hinge)
    rows: FloatArray = travel_per_radian(base)[:, None] * wheels_from_body(base)
    return rows


def carrier_table(base: Carriers) -> FloatArray:
    """Columns (4, C) of x, y, axle offset, half track: what the kernels need of the carriers."""
    return np.vstack([base.x, base.y, base.axle_offset, base.half_track])


@kernel
def carrier_rows(table: FloatArray, hinge: FloatArray) -> FloatArray:
    """A (2 C, 3) of carriers (4, C) at the hinge angles (C,); order left, right of each."""
    rows = np.empty((2 * table.shape[1], 3))
    for i in range(table.shape[1]):
        x, y, offset, half = table[0, i], table[1, i], table[2, i], table[3, i]
        c, s = np.cos(hinge[i]), np.sin(hinge[i])
        for j in range(2):
            side = (half if j == 0 else -half) / offset
            rows[2 * i + j, 0] = c - side * s
            rows[2 * i + j, 1] = s + side * c
            rows[2 * i + j, 2] = (s * x - c * y) + side * (s * y + c * x)
    return rows


@kernel
def hinge_increment(table: FloatArray, hinge: FloatArray, motion: FloatArray) -> FloatArray:
    """Change (C,) rad of the hinge angles over the body increment (3,) (D19)."""
    change = np.empty(table.shape[1])
    for i in range(table.shape[1]):
        x, y, offset = table[0, i], table[1, i], table[2, i]
        c, s = np.cos(hinge[i]), np.sin(hinge[i])
        lateral = -s * (motion[0] - motion[2] * y) + c * (motion[1] + motion[2] * x)
        change[i] = -motion[2] - lateral / offset
    return change


def parallel_groups(rows: FloatArray, tolerance: float = 0.1) -> tuple[tuple[int, ...], ...]:
    """Sets of two or more wheels whose roller axes are parallel within ``tolerance`` [rad].

    On a mecanum base these are its diagonals: the wheels of a group share one force direction.
    """
    bearing = np.arctan2(rows[:, 1], rows[:, 0])
    groups: list[list[int]] = []
    for i, angle in enumerate(bearing):
        for group in groups:
            if abs(np.sin(angle - bearing[group[0]])) < np.sin(tolerance):
                group.append(i)
                break
        else:
            groups.append([i])
    return tuple(tuple(g) for g in groups if len(g) > 1)
