"""Platform on two hinged differential robots: wheel rates from a twist and the twist from them.

Inverse (source D eq. 19, 20, rebuilt), hinge velocity (hX, hY) along and across carrier i:

    theta_i' = -w - hY_i / e_i                       hinge rate, relative to the platform [rad/s]
    phi_ij'  = (hX_i + (y_ij / e_i) hY_i) / r_i      wheel rate, positive = forward [rad/s]

Forward (D13, D14 inverted): each carrier measures its axle speed X = (r/2)(phi_1' + phi_2') and
its yaw rate Omega = (r/2b)(phi_2' - phi_1') (1 = left, y = +b; 2 = right, y = -b), hence its
hinge velocity (X, -e Omega) in carrier axes. Two hinges give four equations for the three parts
of the twist: least squares in m/s. What is left is the stretch of the line between the hinges,

    stretch = (v_2 - v_1) . (h_2 - h_1) / |h_2 - h_1|   [m/s]: not 0 proves slip, as parity does.

H depends on the hinge angles; everything else is used as H of a roller-wheel base. Wheel arrays
are (left_0, right_0, left_1, right_1), the order of ``carriers.joint``.
Not modelled: lateral slip of the axles, compliance of the hinges.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.platform.hinges import along_and_across


def _lateral_positions(carriers: Carriers) -> FloatArray:
    """(C, 2) m: wheel positions across the carrier, left +b, right -b."""
    return np.column_stack([carriers.half_track, -carriers.half_track])


def hinges_from_body(carriers: Carriers, angles: FloatArray) -> FloatArray:
    """(C, 3): hinge rates theta' [rad/s] = hinges_from_body @ twist (D19)."""
    _, across = along_and_across(carriers.hinges, angles)
    matrix: FloatArray = -across / carriers.axle_offset[:, None]  # D13: theta' = -w - hY/e
    matrix[:, 2] -= 1.0
    return matrix


def wheels_from_body(carriers: Carriers, angles: FloatArray) -> FloatArray:
    """H (W, 3) at hinge angles (C,) rad: wheel rates [rad/s] = H @ twist (D20)."""
    along, across = along_and_across(carriers.hinges, angles)
    lever = _lateral_positions(carriers) / carriers.axle_offset[:, None]
    rows = along[:, None, :] + lever[:, :, None] * across[:, None, :]  # D20: hX + (y/e) hY
    matrix: FloatArray = (rows / carriers.wheel_radius[:, None, None]).reshape(-1, 3)
    return matrix


def carriers_from_wheels(carriers: Carriers) -> FloatArray:
    """(2 C, W): axle speed X_i [m/s], then carrier yaw rate Omega_i [rad/s], for each carrier."""
    count = len(carriers.name)
    matrix = np.zeros((2 * count, 2 * count))
    for i in range(count):
        radius, track = carriers.wheel_radius[i], carriers.half_track[i]
        matrix[2 * i, 2 * i:2 * i + 2] = radius / 2.0  # D14 added: X = (r/2)(phi1 + phi2)
        matrix[2 * i + 1, 2 * i] = -radius / (2.0 * track)  # D14 subtracted: Omega
        matrix[2 * i + 1, 2 * i + 1] = radius / (2.0 * track)
    return matrix


def _hinge_velocities(carriers: Carriers, angles: FloatArray) -> FloatArray:
    """(2 C, W): velocity (x, y) of each hinge in platform axes, per unit wheel rate."""
    motion = carriers_from_wheels(carriers)
    c, s, e = np.cos(angles), np.sin(angles), carriers.axle_offset
    rows = np.empty_like(motion)
    for i in range(len(carriers.name)):
        speed, turn = motion[2 * i], motion[2 * i + 1]
        rows[2 * i] = c[i] * speed + s[i] * e[i] * turn  # (X, -e Omega) turned by +theta
        rows[2 * i + 1] = s[i] * speed - c[i] * e[i] * turn
    return rows


def _hinges_of_twist(carriers: Carriers) -> FloatArray:
    """(2 C, 3): velocity of each hinge in platform axes, per unit platform twist."""
    rows = np.zeros((2 * len(carriers.name), 3))
    rows[0::2, 0] = rows[1::2, 1] = 1.0
    rows[0::2, 2], rows[1::2, 2] = -carriers.y, carriers.x
    return rows


def body_from_wheels(carriers: Carriers, angles: FloatArray) -> FloatArray:
    """(3, W): twist = body_from_wheels @ rates, least squares over the hinge velocities [m/s]."""
    matrix: FloatArray = np.linalg.pinv(_hinges_of_twist(carriers)) @ _hinge_velocities(
        carriers, angles)  # D13, D14 inverted
    return matrix


def hinges_from_wheels(carriers: Carriers, angles: FloatArray) -> FloatArray:
    """(C, W): hinge rates theta' [rad/s] from wheel rates: theta' = Omega_i - w (D11)."""
    matrix: FloatArray = (carriers_from_wheels(carriers)[1::2]
                          - body_from_wheels(carriers, angles)[2])
    return matrix


def stretch_from_wheels(carriers: Carriers, angles: FloatArray) -> FloatArray:
    """(W,): rate [m/s] at which the wheels would pull the hinges apart; 0 without slip."""
    span = np.array([carriers.x[1] - carriers.x[0], carriers.y[1] - carriers.y[0]])
    velocity = _hinge_velocities(carriers, angles)
    row: FloatArray = span @ (velocity[2:4] - velocity[0:2]) / np.hypot(*span)
    return row
