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
from mecanum_base.core.parameter import FloatArray

ROW_BAX, ROW_BAY, TRAVELS = 5, 6, 7  # rows of F; before them pose and velocity, as in the state


@kernel
def spread(model: Model, memory: Memory) -> None:
    """Bring travel and covariance up to the mean and start new sums."""
    m, s, axis = memory.m, memory.s, memory.axis
    T = m[SUM_T]
    if T <= 0.0:
        return
    w = model.wheels
    phi, creep, n = K + w, K + 2 * w, K + 3 * w
    turn = m[SUM_YAW]
    lateral, lever = 1.0 + s[KY], 1.0 + s[KL]
    path_x, path_y, path_turn = m[SUM_X], lateral * m[SUM_Y], lever * turn
    decay = math.exp(-T / model.creep_time)
    even = T * m[STRETCH]  # s, without the jitter of the stamps
    slow_turn, slow_x, slow_y = m[SLOW_W] * even, m[SLOW_VX] * even, m[SLOW_VY] * even
    push_x, push_y = m[SUM_VX], m[SUM_VY]
    end_x, end_y = s[VX], s[VY]
    vx, vy = end_x - push_x - turn * end_y, end_y - push_y + turn * end_x  # at its start
    ax, ay = m[SLOW_AX], m[SLOW_AY]
    yaw = s[YAW] - 0.5 * turn
    cos, sin = math.cos(yaw), math.sin(yaw)
    F = np.zeros((TRAVELS + w, n))  # its rows that are neither those of I nor of creep
    for i in range(YAW + 1):
        F[i, i] = 1.0
    F[YAW, BG] = -T
    F[YAW, KG] = -slow_turn
    F[PX, YAW] = -m[SUM_WY]
    F[PX, VX] = cos * T
    F[PX, VY] = -sin * T
    F[PY, YAW] = m[SUM_WX]
    F[PY, VX] = sin * T
    F[PY, VY] = cos * T
    F[VX, VX] = 1.0
    F[VX, VY] = turn
    F[VX, BG] = -vy * T
    F[VX, KG] = -vy * slow_turn
    F[VX, BAX] = -T
    F[VX, KAX] = -ax * T
    F[VY, VX] = -turn
    F[VY, VY] = 1.0
    F[VY, BG] = vx * T
    F[VY, KG] = vx * slow_turn
    F[VY, BAY] = -T
    F[VY, KAY] = -ay * T
    F[ROW_BAX, BAX] = 1.0
    F[ROW_BAX, BAY] = turn
    F[ROW_BAX, BSY] = -turn
    F[ROW_BAY, BAX] = -turn
    F[ROW_BAY, BAY] = 1.0
    F[ROW_BAY, BSX] = turn

    speed = min(1.5, math.hypot(end_x, end_y) + 0.2 * abs(turn) / T)
    share = T / (T + model.traction_time)
    ax += share * (push_x / T - ax)
    ay += share * (push_y / T - ay)
    m[SLOW_AX], m[SLOW_AY] = ax, ay
    share = T / (T + model.scale_time)
    m[SLOW_W] += share * (turn / T - m[SLOW_W])
    m[SLOW_VX] += share * (vx - m[SLOW_VX])
    m[SLOW_VY] += share * (vy - m[SLOW_VY])
    push = math.hypot(ax, ay)
    trust = 1.0
    if m[LOCKED_FOR] > model.patience:
        trust += 400.0 * (m[LOCKED_FOR] - model.patience)
    if m[HAVE_GYRO] > 0.0:
        qg = T * max(model.gyro_noise ** 2 + (model.gyro_shake * speed) ** 2, 1.5 * m[TREMOR])
    else:
        qg = (model.blind_turn * T) ** 2
    if m[HAVE_ACCEL] > 0.0:
        qa = trust * max(model.accel_noise ** 2 + (model.accel_shake * speed) ** 2,
                         1.5 * m[SHAKE]) * T
    else:
        qa = model.blind_push ** 2 * T
    rg, ra = math.sqrt(qg), math.sqrt(qa)
    G = np.zeros((TRAVELS + w, 3))
    G[YAW, 2] = rg
    G[VX, 0] = ra
    G[VX, 2] = vy * rg
    G[VY, 1] = ra
    G[VY, 2] = -vx * rg

    P = memory.P
    micro = model.rolling_noise ** 2 + model.traction_noise ** 2 * push
    sigma = model.creep_rest * speed + model.creep_traction * push + model.creep_hard * push * push
    loose = m[LOOSE_FOR] > 0.0
    if loose:
        sigma += model.creep_loose
    grow = sigma * sigma * (1.0 - decay * decay)
    fresh = np.zeros(TRAVELS + w)  # noise that each of these rows gets for itself
    for i in range(w):
        a, b, c = axis[i, 0], axis[i, 1], axis[i, 2]
        rolled = (1.0 + s[K + i]) * (a * path_x + b * path_y + c * path_turn)
        s[phi + i] += rolled + T * s[creep + i]
        s[creep + i] *= decay
        row = TRAVELS + i
        F[row, VX] = a * even
        F[row, VY] = b * lateral * even
        F[row, BG] = -c * lever * even
        F[row, KG] = -c * lever * slow_turn
        F[row, KY] = b * slow_y
        F[row, KL] = c * slow_turn
        F[row, K + i] = a * slow_x + b * lateral * slow_y + c * lever * slow_turn
        F[row, phi + i] = 1.0
        F[row, creep + i] = even
        G[row, 0] = 0.5 * T * ra * a
        G[row, 1] = 0.5 * T * ra * b
        G[row, 2] = rg * c
        fresh[row] = micro * abs(rolled) + 1e-12
        if loose:
            memory.each[EXTRA, i] += model.extra_creep * model.rolling_noise ** 2 * abs(rolled)
    if memory.hinge.shape[0] > 0:
        motion = np.array([path_x, path_y, path_turn])
        memory.hinge[:] += hinge_increment(model.carriers, memory.hinge, motion)
    sensor = model.sensor_drift ** 2 * T
    drift = wander(model, memory) * T * trust + sensor
    fresh[ROW_BAX] = drift
    fresh[ROW_BAY] = drift
    transport(P, w, F, G @ G.T + np.diag(fresh), decay)
    P[BG, BG] += model.gyro_drift ** 2 * T
    for b, fixed in ((BAX, BSX), (BAY, BSY)):
        P[b, fixed] += sensor
        P[fixed, b] += sensor
        P[fixed, fixed] += sensor
    for i in range(creep, n):
        P[i, i] += grow
    for k in range(SUM_T, SUM_WY + 1):
        m[k] = 0.0


@kernel
def transport(P: FloatArray, wheels: int, F: FloatArray, noise: FloatArray, decay: float) -> None:
    """P <- F P F' + noise, for the rows of F that are neither those of I nor of creep."""
    phi, creep = K + wheels, K + 2 * wheels
    M = F @ P
    B = M @ F.T + noise
    B = 0.5 * (B + B.T)
    P[creep:, :] *= decay
    P[:, creep:] *= decay
    M[:, creep:] *= decay
    M[:, :ROW_BAX] = B[:, :ROW_BAX]
    M[:, BAX:BAY + 1] = B[:, ROW_BAX:TRAVELS]
    M[:, phi:creep] = B[:, TRAVELS:]
    P[:ROW_BAX] = M[:ROW_BAX]
    P[BAX:BAY + 1] = M[ROW_BAX:TRAVELS]
    P[phi:creep] = M[TRAVELS:]
    P[:, :ROW_BAX] = M[:ROW_BAX].T
    P[:, BAX:BAY + 1] = M[ROW_BAX:TRAVELS].T
    P[:, phi:creep] = M[TRAVELS:].T
