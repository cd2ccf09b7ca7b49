"""From wheel torques to the force on the base: ideal rollers, and Tlale's own split (T eq. 6-13).

A free roller carries no force across its axis, so the torque T of wheel i appears on the ground as
F_i = T / (r sin(delta)) along the roller axis, and by power duality with u = H V

    wrench = H^T tau     (Fx, Fy, Mz) in base_link, tau in N m                     (default model)

Source T splits F_T = T/r by F = F_T sin(delta) (effective) and S = F_T cos(delta) ("slip"):
smaller by sin^2(delta), with no place for the missing power. It is kept here under its own name:

    T9   F_right = sum (-1)^i SIG_i K_i F_Ti sin cos
    T10  F_forward = sum SIG_i K_i F_Ti sin^2
    T11  m X'' = sin(phi) F_right + cos(phi) F_forward - friction
    T13  m Y'' = -cos(phi) F_right + sin(phi) F_forward - friction     (printed with +cos: wrong)

phi = angle from world X to the forward axis. Order of T: 1 = FR, 2 = FL, 3 = RL, 4 = RR.
Not modelled: roller inertia and bearing friction, tyre compliance.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.kinematics.matrix import effective_roller, wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

_PARITY = np.array([-1.0, 1.0, -1.0, 1.0])  # (-1)^i for i = 1..4


def wrench_from_torques(wheels: Wheels, torques: FloatArray) -> FloatArray:
    """(Fx N, Fy N, Mz N m) in base_link from wheel torques (W,) N m, ideal rollers."""
    wrench: FloatArray = wheels_from_body(wheels).T @ torques  # T8-T13, T15 in one line
    return wrench


def roller_forces(wheels: Wheels, torques: FloatArray) -> FloatArray:
    """(W,) N on the base along +b = (cos, sin)(axle + roller): -T/(r sin delta) (T6 ideal)."""
    force: FloatArray = -torques / (wheels.radius * np.sin(effective_roller(wheels)))
    return force


def split(wheel_force: FloatArray, angle: float) -> tuple[FloatArray, FloatArray]:
    """Source T's (effective, ineffective) force [N] of F_T [N] at roller angle [rad] (T6, T7)."""
    return wheel_force * math.sin(angle), wheel_force * math.cos(angle)


def tlale_forces(wheel_force: FloatArray, angle: float, sign: FloatArray | None = None,
                 tightness: FloatArray | None = None) -> tuple[float, float]:
    """Source T's (force to the right, force forward) [N] on the base (T9, T10), wheels 1..4.

    ``wheel_force`` (4,) N = T/r; ``sign`` (4,) SIG, + drives forward; ``tightness`` (4,) K.
    """
    drive = _drive(wheel_force, sign) * (1.0 if tightness is None else tightness)
    sine, cosine = math.sin(angle), math.cos(angle)
    right = float(np.sum(_PARITY * drive)) * sine * cosine  # T eq. 9
    forward = float(np.sum(drive)) * sine**2  # T eq. 10
    return right, forward


def ideal_forces(wheel_force: FloatArray, angle: float,
                 sign: FloatArray | None = None) -> tuple[float, float]:
    """(force to the right, force forward) [N] with ideal rollers, wheels 1..4 of source T."""
    drive = _drive(wheel_force, sign)
    return float(np.sum(_PARITY * drive)) / math.tan(angle), float(np.sum(drive))


def _drive(wheel_force: FloatArray, sign: FloatArray | None) -> FloatArray:
    return wheel_force if sign is None else wheel_force * sign


def world_force(heading: float, right: float, forward: float) -> FloatArray:
    """(X, Y) N from body forces; ``heading`` rad from world X to forward (T11, T13 corrected)."""
    sine, cosine = math.sin(heading), math.cos(heading)
    return np.array([sine * right + cosine * forward,  # T eq. 11, 12
                     -cosine * right + sine * forward])  # T eq. 13 corrected


def dry_friction(drive: FloatArray, velocity: FloatArray, limit: float) -> FloatArray:
    """(2,) N: friction against ``velocity`` (2,), at rest against ``drive`` (2,) up to ``limit``.

    The term T11-T13 print as "- F_f" without its sign: it opposes the motion and only cancels
    the drive while the base stands.
    """
    along = velocity if np.any(velocity) else drive
    size = float(np.hypot(*along))
    if size == 0.0:
        return np.zeros(2)
    held = limit if np.any(velocity) else min(limit, size)
    force: FloatArray = -along / size * held
    return force


def yaw_torque(track: float, wheelbase: float, angle: float,
               roller_force: FloatArray) -> tuple[float, float]:
    """(torque N m counter-clockwise, lever m) of forces along the rollers (T15, T16 corrected).

    ``track`` and ``wheelbase`` are source T's full x and y [m]; ``roller_force`` (4,) N positive
    along the drive direction of wheels 1..4. The lever is l sin(xi) = (x sin + y cos)/2.
    """
    lever = 0.5 * (track * math.sin(angle) + wheelbase * math.cos(angle))  # T15: l sin(xi)
    turn = np.array([1.0, -1.0, -1.0, 1.0])  # T15: a, counter-clockwise positive
    return float(turn @ roller_force) * lever, lever


def roller_bearing(track: float, wheelbase: float, angle: float) -> tuple[float, float]:
    """(l m, xi rad): centre to wheel (T16) and its angle to the roller force."""
    distance = 0.5 * math.hypot(track, wheelbase)  # T eq. 16
    cosine = (track * math.cos(angle) - wheelbase * math.sin(angle)) / (2.0 * distance)
    return distance, math.acos(max(-1.0, min(1.0, cosine)))
