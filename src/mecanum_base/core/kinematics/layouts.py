"""Wheel tables of the usual bases: rectangle of mecanum wheels, ring of Swedish wheels.

Rectangle (source R, order FL, FR, RL, RR): axles to the left, so that a positive rate drives
forward; rollers (+, -, -, +) * angle, which touch the ground as a diamond "O". Source T's numbers
1 = FR, 2 = FL, 3 = RL, 4 = RR are :data:`TLALE` indices into that order (models.md 1.0).

Ring (source R, 3 wheels; any number here): axles point inwards, rollers at pi/2, so that a
positive rate drives the wheel counter-clockwise about the centre:

    u_i = (-sin t_i vx + cos t_i vy + L w) / r        t_i mount angle, L distance from the centre
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

RECTANGLE = ('FL', 'FR', 'RL', 'RR')
TLALE = (1, 0, 2, 3)  # T's wheels 1, 2, 3, 4 as indices into RECTANGLE
_FRONT = np.array([1.0, 1.0, -1.0, -1.0])
_LEFT = np.array([1.0, -1.0, 1.0, -1.0])


def rectangle(half_wheelbase: float, half_track: float, radius: float,
              roller: float = math.pi / 4.0, *, roller_count: int = 0,
              pin_radius: float = 0.0) -> Wheels:
    """Four mecanum wheels FL, FR, RL, RR at (+-half_wheelbase, +-half_track) m.

    ``radius`` m, ``roller`` rad: |angle| between wheel axle and roller axis (T's alpha).
    """
    return Wheels(RECTANGLE, _FRONT * half_wheelbase, _LEFT * half_track,
                  np.full(4, math.pi / 2.0), _FRONT * _LEFT * roller, np.full(4, radius),
                  np.full(4, roller_count), np.full(4, pin_radius))


def swedish_ring(distance: float, radius: float, mount_angles: Sequence[float] | FloatArray,
                 roller: float = math.pi / 2.0) -> Wheels:
    """Wheels at ``mount_angles`` (W,) rad on a circle of radius ``distance`` m, axles inwards."""
    angles = np.asarray(mount_angles, dtype=np.float64)
    count = len(angles)
    return Wheels(tuple(f'wheel_{i + 1}' for i in range(count)),
                  distance * np.cos(angles), distance * np.sin(angles), angles + math.pi,
                  np.full(count, roller), np.full(count, radius))
