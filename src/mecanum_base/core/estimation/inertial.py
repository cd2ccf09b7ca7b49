"""Mean of the state between encoder frames, driven by gyro and accelerometer.

    wz = (gyro - bg)/(1 + kg)        a = (acc - ba)/(1 + ka) + w^2 l + (w' ly, -w' lx)
    v' = a - wz z x v                pose' = Exp over the step of (v + dv/2, wz)

    l = (lx, ly) lever arm of the IMU [m]; w' l telescopes to the change of wz between samples.

Between two IMU samples the state is carried with the older one held; when the newer one arrives
the rest of the interval is chosen so that the whole interval integrates the mean of both
(trapezoid): nothing is lost and nothing looks into the future. Sums of the motion since the last
covariance step are kept for :mod:`.propagation`. Roll and pitch are not modelled: gravity leaking
into x and y is part of the accelerometer bias.

The noise density of the accelerometer, vibration included, is learnt from second differences of
successive readings dt apart, mean over x and y of (a_k - 2 a_k-1 + a_k-2)^2 dt / 6, (m/s^2)^2/Hz:
white noise counts whole, and what the base truly does, which the integral needs, for little.
"""

from __future__ import annotations

import math

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.layout import (
    ACC_X,
    ACC_Y,
    BAX,
    BAY,
    BG,
    DONE_AX,
    DONE_AY,
    DONE_GYRO,
    GYRO,
    HAVE_ACCEL,
    HAVE_GYRO,
    JUMP_X,
    JUMP_Y,
    KAX,
    KAY,
    KG,
    LAST_IMU,
    NOW,
    PX,
    PY,
    SHAKE,
    STILL,
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
    WZ,
    YAW,
    Memory,
)
from mecanum_base.core.estimation.lean import turn_offset
from mecanum_base.core.estimation.model import Model

_SERIES = 1e-4  # rad; below it the series is exact to rounding
_SHAKE_TIME = 0.25  # s over which vibration is averaged


@part
def move(memory: Memory, turn: float, push_x: float, push_y: float, dt: float) -> None:
    """Carry pose and velocity by ``dt`` [s]: yaw increment [rad], specific velocity [m/s]."""
    s, m = memory.s, memory.m
    vx, vy, yaw = s[VX], s[VY], s[YAW]
    dvx, dvy = push_x + turn * vy, push_y - turn * vx
    path_x, path_y = (vx + 0.5 * dvx) * dt, (vy + 0.5 * dvy) * dt
    if -_SERIES < turn < _SERIES:
        along, across = 1.0 - turn * turn / 6.0, 0.5 * turn
    else:
        along, across = math.sin(turn) / turn, (1.0 - math.cos(turn)) / turn
    cos, sin = math.cos(yaw), math.sin(yaw)
    bx, by = along * path_x - across * path_y, across * path_x + along * path_y
    wx, wy = cos * bx - sin * by, sin * bx + cos * by
    s[PX] += wx
    s[PY] += wy
    s[YAW] = yaw + turn
    s[VX] = vx + dvx
    s[VY] = vy + dvy
    turn_offset(memory, turn)
    m[SUM_T] += dt
    m[SUM_X] += path_x
    m[SUM_Y] += path_y
    m[SUM_YAW] += turn
    m[SUM_VX] += push_x
    m[SUM_VY] += push_y
    m[SUM_WX] += wx
    m[SUM_WY] += wy


