"""Where two carrier robots are hinged under the platform and how far their axles lie behind.

    (x_i, y_i)  hinge in platform axes [m]      e_i  axle midpoint in carrier axes [m], < 0 trails

The model questions of source D (can this platform move, does its caster trail?) also concern
platforms that a robot file refuses, so nothing is judged here: e_i = 0 and coinciding hinges are
allowed. :attr:`mecanum_base.core.platform.carriers.Carriers.hinges` gives those of a real robot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.parameter import FloatArray, frozen_floats


@dataclass(frozen=True, slots=True, eq=False)
class Hinges:
    """Hinge positions ``x``, ``y`` (C,) m in base_link and ``axle_offset`` (C,) m, any values."""

    x: FloatArray
    y: FloatArray
    axle_offset: FloatArray

    def __post_init__(self) -> None:
        for key in ('x', 'y', 'axle_offset'):
            object.__setattr__(self, key, frozen_floats(getattr(self, key)))


def along_and_across(hinges: Hinges, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rows (C, 3), (C, 3): hinge velocity along and across carrier i, per unit platform twist.

    ``angles`` (C,) rad: carrier heading relative to base_link. From D12 without the axle:
    hX = c (vx - w y) + s (vy + w x),  hY = -s (vx - w y) + c (vy + w x)  [m/s].
    """
    c, s = np.cos(angles), np.sin(angles)
    along = np.column_stack([c, s, s * hinges.x - c * hinges.y])  # D12, first component
    across = np.column_stack([-s, c, s * hinges.y + c * hinges.x])  # D12, second component
    return along, across
