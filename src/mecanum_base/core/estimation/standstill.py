"""Standstill: when nothing moves, velocity is zero and both IMU biases show themselves.

The IMU is averaged over blocks of half the window. The base stands while the last two blocks are
quiet and agree, every wheel has kept its place with fresh readings, and the estimate itself does
not insist on moving. Then, once a block,

    0 = v,   mean(gyro) = bg,   mean(acc) = ba          (scalar updates)

and the pose is held. The first reading outside the block's spread or the first wheel that moves
ends it. Encoder readings must keep coming: a base that turns steadily looks still to an IMU.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.doubt import forget_doubt
from mecanum_base.core.estimation.layout import (
    B_G,
    B_GG,
    B_LEAN_X,
    B_LEAN_Y,
    B_N,
    B_T,
    B_X,
    B_XX,
    B_Y,
    B_YY,
    BAX,
    BAY,
    BG,
    BLOCK,
    BSX,
    BSY,
    CALM,
    EXTRA,
    FLAT,
    FORCED,
    GAP_YAW,
    HAVE_ACCEL,
    HAVE_GYRO,
    LAST_FRAME,
    LOCKED_FOR,
    LOOSE_FOR,
    NOW,
    PROBABILITY,
    PX,
    PY,
    QUIET,
    REST,
    REST_FOR,
    SLIP,
    STILL,
    VX,
    VY,
    WZ,
    YAW,
    K,
    Memory,
)
from mecanum_base.core.estimation.lean import FASTEST, rest
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.parameter import FloatArray

FRESH = 0.15  # s, age of the newest encoder frame that still proves that the wheels stand
STRANGE = 0.15  # m/s^2, an accelerometer mean this far from its bias is not rest
REST_SPEED = 0.002  # m/s, how still a standing base is
LEAVE_SPEED = 0.004  # m/s, least velocity uncertainty when a standstill ends


@kernel
def scalar(memory: Memory, index: int, innovation: float, variance: float) -> None:
    """Kalman update by a direct reading of state ``index``."""
    column = memory.P[:, index].copy()
    gain = column / (column[index] + variance)
    memory.x[:] += gain * innovation
    memory.P[:, :] -= np.outer(gain, column)


@kernel
def learn(model: Model, memory: Memory) -> None:
    """Zero velocity and bias updates from the block just finished.

    What they say about the way here is left aside: a base that stands must not move in odom, and
    its place stays as uncertain as it was (a consider update). Its heading may still improve.
    """
    b = memory.block[BLOCK:2 * BLOCK]
    n = max(b[B_N], 1.0)
    span = max(b[B_T], 1e-3)
    x, P = memory.x, memory.P
    P[BG, BG] += model.gyro_drift ** 2 * span
    sensor = model.sensor_drift ** 2 * span
    for offset, fixed in ((BAX, BSX), (BAY, BSY)):
        P[offset, offset] += sensor
        P[offset, fixed] += sensor
        P[fixed, offset] += sensor
        P[fixed, fixed] += sensor
    place, doubt = x[PX:PY + 1].copy(), P[PX:PY + 1, PX:PY + 1].copy()
    yaw = float(x[YAW])
    scalar(memory, VX, -float(x[VX]), REST_SPEED ** 2)
    scalar(memory, VY, -float(x[VY]), REST_SPEED ** 2)
    if memory.m[HAVE_GYRO] > 0.0:
        mean = b[B_G] / n
        noise = max(b[B_GG] / n - mean * mean, 0.0) / n + model.gyro_noise ** 2 / span
        scalar(memory, BG, mean - float(x[BG]), noise)
    rest(memory, b[B_LEAN_X] / n, b[B_LEAN_Y] / n, span)
    if memory.m[HAVE_ACCEL] > 0.0:
        noise = model.accel_noise ** 2 / span + 1e-4
        scalar(memory, BAX, b[B_X] / n - float(x[BAX]), noise)
        scalar(memory, BAY, b[B_Y] / n - float(x[BAY]), noise)
    x[PX:PY + 1] = place
    P[PX:PY + 1, PX:PY + 1] = doubt
    memory.m[GAP_YAW] += yaw - x[YAW]
    memory.P[:, :] = 0.5 * (P + P.T)


@kernel
def settle(memory: Memory, wheels: int, travel: FloatArray, resolution: FloatArray) -> None:
    """Enter standstill: hypotheses back to grip, every wheel anchored where it stands."""
    m, P = memory.m, memory.P
    phi, creep, side = K + wheels, K + 2 * wheels, K + 3 * wheels
    for i in range(phi, side):
        P[i, :] = 0.0
        P[:, i] = 0.0
    for i in range(wheels):
        P[phi + i, phi + i] = resolution[i] ** 2
        P[creep + i, creep + i] = 1e-8
    memory.x[phi:creep] = travel
    memory.x[creep:side] = 0.0
    memory.mode[:] = 0.0
    memory.mode[0] = 1.0
    memory.wheel[PROBABILITY] = 0.0
    memory.wheel[SLIP] = 0.0
    memory.wheel[EXTRA] = 0.0
    memory.wheel[FLAT] = 0.0
    m[LOOSE_FOR] = 0.0
    m[LOCKED_FOR] = 0.0
    forget_doubt(memory)
    m[WZ] = 0.0
    m[STILL] = 1.0
    m[CALM] = 1.0 if memory.wheel[FORCED].max() == 0.0 else 0.0


@kernel
def leave(memory: Memory) -> None:
    """End of a standstill: the base may move from now on."""
    m, P = memory.m, memory.P
    m[STILL] = 0.0
    m[REST_FOR] = 0.0
    for i in (VX, VY):
        if P[i, i] < LEAVE_SPEED ** 2:
            P[i, i] = LEAVE_SPEED ** 2


@kernel
def blocks_quiet(model: Model, memory: Memory) -> bool:
    """Both finished blocks are quiet and agree; a missing accelerometer does not forbid it."""
    a, b = memory.block[BLOCK:2 * BLOCK], memory.block[2 * BLOCK:]
    if a[B_N] < 3.0 or b[B_N] < 3.0 or memory.m[HAVE_GYRO] == 0.0:
        return False
    for first, square, limit in ((B_G, B_GG, model.rest_gyro), (B_X, B_XX, model.rest_accel),
                                 (B_Y, B_YY, model.rest_accel)):
        ma, mb = a[first] / a[B_N], b[first] / b[B_N]
        va = max(a[square] / a[B_N] - ma * ma, 0.0)
        vb = max(b[square] / b[B_N] - mb * mb, 0.0)
        if math.sqrt(va) > limit or math.sqrt(vb) > limit:
            return False
        if abs(ma - mb) > 4.5 * math.sqrt((va + vb) / a[B_N]) + 0.05 * limit:
            return False
    return True


@part
def familiar(memory: Memory, index: int, mean: float, slack: float) -> bool:
    """Is the mean of a block what the bias ``index`` lets expect?"""
    return bool(abs(mean - memory.x[index])
                < 4.0 * math.sqrt(float(memory.P[index, index])) + slack)


@part
def watch(model: Model, memory: Memory, gyro: float, ax: float, ay: float, roll: float,
          pitch: float, dt: float) -> None:
    """Take one IMU reading into the blocks; enter, feed or leave the standstill."""
    m, block = memory.m, memory.block
    if math.isnan(gyro):
        return
    if math.isnan(ax) or math.isnan(ay):
        ax = ay = 0.0
    if not abs(roll) + abs(pitch) < FASTEST:
        roll = pitch = 0.0
    if m[STILL] > 0.0:
        b = block[BLOCK:2 * BLOCK]
        n = max(b[B_N], 1.0)
        for value, first, square, limit in ((gyro, B_G, B_GG, model.rest_gyro),
                                            (ax, B_X, B_XX, model.rest_accel),
                                            (ay, B_Y, B_YY, model.rest_accel)):
            mean = b[first] / n
            sigma = math.sqrt(max(b[square] / n - mean * mean, 0.0))
            if abs(value - mean) > 5.0 * sigma + 0.5 * limit:
                leave(memory)
                for k in range(2 * BLOCK):
                    block[k] = 0.0
                return
    span = block[B_T] + dt
    block[B_N] += 1.0
    block[B_T] = span
    block[B_G] += gyro
    block[B_GG] += gyro * gyro
    block[B_X] += ax
    block[B_XX] += ax * ax
    block[B_Y] += ay
    block[B_YY] += ay * ay
    block[B_LEAN_X] += roll
    block[B_LEAN_Y] += pitch
    if span < 0.5 * model.rest_window:
        return
    for k in range(BLOCK):  # current and last become last and the one before
        block[2 * BLOCK + k] = block[BLOCK + k]
        block[BLOCK + k] = block[k]
        block[k] = 0.0
    age = (memory.clock[NOW] - memory.clock[LAST_FRAME]) * 1e-9
    calm = blocks_quiet(model, memory) and age < FRESH and m[QUIET] > model.rest_window
    if not calm:
        m[REST_FOR] = 0.0
        if m[STILL] > 0.0:
            leave(memory)
        return
    m[REST_FOR] += block[BLOCK + B_T]
    if m[STILL] == 0.0:
        x, P = memory.x, memory.P
        insist = math.hypot(float(x[VX]), float(x[VY]))
        sigma = math.sqrt(float(P[VX, VX]) + float(P[VY, VY]))
        b = block[BLOCK:2 * BLOCK]
        n = b[B_N]
        agrees = insist < 4.0 * (sigma + 0.01) and familiar(memory, BG, b[B_G] / n, 0.01)
        if m[HAVE_ACCEL] > 0.0:  # a steady push looks quiet too, but its mean is not the bias
            agrees = (agrees and familiar(memory, BAX, b[B_X] / n, STRANGE)
                      and familiar(memory, BAY, b[B_Y] / n, STRANGE))
        if not agrees and m[REST_FOR] < 2.0:
            return
        settle(memory, model.wheels, memory.wheel[REST].copy(), model.resolution)
    learn(model, memory)
