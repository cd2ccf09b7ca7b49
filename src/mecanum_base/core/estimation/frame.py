"""One IMU reading, one encoder frame, one prediction: the table of contents of the filter."""

from __future__ import annotations

import math

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.geometry import carrier_rows
from mecanum_base.core.estimation.hindsight import (
    account,
    corrected,
    slipping_set,
    wait,
)
from mecanum_base.core.estimation.inertial import carry, read_imu
from mecanum_base.core.estimation.layout import (
    CALM,
    CARRIED,
    FORCED,
    HAVE_ACCEL,
    HAVE_GYRO,
    JUDGED,
    KL,
    LAST_FRAME,
    LAST_IMU,
    LAST_YAW,
    LATE,
    LOOSE_FOR,
    NOW,
    PERIOD,
    QUIET,
    REACH,
    REST,
    SLIP,
    SLOW_AX,
    SLOW_AY,
    STILL,
    STRETCH,
    SUM_T,
    SUM_X,
    SUM_Y,
    SUM_YAW,
    TRAVEL,
    WZ,
    YAW,
    K,
    Memory,
)
from mecanum_base.core.estimation.lean import follow
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.obstacle import stop_at_obstacle
from mecanum_base.core.estimation.propagation import spread
from mecanum_base.core.estimation.regrip import watch_regrip
from mecanum_base.core.estimation.slip import measure, uncertainty, unlock, watch_slope
from mecanum_base.core.estimation.standstill import leave, watch
from mecanum_base.core.estimation.trail import expect
from mecanum_base.core.estimation.wheel_update import SURE, judge
from mecanum_base.core.parameter import FloatArray

EVEN = 0.2  # share of the period that a stamp may be off and still be jitter
LONGEST = 0.04  # s, longest motion that one covariance step may cover


@kernel
def step_imu(model: Model, memory: Memory, now: int, gyro: float, ax: float, ay: float,
             roll: float, pitch: float) -> None:
    """Use one IMU reading in base axes: gyro z, specific force x, y, gyro x, y; NaN = missing."""
    m = memory.m
    dt = min((now - memory.clock[LAST_IMU]) * 1e-9, model.imu_gap)
    if m[HAVE_GYRO] == 0.0 or m[HAVE_ACCEL] == 0.0:
        carry(model, memory, now)
        spread(model, memory)  # noise of the blind time belongs to what is past
    read_imu(model, memory, now, gyro, ax, ay)
    if m[STILL] == 0.0:
        follow(memory, roll, pitch, dt)
    watch(model, memory, gyro, ax, ay, roll, pitch, dt)
    if m[SUM_T] > LONGEST:
        spread(model, memory)


@kernel
def predict(model: Model, memory: Memory, now: int) -> None:
    """Carry state and covariance to ``now`` without a reading; a silent IMU is noticed here."""
    m, clock = memory.m, memory.clock
    m[CARRIED] = 0.0
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


@part
def evened(memory: Memory, step: float, span: float) -> float:
    """``span`` [s] without stamp jitter, where frames come at a steady rate of about ``step``."""
    m = memory.m
    period = m[PERIOD]
    if period == 0.0:
        m[PERIOD] = step
        return span
    m[PERIOD] = period + 0.02 * min(max(step - period, -0.1 * period), 0.1 * period)
    whole = period * float(round(span / period))
    return whole if abs(span - whole) < EVEN * period else span


@part
def allow_calm(model: Model, memory: Memory) -> None:
    """May the frames to come be calm? All wheels grip, for some time, and none is forced."""
    m, each = memory.m, memory.each
    m[CALM] = 0.0
    if (memory.mode[0] < SURE or m[LOOSE_FOR] > 0.0 or m[LATE] > 0.5
            or memory.hinge.shape[0] > 0):
        return
    for i in range(model.wheels):
        if each[FORCED, i] > 0.0 or abs(each[SLIP, i]) > model.calm_slip:
            return
    m[CALM] = 1.0


