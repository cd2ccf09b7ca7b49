"""The linear system u = H V between wheel rates and body twist, for any set of roller wheels.

A roller passes only the force along its own axis, so each wheel gives one equation: the velocity
of its centre along the roller axis is what the wheel rim provides (Gfrerrer eq. 16, 17):

    u_i = -[ sin(a_i + d_i) (vy + w x_i) + cos(a_i + d_i) (vx - w y_i) ] / (r_i sin d_i)

    u_i  wheel rate [rad/s]         (vx, vy, w)  twist in base_link [m/s, m/s, rad/s]
    a_i  axle direction [rad]       d_i          roller angle from the axle [rad]

Mean contact correction (models.md 2.1, item 6): the contact point wanders along each roller, so
per roller pitch the base moves by 2 r tan(d) sin(pi/k) and not by 2 r tan(d) pi/k. Averaged,

    tan(d_eff) = tan(d) sin(pi/k) / (pi/k)        k = number of rollers, 0 = unknown, no correction

cures the lateral and the yaw scale; command and odometry both use this one H.
Not modelled here: the ripple within a roller pitch (see :mod:`mecanum_base.core.contact`).
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray


def effective_roller(wheels: Wheels) -> FloatArray:
    """Roller angles (W,) rad after the mean contact correction, in (-pi, pi] like the input."""
    angles = np.array(wheels.roller)
    for index, count in enumerate(wheels.roller_count):
        if count:
            pitch = math.pi / int(count)
            scale = math.sin(pitch) / pitch
            sine, cosine = math.sin(angles[index]), math.cos(angles[index])
            angles[index] = math.atan2(sine * scale, cosine)  # tan(d_eff) = tan(d) * scale
    return angles


def wheels_from_body(wheels: Wheels, *, corrected: bool = True) -> FloatArray:
    """H (W, 3) [rad/s per m/s, rad/s per rad/s]: wheel rates = H @ twist (G eq. 16, 17).

    ``corrected`` applies the mean contact correction where the roller count is known.
    """
    roller = effective_roller(wheels) if corrected else wheels.roller
    direction = wheels.axle + roller
    sine, cosine = np.sin(direction), np.cos(direction)
    rows = np.column_stack([cosine, sine, wheels.x * sine - wheels.y * cosine])
    matrix: FloatArray = -rows / (wheels.radius * np.sin(roller))[:, None]  # G eq. 16
    return matrix
