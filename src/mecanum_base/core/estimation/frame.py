"""One IMU reading, one encoder frame, one prediction: the table of contents of the filter."""

from __future__ import annotations

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel
from mecanum_base.core.estimation.geometry import carrier_rows
from mecanum_base.core.estimation.inertial import carry, read_imu
from mecanum_base.core.estimation.layout import (
    HAVE_ACCEL,
    HAVE_GYRO,
    LAST_FRAME,
    LAST_IMU,
    LAST_YAW,
    NOW,
    PERIOD,
    QUIET,
    REST,
    SLIP,
    STILL,
    STRETCH,
    SUM_T,
    TRAVEL,
    WZ,
    YAW,
    K,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.propagation import spread
from mecanum_base.core.estimation.slip import measure, uncertainty, unlock, watch_slope
from mecanum_base.core.estimation.standstill import leave, watch
from mecanum_base.core.estimation.wheel_update import judge
from mecanum_base.core.parameter import FloatArray

EVEN = 0.2  # share of the period that a stamp may be off and still be jitter
LONGEST = 0.025  # s, longest motion that one covariance step may cover


@kernel
def take_imu(model: Model, memory: Memory, now: int, gyro: float, ax: float, ay: float) -> None:
    """Use one IMU reading in base axes (gyro z, specific force x, y; NaN = missing)."""
    dt = min((now - memory.clock[LAST_IMU]) * 1e-9, model.imu_gap)
    if memory.m[HAVE_GYRO] == 0.0 or memory.m[HAVE_ACCEL] == 0.0:
        carry(model, memory, now)
        spread(model, memory)  # noise of the blind time belongs to what is past
    read_imu(model, memory, now, gyro, ax, ay)
    watch(model, memory, gyro, ax, ay, dt)
    if memory.m[SUM_T] > LONGEST:
        spread(model, memory)


@kernel
def predict(model: Model, memory: Memory, now: int) -> None:
    """Carry state and covariance to ``now`` without a reading; a silent IMU is noticed here."""
    m, clock = memory.m, memory.clock
    if m[HAVE_GYRO] > 0.0 or m[HAVE_ACCEL] > 0.0:
        silent = (now - clock[LAST_IMU]) * 1e-9
        if silent > model.imu_gap:
            spread(model, memory)
            m[HAVE_GYRO] = 0.0
            m[HAVE_ACCEL] = 0.0
            if m[STILL] > 0.0:
                leave(memory)
    while (now - clock[NOW]) * 1e-9 > LONGEST and m[STILL] == 0.0:
        carry(model, memory, clock[NOW] + 20_000_000)
        spread(model, memory)
    carry(model, memory, now)
    spread(model, memory)


@kernel
def evened(memory: Memory, T: float) -> float:
    """Time since the last frame [s] without stamp jitter, where frames come at a steady rate."""
    m = memory.m
    period = float(m[PERIOD])
    if period == 0.0:
        m[PERIOD] = T
        return T
    m[PERIOD] += 0.02 * min(max(T - period, -0.1 * period), 0.1 * period)
    whole = period * float(round(T / period))
    return whole if abs(T - whole) < EVEN * period else T


@kernel
def take_frame(model: Model, memory: Memory, now: int, z: FloatArray, valid: FloatArray) -> None:
    """Use the travel z (W,) m of one encoder frame; ``valid`` (W,) is 1 where it is known."""
    m, clock, wheel = memory.m, memory.clock, memory.wheel
    T = (now - clock[LAST_FRAME]) * 1e-9
    m[STRETCH] = evened(memory, T) / T
    predict(model, memory, now)
    m[STRETCH] = 1.0
    clock[LAST_FRAME] = now
    moved = False
    for i in range(model.wheels):
        if valid[i] > 0.0 and abs(z[i] - wheel[REST, i]) > model.rest_counts * model.tick[i]:
            moved = True
    if moved:
        wheel[REST] = np.where(valid > 0.0, z, wheel[REST])
        m[QUIET] = 0.0
        if m[STILL] > 0.0:
            leave(memory)
    else:
        m[QUIET] += T
    if m[STILL] > 0.0:
        wheel[TRAVEL] = np.where(valid > 0.0, z, wheel[TRAVEL])
        wheel[SLIP] = 0.0
        m[LAST_YAW] = memory.x[YAW]
        return
    judge(model, memory, z, valid, T)
    if m[HAVE_GYRO] == 0.0 and T > 0.0:
        m[WZ] = (memory.x[YAW] - m[LAST_YAW]) / T
    m[LAST_YAW] = memory.x[YAW]
    if memory.hinge.shape[0] > 0:
        memory.rows[:, :] = carrier_rows(model.carriers, memory.hinge)
    measure(model, memory, z, valid, T)
    watch_slope(model, memory)
    unlock(model, memory, T)
    uncertainty(model, memory)


@kernel
def arm(model: Model, memory: Memory, now: int, z: FloatArray) -> None:
    """The first frame: every wheel starts from its present travel z (W,) m."""
    w = model.wheels
    memory.clock[LAST_FRAME] = now
    memory.x[K + w:K + 2 * w] = z
    memory.wheel[TRAVEL] = z
    memory.wheel[REST] = z
    memory.m[LAST_YAW] = memory.x[YAW]


@kernel
def anchor(model: Model, memory: Memory, i: int, z: float) -> None:
    """Forget what wheel i has travelled before: its travel is z from now on."""
    row = K + model.wheels + i
    memory.P[row, :] = 0.0
    memory.P[:, row] = 0.0
    memory.P[row, row] = model.resolution[i] ** 2
    memory.x[row] = z
    memory.wheel[TRAVEL, i] = z
    memory.wheel[REST, i] = z
