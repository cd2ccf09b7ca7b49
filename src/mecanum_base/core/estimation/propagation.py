"""Covariance of the error over the motion since the last covariance step.

    P <- F P F' + G q G' + diag(Q)

F = I + (first-order derivative of the motion), with the sums of :mod:`.inertial` in place of
dt-times-rate, so that one step serves any number of IMU samples. The gyro is an input, not a
measurement: its noise enters along one vector d = (yaw 1, vx vy, vy -vx, phi_i A_i3) with exact
correlation, and no yaw-rate state is needed.

The columns of the scale errors use only what was known before this step (velocity at its start,
rates averaged over the time before, even steps in place of jittering stamps): what the step itself
brings carries the noise that the next residual shows, and that product would pull every scale the
same way, a little each step. Without a gyro the spare equation of the wheels cannot tell a radius
from a lever or from slip: then travel does not depend on the scales, so that no doubt of theirs
weighs the wheels, and a scale error of wheel i moves the pose instead, by -R A+ e_i rolled_i.

A wheel that grips and pulls creeps: it turns farther than it rolls, in proportion to traction over
load (linear creep of an elastic roller; Canudas de Wit & Tsiotras 1999 in the steady state),

    s_i = c |v| F_i/N_i,    F_i/N_i = W/g (A+' f)_i,    f = a + o - b

with the same load N_i = m g/W on every wheel and the smallest forces F that add up to m f without
a moment. f is what the accelerometer feels less its own part b of the offset o: on a slope wheels
pull without any acceleration a, and a third of a per cent of the way is lost to one side.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel
from mecanum_base.core.estimation.doubt import doubt_velocity
from mecanum_base.core.estimation.geometry import hinge_increment
from mecanum_base.core.estimation.layout import (
    ALL_SLID,
    BAX,
    BAY,
    BG,
    BSX,
    BSY,
    CREEPS,
    EVEN_AX,
    EVEN_AY,
    EXTRA,
    HAVE_ACCEL,
    HAVE_GYRO,
    KAX,
    KAY,
    KG,
    KL,
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
from mecanum_base.core.estimation.lean import GRAVITY, wander
from mecanum_base.core.estimation.model import Model

# times the noise learnt from the differences of the accelerometer: floor and contacts add to it.
# Where all wheels slide there are no such contacts, but there doubt of the velocity is the only
# way back from a wrong one: up to the second factor it is doubted besides
SHAKEN, SLIDING, SLIDING_MOST = 1.5, 1.1, 2.4
# traction that makes gripping wheels creep: a knock is none, nor is what no wheel can give
EVEN_TIME = 0.1  # s
KNOCK, LASTING, HARDEST = 0.7, 1.5, 3.0  # m/s^2, times the even acceleration, m/s^2
# a wheel that stands while its rollers roll over the floor errs as one that turns
ACROSS = 0.7  # of the base's way, which is what each wheel turns when it drives straight on


@kernel
def spread(model: Model, memory: Memory) -> None:
    """Bring travel and covariance up to the mean and start new sums."""
    m, s, axis = memory.m, memory.s, memory.axis
    T = m[SUM_T]
    if T <= 0.0:
        return
    w = model.wheels
    phi, creep, side, n = K + w, K + 2 * w, K + 3 * w, K + 4 * w
    turn = m[SUM_YAW]
    lever = 1.0 + s[KL]
    path_x, path_y, path_turn = m[SUM_X], m[SUM_Y], lever * turn
    decay = math.exp(-T / model.creep_time)
    even = T * m[STRETCH]  # s, without the jitter of the stamps
    slow_turn, slow_x, slow_y = m[SLOW_W] * even, m[SLOW_VX] * even, m[SLOW_VY] * even
    push_x, push_y = m[SUM_VX], m[SUM_VY]
    end_x, end_y = s[VX], s[VY]
    vx, vy = end_x - push_x - turn * end_y, end_y - push_y + turn * end_x  # at its start
    ax, ay = m[SLOW_AX], m[SLOW_AY]
    yaw = s[YAW] - 0.5 * turn
    cos, sin = math.cos(yaw), math.sin(yaw)
    F = model.unit.copy()
    F[YAW, BG] = -T
    F[YAW, KG] = -slow_turn
    F[PX, YAW] = -m[SUM_WY]
    F[PX, VX] = cos * T
    F[PX, VY] = -sin * T
    F[PY, YAW] = m[SUM_WX]
    F[PY, VX] = sin * T
    F[PY, VY] = cos * T
    F[VX, VY] = turn
    F[VX, BG] = -vy * T
    F[VX, KG] = -vy * slow_turn
    F[VX, BAX] = -T
    F[VX, KAX] = -ax * T
    F[VY, VX] = -turn
    F[VY, BG] = vx * T
    F[VY, KG] = vx * slow_turn
    F[VY, BAY] = -T
    F[VY, KAY] = -ay * T
    F[BAX, BAY] = turn
    F[BAX, BSY] = -turn
    F[BAY, BAX] = -turn
    F[BAY, BSX] = turn

    blind = m[HAVE_GYRO] == 0.0
    if blind:
        F[YAW, KL] = -slow_turn
    speed = min(1.5, math.hypot(end_x, end_y) + 0.2 * abs(turn) / T)
    share = T / (T + model.traction_time)
    ax += share * (push_x / T - ax)
    ay += share * (push_y / T - ay)
    m[SLOW_AX], m[SLOW_AY] = ax, ay
    share = T / (T + model.scale_time)
    m[SLOW_W] += share * (turn / T - m[SLOW_W])
    m[SLOW_VX] += share * (vx - m[SLOW_VX])
    m[SLOW_VY] += share * (vy - m[SLOW_VY])
    share = T / (T + EVEN_TIME)
    m[EVEN_AX] += share * (ax - m[EVEN_AX])
    m[EVEN_AY] += share * (ay - m[EVEN_AY])
    push = min(math.hypot(ax, ay), HARDEST,
               KNOCK + LASTING * math.hypot(m[EVEN_AX], m[EVEN_AY]))
    trust = 1.0
    if m[LOCKED_FOR] > model.patience:
        trust += 400.0 * (m[LOCKED_FOR] - model.patience)
    if m[HAVE_GYRO] > 0.0:
        qg = T * max(model.gyro_noise ** 2 + (model.gyro_shake * speed) ** 2, 1.5 * m[TREMOR])
    else:
        qg = (model.blind_turn * T) ** 2
    if m[HAVE_ACCEL] > 0.0:
        shaken = SHAKEN
        if m[ALL_SLID] > 0.0:
            shaken = SLIDING
            more = (SLIDING_MOST - SLIDING) * m[SHAKE] * T
            doubt_velocity(memory, more, 0.0, more)
        qa = trust * max(model.accel_noise ** 2 + (model.accel_shake * speed) ** 2,
                         shaken * m[SHAKE]) * T
    else:
        qa = model.blind_push ** 2 * T
    rg, ra = math.sqrt(qg), math.sqrt(qa)
    G = np.zeros((n, 3))
    half = 0.5 * T * ra
    G[YAW, 2] = rg
    G[VX, 0] = ra
    G[VX, 2] = vy * rg
    G[VY, 1] = ra
    G[VY, 2] = -vx * rg
    if m[HAVE_ACCEL] == 0.0:  # of a measured one it is less than a hundredth of a millimetre
        G[PX, 0], G[PX, 1] = half * cos, -half * sin
        G[PY, 0], G[PY, 1] = half * sin, half * cos

    share = model.creep_steady * w * math.hypot(path_x, path_y) / GRAVITY
    drag_x = share * (m[EVEN_AX] + s[BAX] - s[BSX])
    drag_y = share * (m[EVEN_AY] + s[BAY] - s[BSY])
    micro = model.rolling_noise ** 2 + model.traction_noise ** 2 * push
    sigma = model.creep_traction * push + model.creep_hard * push * push
    m[CREEPS] = model.creep_limit
    if m[HAVE_ACCEL] > 0.0:
        m[CREEPS] = min(model.creep_limit, model.creep_least + model.creep_sigmas * sigma)
    loose = m[LOOSE_FOR] > 0.0
    grow = sigma * sigma * (1.0 - decay * decay)
    size = np.empty(w)
    least = ACROSS * math.hypot(path_x, path_y)
    for i in range(w):
        a, b, c = axis[i, 0], axis[i, 1], axis[i, 2]
        slow, row = s[creep + i], phi + i
        gain = b * (1.0 + s[side + i])
        rolled = (1.0 + s[K + i]) * (a * path_x + gain * path_y + c * path_turn)
        size[i] = max(abs(rolled), least)
        s[row] += (rolled + T * slow
                   + model.inverse[0, i] * drag_x + model.inverse[1, i] * drag_y)
        s[creep + i] = decay * slow
        c_lever = c * lever
        F[row, VX] = a * even
        F[row, VY] = gain * even
        F[row, BG] = -c_lever * even
        F[row, KG] = -c_lever * slow_turn
        taken, sideways = a * slow_x + gain * slow_y + c_lever * slow_turn, b * slow_y
        if blind:
            x, y = -model.inverse[0, i], -model.inverse[1, i]
            for k, moved in ((K + i, taken), (side + i, sideways)):
                F[PX, k] = moved * (cos * x - sin * y)
                F[PY, k] = moved * (sin * x + cos * y)
                F[YAW, k] = -moved * model.inverse[2, i]
        else:
            F[row, KL] = c * slow_turn
            F[row, K + i] = taken
            F[row, side + i] = sideways
        F[row, creep + i] = even
        F[creep + i, creep + i] = decay
        G[row, 0] = half * a
        G[row, 1] = half * b
        G[row, 2] = rg * c
    if memory.hinge.shape[0] > 0:
        motion = np.array([path_x, path_y, path_turn])
        memory.hinge[:] += hinge_increment(model.carriers, memory.hinge, motion)
    P = memory.P
    P[:, :] = F @ P @ F.T + G @ G.T
    tilt = wander(model, memory) * T * trust
    sensor = model.sensor_drift ** 2 * T
    P[BG, BG] += model.gyro_drift ** 2 * T
    for b, fixed in ((BAX, BSX), (BAY, BSY)):
        P[b, b] += tilt + sensor
        P[b, fixed] += sensor
        P[fixed, b] += sensor
        P[fixed, fixed] += sensor
    for i in range(w):
        P[phi + i, phi + i] += micro * size[i] + 1e-12
        P[creep + i, creep + i] += grow
        if loose:
            memory.each[EXTRA, i] += model.extra_creep * model.rolling_noise ** 2 * size[i]
    for k in range(SUM_T, SUM_WY + 1):
        m[k] = 0.0
