"""Places in the flat number tables that the plant kernel works on.

The kernel is written in plain scalars so that the same lines run as Python (tables are lists) and
compiled by numba (tables are float64 arrays). Tables of wheels hold one row of fixed length each.
"""

from __future__ import annotations

# body: constants
(MASS, INERTIA, CX, CY, HEIGHT, ROLL_INERTIA, PITCH_INERTIA, GRAVITY, GRAVITY_X, GRAVITY_Y,
 SUPPORT_K, SUPPORT_C, STATIC, KINETIC, STRIBECK, SIGMA0, SIGMA1, KAPPA, ROLLER_DRAG, BEARING,
 VISCOUS, WHEEL_INERTIA, TORQUE_PER_VOLT, BACK_EMF, VOLT_LIMIT, TORQUE_LIMIT, KP, KI,
 IMU_X, IMU_Y, IMU_Z, IMU_FILTER, WALL_K, WALL_C) = range(34)
BODY = 34

# state of the body: mass centre in the floor frame, rates at mid-step, tilt, felt by the IMU (now,
# and its integral over time)
(S_X, S_Y, S_YAW, S_VX, S_VY, S_W, S_HEAVE, S_ROLL, S_PITCH, S_HEAVE_RATE, S_ROLL_RATE,
 S_PITCH_RATE, S_BVX, S_BVY, S_GX, S_GY, S_GZ, S_AX, S_AY, S_AZ, S_GROUND_X, S_GROUND_Y,
 S_GROUND_MZ, S_SUM_GX, S_SUM_GY, S_SUM_GZ, S_SUM_AX, S_SUM_AY, S_SUM_AZ) = range(29)
STATE = 29

# one wheel: constants
(W_X, W_Y, W_AX, W_AY, W_COS, W_SIN, W_RADIUS, W_REACH, W_PITCH, W_PHASE, W_RUNOUT,
 W_RUNOUT_PHASE, W_TYRE, W_HINGE) = range(14)
WHEEL = 14

# one wheel: state
(T_ANGLE, T_RATE, T_SHEAR, T_SHEAR_SIDE, T_INTEGRAL, T_SLIP_RATE, T_SLIP_ANGLE, T_LOAD, T_FORCE,
 T_FORCE_SIDE, T_TORQUE, T_SLIP, T_SLIP_SIDE) = range(13)
TURN = 13

# one wheel: input from outside
(I_RATE, I_GRIP, I_JAM, I_FREE, I_DROP) = range(5)
INPUT = 5

# one wheel: scratch between the two passes of a step
(R_BX, R_BY, R_BZ, R_BH, R_TX, R_TY, R_TZ, R_TH, R_RHO_B, R_RHO_T, R_AB, R_BB, R_AT, R_BT, R_P,
 R_Q, R_DECAY, R_MOTOR) = range(18)
ROW = 18

# one carrier: hinge x, y, inertia about the hinge;  state: heading relative to base, absolute rate
(H_X, H_Y, H_INERTIA, H_ANGLE, H_RATE, H_D, H_KX, H_KY, H_KZ, H_RHS) = range(10)
HINGE = 10

WALL = 3  # normal x, y (pointing into the free space), distance from the origin
CORNER = 2