@kernel
def carry(model: Model, memory: Memory, now: int) -> None:
    """Carry the mean to stamp ``now`` with the last IMU reading held (nothing if it is past)."""
    m, clock = memory.m, memory.clock
    dt = (now - clock[NOW]) * 1e-9
    if dt <= 0.0:
        return
    clock[NOW] = now
    if m[STILL] > 0.0:
        return
    s = memory.s
    if m[HAVE_GYRO] > 0.0:
        raw = m[GYRO] * dt
        m[DONE_GYRO] += raw
        turn = (raw - s[BG] * dt) / (1.0 + s[KG])
        m[WZ] = turn / dt
    else:
        turn = m[WZ] * dt
    push_x = push_y = 0.0
    if m[HAVE_ACCEL] > 0.0:
        raw_x, raw_y = m[ACC_X] * dt, m[ACC_Y] * dt
        m[DONE_AX] += raw_x
        m[DONE_AY] += raw_y
        push_x = (raw_x - s[BAX] * dt) / (1.0 + s[KAX])
        push_y = (raw_y - s[BAY] * dt) / (1.0 + s[KAY])
    move(memory, turn, push_x, push_y, dt)


@part
def read_imu(model: Model, memory: Memory, now: int, gyro: float, ax: float, ay: float) -> None:
    """Take the IMU reading of stamp ``now``: gyro z and specific force x, y in base axes.

    NaN means that this axis is missing. The state is carried to ``now``.
    """
    s, m, clock = memory.s, memory.m, memory.clock
    has_gyro, has_accel = gyro == gyro, ax == ax and ay == ay  # only NaN differs from itself
    moving = m[STILL] == 0.0
    span = (now - clock[LAST_IMU]) * 1e-9
    rest = (now - clock[NOW]) * 1e-9
    whole = moving and span <= model.imu_gap and rest > 0.0
    both_gyro = whole and has_gyro and m[HAVE_GYRO] > 0.0
    both_accel = whole and has_accel and m[HAVE_ACCEL] > 0.0
    if both_gyro or both_accel:
        wz = m[WZ]
        turn = wz * rest
        change = 0.0
        if both_gyro:
            old = m[GYRO]
            scale = 1.0 + s[KG]
            turn = (0.5 * (old + gyro) * span - m[DONE_GYRO] - s[BG] * rest) / scale
            change = (gyro - old) / scale
            tremor = m[TREMOR]
            m[TREMOR] = tremor + ((0.5 * (gyro - old) * (gyro - old) * span - tremor) * span
                                  / _SHAKE_TIME)
        push_x = push_y = 0.0
        if both_accel:
            old_x, old_y = m[ACC_X], m[ACC_Y]
            spin = wz * wz * span
            push_x = ((0.5 * (old_x + ax) * span - m[DONE_AX] - s[BAX] * rest) / (1.0 + s[KAX])
                      + spin * model.lever_x + change * model.lever_y)
            push_y = ((0.5 * (old_y + ay) * span - m[DONE_AY] - s[BAY] * rest) / (1.0 + s[KAY])
                      + spin * model.lever_y - change * model.lever_x)
            jump_x, jump_y, shake = ax - old_x, ay - old_y, m[SHAKE]
            bend_x, bend_y = jump_x - m[JUMP_X], jump_y - m[JUMP_Y]
            m[JUMP_X], m[JUMP_Y] = jump_x, jump_y
            seen = (bend_x * bend_x + bend_y * bend_y) * span / 12.0
            most = 8.0 * shake + model.accel_noise * model.accel_noise  # a knock is no vibration
            m[SHAKE] = shake + ((most if seen > most else seen) - shake) * span / _SHAKE_TIME
        clock[NOW] = now
        move(memory, turn, push_x, push_y, rest)
    else:
        carry(model, memory, now)
    clock[LAST_IMU] = now
    m[DONE_GYRO] = 0.0
    m[DONE_AX] = 0.0
    m[DONE_AY] = 0.0
    m[HAVE_GYRO] = 1.0 if has_gyro else 0.0
    m[HAVE_ACCEL] = 1.0 if has_accel else 0.0
    if has_gyro:
        m[GYRO] = gyro
        if moving:
            m[WZ] = (gyro - s[BG]) / (1.0 + s[KG])
    if has_accel:
        m[ACC_X] = ax
        m[ACC_Y] = ay
