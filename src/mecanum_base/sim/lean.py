"""Heave, roll and pitch on the supports, and what the IMU feels (plain scalars, compilable).

    m h'' = sum N_i - m g cos(slope)          J_x roll'' = sum y_i N_i + H F_y
                                              J_y pitch'' = -sum x_i N_i - H F_x
    f = R_tilt^T (a - g),  a = a_C + w' x r + w x (w x r)                 [m/s^2]

F is the horizontal force of the floor, H the height of the mass centre, r the IMU seen from it.
Angles are small (first order). Each felt value passes a first-order low-pass filter; its integral
is kept too, because a sensor reports the mean since its last sample.
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence

from mecanum_base.sim.layout import (  # isort: skip
    GRAVITY, GRAVITY_X, GRAVITY_Y, HEIGHT, IMU_FILTER, IMU_X, IMU_Y, IMU_Z, MASS, PITCH_INERTIA,
    ROLL_INERTIA, S_AX, S_AY, S_AZ, S_GX, S_GY, S_GZ, S_HEAVE, S_HEAVE_RATE, S_PITCH,
    S_PITCH_RATE, S_ROLL, S_ROLL_RATE, S_SUM_AX, S_SUM_AY, S_SUM_AZ, S_SUM_GX, S_SUM_GY, S_SUM_GZ,
)


def lean(dt: float, body: Sequence[float], state: MutableSequence[float], lift: float,
         roll_moment: float, pitch_moment: float, ground_x: float, ground_y: float,
         gain_x: float, gain_y: float, yaw_rate: float, gain_w: float, cosine: float,
         sine: float) -> None:
    """Advance heave, roll, pitch and the felt values in ``state`` by one step ``dt`` [s].

    ``lift`` is the sum of the loads [N], ``*_moment`` that of the loads about C [N m], ``ground``
    the floor's force in body axes, ``gain`` the change of velocity in this step.
    """
    roll, pitch = state[S_ROLL], state[S_PITCH]
    heave_accel = lift / body[MASS] - body[GRAVITY]
    roll_accel = (roll_moment + body[HEIGHT] * ground_y) / body[ROLL_INERTIA]
    pitch_accel = (pitch_moment - body[HEIGHT] * ground_x) / body[PITCH_INERTIA]
    state[S_HEAVE_RATE] += dt * heave_accel
    state[S_ROLL_RATE] += dt * roll_accel
    state[S_PITCH_RATE] += dt * pitch_accel
    state[S_HEAVE] += dt * state[S_HEAVE_RATE]
    state[S_ROLL] += dt * state[S_ROLL_RATE]
    state[S_PITCH] += dt * state[S_PITCH_RATE]
    rx, ry, rz = body[IMU_X], body[IMU_Y], body[IMU_Z]
    spin_up = gain_w / dt
    feel_x = (gain_x / dt - spin_up * ry - yaw_rate * yaw_rate * rx + pitch_accel * rz
              - (cosine * body[GRAVITY_X] + sine * body[GRAVITY_Y]))
    feel_y = (gain_y / dt + spin_up * rx - yaw_rate * yaw_rate * ry - roll_accel * rz
              - (cosine * body[GRAVITY_Y] - sine * body[GRAVITY_X]))
    feel_z = body[GRAVITY] + heave_accel + roll_accel * ry - pitch_accel * rx
    k = body[IMU_FILTER]
    state[S_AX] += k * (feel_x - pitch * feel_z - state[S_AX])
    state[S_AY] += k * (feel_y + roll * feel_z - state[S_AY])
    state[S_AZ] += k * (feel_z - roll * feel_y + pitch * feel_x - state[S_AZ])
    state[S_GX] += k * (state[S_ROLL_RATE] - pitch * yaw_rate - state[S_GX])
    state[S_GY] += k * (state[S_PITCH_RATE] + roll * yaw_rate - state[S_GY])
    state[S_GZ] += k * (yaw_rate - state[S_GZ])
    state[S_SUM_GX] += dt * state[S_GX]
    state[S_SUM_GY] += dt * state[S_GY]
    state[S_SUM_GZ] += dt * state[S_GZ]
    state[S_SUM_AX] += dt * state[S_AX]
    state[S_SUM_AY] += dt * state[S_AY]
    state[S_SUM_AZ] += dt * state[S_AZ]
