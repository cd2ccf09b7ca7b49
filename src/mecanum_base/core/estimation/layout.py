"""Where each quantity of the filter lives: the error state and the working memory.

State x (N,), N = 14 + 4 W, W wheels:

    PX, PY, YAW         pose of base_link in odom                        m, m, rad
    VX, VY              velocity of base_link in its own axes            m/s
    BG, KG              gyro bias and scale error                        rad/s, 1
    KL                  error of the lever (yaw) gain                    1
    BAX, BAY            accelerometer bias + gravity leak of a tilted base  m/s^2
    KAX, KAY            scale errors of the accelerometer                1
    BSX, BSY            the part of it that is fixed to the sensor       m/s^2
    K .. K+W            scale error of each wheel (radius)               1
    PHI .. PHI+W        travel each wheel would show if nothing slipped  m along its roller axis
    CREEP .. CREEP+W    slow creep of a gripping wheel under traction    m/s along its roller axis
    SIDE .. SIDE+W      error of each wheel's lateral gain (its rollers) 1

PHI = K + W, CREEP = K + 2 W, SIDE = K + 3 W.

Travel is measured along the roller axis: z_i = r_i |sin d_i| * angle_i, and z_i' = A_i . twist
without slip, where A_i = r_i |sin d_i| H_i has a unit vector in its first two entries.
"""

from __future__ import annotations

from typing import NamedTuple

from mecanum_base.core.parameter import FloatArray, IntArray

PX, PY, YAW, VX, VY, BG, KG, KL, BAX, BAY, KAX, KAY, BSX, BSY, K = range(15)

# scalars of the working memory (Memory.m)
(HAVE_GYRO, HAVE_ACCEL, GYRO, ACC_X, ACC_Y, DONE_GYRO, DONE_AX, DONE_AY,
 SUM_T, SUM_X, SUM_Y, SUM_YAW, SUM_VX, SUM_VY, SUM_WX, SUM_WY, TURN_NOISE, PUSH_NOISE,
 SHAKE, TREMOR, WZ, LAST_YAW, JITTER, PERIOD, STILL, REST_FOR, QUIET, LOOSE_FOR, LOCKED_FOR,
 GRIP_NIS, PARITY, BODY, LATE, PENDING_T, SLOW_AX, SLOW_AY, SLOW_W, STRETCH,
 SLOW_VX, SLOW_VY, CARRIED, GLIDING, LEAN_X, LEAN_Y, LEAN_REST, LEAN_XZ, LEAN_YZ, LEAN_ZZ,
 LEAN_GAIN, LEAN_SEEN, LEAN_RX, LEAN_RY, LEAN_EVEN, FIX_VX, FIX_VY, FIX_BX, FIX_BY, FIX_PX, FIX_PY,
 WANDER, GAP_X, GAP_Y, GAP_YAW, LATE_RUN, CALM,
 EVEN_AX, EVEN_AY, HELD_FOR, HIT, OVER_FOR, CREEPS, KICK, ALL_SLID, JUMP_X, JUMP_Y,
 STEP_SUM, SLIP_SUM, DOUBT_XX, DOUBT_XY, DOUBT_YY, M_SIZE) = range(81)

# integers of the working memory (Memory.clock), nanoseconds unless said
(NOW, LAST_IMU, LAST_FRAME, SLOPE_AT, SLOPE_FILL, LATEST, PAST_AT, PAST_FILL,
 PAST_STAMP, PAST_OLD, JUDGED, CLOCK_SIZE) = range(12)


class Memory(NamedTuple):
    """Everything the kernels change, as arrays: a copy of them is a snapshot of the filter.

    What is marked "cells" is for access number by number only (:func:`.acceleration.cells`).
    """

    x: FloatArray  # (N,) state
    s: FloatArray  # the same as cells
    P: FloatArray  # (N, N) covariance of its error
    variance: FloatArray  # (N,) its diagonal
    m: FloatArray  # (M_SIZE,) cells, scalars named above
    clock: IntArray  # (CLOCK_SIZE,) cells, stamps
    rows: FloatArray  # (W, 3) A at this moment
    axis: FloatArray  # the same as cells
    hinge: FloatArray  # (C,) rad, hinge angles; empty for wheels
    mode: FloatArray  # (modes,) probability of each hypothesis
    wheel: FloatArray  # (WHEEL_ROWS, W) per-wheel quantities named below
    each: FloatArray  # the same as cells
    slope: FloatArray  # (2 * SLOPE, W) cells, slip speeds of the last frames, a ring
    past: FloatArray  # (PAST, 1 + 2 W) cells: stamps [s], travel, slid travel of the ratio window
    row: FloatArray  # (row size,) the last full output row
    entry: FloatArray  # the same as cells
    block: FloatArray  # (3 BLOCK,) cells, sums of the standstill detector: current, two before
    store: FloatArray  # all of the above but the clock in one row: the others are views of it
    kept: FloatArray  # (SLOTS, len(store)) snapshots of it
    kept_clock: IntArray  # (SLOTS, CLOCK_SIZE)
    kept_ns: IntArray  # (SLOTS, 4) cells: stamp, readings and rows before it (1, 3), looks left
    tape: FloatArray  # (TAPE, values) cells, the last readings
    tape_ns: IntArray  # (TAPE, 2) cells, stamp and kind
    reel: IntArray  # (REEL_SIZE,) cells, counters named below
    trail: FloatArray  # (rows, width) what became of the last frames; no rows: not kept
    trail_ns: IntArray  # (rows,) their stamps


# rows of Memory.wheel
(TRAVEL, SLIP, ANGLE, PROBABILITY, EXTRA, REST, FLAT, FROZEN_FOR, SIGMA,
 STEP, PENDING, REACH, FORCED, CHANGE, MEAN_STEP, MEAN_SLIP, WHEEL_ROWS) = range(17)

# entries of Memory.reel
REEL_COUNT, REEL_SLOT, REEL_ROWS, REEL_SIZE = range(4)

# columns of Memory.block
B_N, B_T, B_G, B_GG, B_X, B_XX, B_Y, B_YY, B_LEAN_X, B_LEAN_Y, BLOCK = range(11)

IMU, FRAME = 0, 1  # kinds of reading
SLOPE = 10  # frames averaged on either side of the slope gate
PAST = 64  # slots of the ratio window
