"""Covariance of the error over the motion since the last covariance step.

    P <- F P F' + G q G' + diag(Q)

F = I + (first-order derivative of the motion), with the sums of :mod:`.inertial` in place of
dt-times-rate, so that one step serves any number of IMU samples. The gyro is an input, not a
measurement: its noise enters along one vector d = (yaw 1, vx vy, vy -vx, phi_i A_i3) with exact
correlation, and no yaw-rate state is needed.

The columns of the scale errors use only what was known before this step (velocity at its start,
rates averaged over the time before, even steps in place of jittering stamps): what the step itself
brings carries the noise that the next residual shows, and that product would pull every scale the
same way, a little each step.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel
from mecanum_base.core.estimation.geometry import hinge_increment
from mecanum_base.core.estimation.layout import (
    BAX,
    BAY,
    BG,
    BSX,
    BSY,
    EXTRA,
    HAVE_ACCEL,
    HAVE_GYRO,
    KAX,
    KAY,
    KG,
    KL,
    KY,
    LOCKED_FOR,
    LOOSE_FOR,
    PX,
    PY,
    SHAKE,
    SLOW_AX,
    SLOW_AY,
    SLOW_VX,
    SLOW_VY,
    SLOW_W,
    STRETCH,
    SUM_T,
    SUM_VX,
    SUM_VY,
    SUM_WX,
    SUM_WY,
    SUM_X,
    SUM_Y,
    SUM_YAW,
    TREMOR,
    VX,
    VY,
    YAW,
    K,
    Memory,
)
from mecanum_base.core.estimation.lean import wander
from mecanum_base.core.estimation.model import Model

# columns of A behind VX, VY, BG, KG, KY, KL in the rows of the travel states
SPREAD = np.array([0, 1, 2, 2, 1, 2])


@kernel
def spread(model: Model, memory: Memory) -> None:
    """Bring travel and covariance up to the mean and start new sums."""
    m, x = memory.m, memory.x
    T = float(m[SUM_T])
    if T <= 0.0:
        return
    w = model.wheels
    phi, creep, n = K + w, K + 2 * w, K + 3 * w
    rows = memory.rows
    turn = float(m[SUM_YAW])
    lateral, lever = 1.0 + float(x[KY]), 1.0 + float(x[KL])
    motion = np.array([float(m[SUM_X]), lateral * float(m[SUM_Y]), lever * turn])
    decay = math.exp(-T / model.creep_time)
    rolled = (1.0 + x[K:phi]) * (rows @ motion)
    x[phi:creep] += rolled + T * x[creep:n]
    x[creep:n] *= decay
    if memory.hinge.shape[0] > 0:
        memory.hinge[:] += hinge_increment(model.carriers, memory.hinge, motion)

    even = T * float(m[STRETCH])  # s, without the jitter of the stamps
    slow_turn = float(m[SLOW_W]) * even
    slow_x, slow_y = float(m[SLOW_VX]) * even, float(m[SLOW_VY]) * even
    push_x, push_y = float(m[SUM_VX]), float(m[SUM_VY])
    end_x, end_y = float(x[VX]), float(x[VY])
    vx, vy = end_x - push_x - turn * end_y, end_y - push_y + turn * end_x  # at its start
    yaw = float(x[YAW]) - 0.5 * turn
    c, s = math.cos(yaw), math.sin(yaw)
    F = np.eye(n)
    F[YAW, BG] = -T
    F[YAW, KG] = -slow_turn
    F[PX, YAW] = -m[SUM_WY]
    F[PX, VX] = c * T
    F[PX, VY] = -s * T
    F[PY, YAW] = m[SUM_WX]
    F[PY, VX] = s * T
    F[PY, VY] = c * T
    F[VX, VY] = turn
    F[VX, BG] = -vy * T
    F[VX, KG] = -vy * slow_turn
    F[VX, BAX] = -T
    F[VX, KAX] = -m[SLOW_AX] * T
    F[VY, VX] = -turn
    F[VY, BG] = vx * T
    F[VY, KG] = vx * slow_turn
    F[VY, BAY] = -T
    F[VY, KAY] = -m[SLOW_AY] * T
    F[BAX, BAY] = turn
    F[BAX, BSY] = -turn
    F[BAY, BAX] = -turn
    F[BAY, BSX] = turn
    F[phi:creep, VX:KL + 1] = rows[:, SPREAD] * np.array(
        [even, lateral * even, -lever * even, -lever * slow_turn, slow_y, slow_turn])
    slow_rolled = rows @ np.array([slow_x, lateral * slow_y, lever * slow_turn])
    for i in range(w):
        F[phi + i, K + i] = slow_rolled[i]
        F[phi + i, creep + i] = even
        F[creep + i, creep + i] = decay

    speed = min(1.5, math.hypot(end_x, end_y) + 0.2 * abs(turn) / T)
    share = T / (T + model.traction_time)
    ax = float(m[SLOW_AX]) + share * (push_x / T - float(m[SLOW_AX]))
    ay = float(m[SLOW_AY]) + share * (push_y / T - float(m[SLOW_AY]))
    m[SLOW_AX], m[SLOW_AY] = ax, ay
    share = T / (T + model.scale_time)
    m[SLOW_W] += share * (turn / T - m[SLOW_W])
    m[SLOW_VX] += share * (vx - m[SLOW_VX])
    m[SLOW_VY] += share * (vy - m[SLOW_VY])
    push = math.hypot(ax, ay)
    trust = 1.0
    if m[LOCKED_FOR] > model.patience:
        trust += 400.0 * (float(m[LOCKED_FOR]) - model.patience)
    if m[HAVE_GYRO] > 0.0:
        qg = T * max(model.gyro_noise ** 2 + (model.gyro_shake * speed) ** 2,
                     1.5 * float(m[TREMOR]))
    else:
        qg = (model.blind_turn * T) ** 2
    if m[HAVE_ACCEL] > 0.0:
        qa = trust * max(model.accel_noise ** 2 + (model.accel_shake * speed) ** 2,
                         1.5 * float(m[SHAKE])) * T
    else:
        qa = model.blind_push ** 2 * T
    G = np.zeros((n, 3))
    rg, ra = math.sqrt(qg), math.sqrt(qa)
    G[VX, 0] = ra
    G[VY, 1] = ra
    G[YAW, 2] = rg
    G[VX, 2] = vy * rg
    G[VY, 2] = -vx * rg
    G[phi:creep] = rows * np.array([0.5 * T * ra, 0.5 * T * ra, rg])

    P = F @ memory.P @ F.T + G @ G.T
    tilt = wander(model, memory) * T * trust
    sensor = model.sensor_drift ** 2 * T
    P[BG, BG] += model.gyro_drift ** 2 * T
    for b, s in ((BAX, BSX), (BAY, BSY)):
        P[b, b] += tilt + sensor
        P[b, s] += sensor
        P[s, b] += sensor
        P[s, s] += sensor
    size = np.abs(rolled)
    micro = model.rolling_noise ** 2 + model.traction_noise ** 2 * push
    sigma = model.creep_rest * speed + model.creep_traction * push + model.creep_hard * push * push
    loose = m[LOOSE_FOR] > 0.0
    if loose:
        sigma += model.creep_loose
        memory.wheel[EXTRA] += (model.extra_creep * model.rolling_noise ** 2) * size
    grow = sigma * sigma * (1.0 - decay * decay)
    for i in range(w):
        P[phi + i, phi + i] += micro * size[i] + 1e-12
        P[creep + i, creep + i] += grow
    memory.P[:, :] = P
    for k in range(SUM_T, SUM_WY + 1):
        m[k] = 0.0