@part
def calm(model: Model, memory: Memory, z: FloatArray, valid: FloatArray, span: float) -> bool:
    """True where a frame says nothing new: all grip, hardly any traction, small residuals.

    Travel is cumulative, so a frame that is passed over loses nothing: the next one carries it.
    """
    m, s, axis, w = memory.m, memory.s, memory.axis, model.wheels
    if (span >= model.calm_span or m[CALM] == 0.0
            or abs(m[SLOW_AX]) + abs(m[SLOW_AY]) > model.calm_push
            or m[HAVE_GYRO] == 0.0 or m[HAVE_ACCEL] == 0.0):
        return False
    along, lateral, lever = m[SUM_X], m[SUM_Y], (1.0 + s[KL]) * m[SUM_YAW]
    for i in range(w):
        gain = axis[i, 1] * (1.0 + s[K + 3 * w + i])
        rolled = axis[i, 0] * along + gain * lateral + axis[i, 2] * lever
        r = z[i] - s[K + w + i] - (1.0 + s[K + i]) * rolled
        if not (valid[i] > 0.0 and abs(r) < memory.each[REACH, i]):
            return False
    return True


@part
def still(model: Model, memory: Memory, z: FloatArray, valid: FloatArray, step: float) -> bool:
    """Do the wheels keep their place? Ends a standstill where they do not; True while it lasts."""
    m, each = memory.m, memory.each
    moved = False
    for i in range(model.wheels):
        if valid[i] > 0.0 and abs(z[i] - each[REST, i]) > model.rest_travel[i]:
            moved = True
            break
    if moved:
        for i in range(model.wheels):
            if valid[i] > 0.0:
                each[REST, i] = z[i]
        m[QUIET] = 0.0
        if m[STILL] > 0.0:
            leave(memory)
    else:
        m[QUIET] += step
    if m[STILL] == 0.0:
        return False
    for i in range(model.wheels):
        if valid[i] > 0.0:
            each[TRAVEL, i] = z[i]
        each[SLIP, i] = 0.0
    m[LAST_YAW] = memory.s[YAW]
    return True


@kernel
def step_frame(model: Model, memory: Memory, now: int, z: FloatArray, valid: FloatArray) -> bool:
    """One frame without a second look; True where a wheel begins to slip."""
    m, clock = memory.m, memory.clock
    step = (now - clock[LAST_FRAME]) * 1e-9
    span = (now - clock[JUDGED]) * 1e-9
    lost = (now - clock[LAST_IMU]) * 1e-9 > model.imu_gap
    clock[LAST_FRAME] = now
    m[STRETCH] = evened(memory, step, span) / span
    if not lost:
        carry(model, memory, now)
        if m[STILL] == 0.0 and calm(model, memory, z, valid, span):
            still(model, memory, z, valid, step)
            m[CARRIED] = 1.0
            return False
    predict(model, memory, now)
    m[STRETCH] = 1.0
    clock[JUDGED] = now
    if still(model, memory, z, valid, step):
        wait(memory, span)
        return False
    before = slipping_set(memory, model.wheels)
    px, py, yaw, vx, vy, bx, by = corrected(memory)
    expect(memory)
    judge(model, memory, z, valid, span)
    account(memory, span, px, py, yaw, vx, vy, bx, by)
    if m[HAVE_GYRO] == 0.0:
        m[WZ] = (memory.s[YAW] - m[LAST_YAW]) / span
    m[LAST_YAW] = memory.s[YAW]
    if memory.hinge.shape[0] > 0:
        memory.rows[:, :] = carrier_rows(model.carriers, memory.hinge)
    measure(model, memory, z, valid, span)
    watch_slope(model, memory)
    unlock(model, memory, span)
    watch_regrip(model, memory, span)
    stop_at_obstacle(model, memory, span)
    uncertainty(model, memory)
    allow_calm(model, memory)
    return (slipping_set(memory, model.wheels) & ~before) != 0


@part
def sound(memory: Memory) -> bool:
    """Is every number of the state finite and every variance positive?

    What is not finite in the covariance reaches its diagonal with the next step.
    """
    x, variance = memory.x, memory.variance
    return bool(math.isfinite(x @ x + variance.sum()) and variance.min() > -1e-12)


@kernel
def arm(model: Model, memory: Memory, now: int, z: FloatArray) -> None:
    """The first frame: every wheel starts from its present travel z (W,) m."""
    w = model.wheels
    memory.clock[LAST_FRAME] = now
    memory.clock[JUDGED] = now
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
