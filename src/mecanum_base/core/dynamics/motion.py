"""Equations of motion without slip: from wheel torques to acceleration and back (T5, T11-T15).

    (M + H^T Iw H) V' + C(V) + H^T loss(H V) = H^T tau

with M and C of :mod:`mecanum_base.core.dynamics.body`; V' are time derivatives of the body
components of the twist at O. Inverse: the wrench M V' + C(V) plus wheel inertia and losses; with
more than three wheels the torques of minimum 2-norm, plus any multiple of the null vector n, which
only loads the wheels against each other. Valid while no wheel slips: see
:mod:`mecanum_base.core.dynamics.traction`.
Not modelled: roller inertia, tyre compliance, vehicle tilt, the exact contact motion.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.dynamics.body import Body, DriveTrain, coriolis, mass_matrix
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray


def full_mass_matrix(wheels: Wheels, body: Body, train: DriveTrain) -> FloatArray:
    """M + H^T Iw H (3, 3): the base with its turning wheels."""
    matrix = wheels_from_body(wheels)
    full: FloatArray = mass_matrix(body) + train.inertia * matrix.T @ matrix
    return full


def forward_dynamics(wheels: Wheels, body: Body, train: DriveTrain, twist: FloatArray,
                     torques: FloatArray) -> FloatArray:
    """V' (3,) m/s^2, m/s^2, rad/s^2 from wheel torques (W,) N m at the twist (3,)."""
    matrix = wheels_from_body(wheels)
    effort = matrix.T @ (torques - train.loss(matrix @ twist)) - coriolis(body, twist)
    rate: FloatArray = np.linalg.solve(full_mass_matrix(wheels, body, train), effort)
    return rate


def body_wrench(body: Body, twist: FloatArray, twist_rate: FloatArray) -> FloatArray:
    """(Fx, Fy, Mz) at O in base_link that the base alone needs: M V' + C(V)."""
    wrench: FloatArray = mass_matrix(body) @ twist_rate + coriolis(body, twist)
    return wrench


def inverse_dynamics(wheels: Wheels, body: Body, train: DriveTrain, twist: FloatArray,
                     twist_rate: FloatArray) -> FloatArray:
    """Wheel torques (W,) N m of minimum norm for V' (3,) at the twist (3,)."""
    matrix = wheels_from_body(wheels)
    rates = matrix @ twist
    need = (body_wrench(body, twist, twist_rate)
            + matrix.T @ (train.inertia * (matrix @ twist_rate) + train.loss(rates)))
    torques: FloatArray = np.linalg.pinv(matrix.T) @ need
    return torques


def ground_torques(wheels: Wheels, train: DriveTrain, twist: FloatArray, twist_rate: FloatArray,
                   torques: FloatArray) -> FloatArray:
    """r F_roll (W,) N m: what of the shaft torques reaches the ground (T5 corrected)."""
    matrix = wheels_from_body(wheels)
    reaching: FloatArray = (torques - train.inertia * (matrix @ twist_rate)
                            - train.loss(matrix @ twist))
    return reaching


def kinetic_energy(wheels: Wheels, body: Body, train: DriveTrain, twist: FloatArray) -> float:
    """Energy [J] of the base and its turning wheels."""
    return 0.5 * float(twist @ full_mass_matrix(wheels, body, train) @ twist)
