"""Slip speed of every wheel after a frame, and the way back when slip lasts.

    s_i = (z_i step - A_i twist T) / T      m/s along the roller axis, smoothed over 12 ms

A wheel may grip again only when its slip speed has stopped changing: constant common slip cannot
be told from rolling, so the slope of the slip speed decides, not its size. While a direction is
held by no gripping wheel, the velocity along it becomes uncertain like unmodelled tilt,
sigma = drift_apart * t; after ``patience`` seconds without any grip the accelerometer is trusted
less and less, until the wheels win again: no gate without a way back.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel
from mecanum_base.core.estimation.layout import (
    ANGLE,
    FLAT,
    FROZEN_FOR,
    GLIDING,
    KY,
    LATE,
    LOCKED_FOR,
    PENDING,
    PENDING_T,
    PROBABILITY,
    SIGMA,
    SLIP,
    SLOPE,
    SLOPE_AT,
    SLOPE_FILL,
    SLOW_AX,
    SLOW_AY,
    STEP,
    TRAVEL,
    VX,
    VY,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.wheel_update import rolling_speed
from mecanum_base.core.parameter import FloatArray

SMOOTHING = 0.012  # s
FROZEN_STEP = 0.25  # counts a wheel may move in a frame and be frozen
GLIDE_TIME = 4.0  # s of unchanging slip until it is doubted
GLIDE_PUSH = 0.4  # m/s^2, acceleration that sliding wheels do not follow by chance
GLIDE_SPEED = 0.1  # m/s gained beyond it with unchanging slip until that is doubted
GLIDE_RATE = 0.3  # s in which doubt reaches half the slip speed
UNHELD = 0.3  # share of a direction held by gripping wheels below which it counts as unheld


@kernel
def measure(model: Model, memory: Memory, z: FloatArray, valid: FloatArray, T: float) -> None:
    """Slip speed, slip travel and the slope ring from the step of travel (W,) over T [s]."""
    w = model.wheels
    wheel, m = memory.wheel, memory.m
    rolling = wheel[PENDING] + rolling_speed(memory, w) * T
    if m[LATE] > 0.5:  # the step belongs to another time: judge it with the next frame
        wheel[PENDING] = rolling
        m[PENDING_T] += T
        return
    T += float(m[PENDING_T])
    m[PENDING_T] = 0.0
    wheel[PENDING] = 0.0
    step = (z - wheel[TRAVEL]) * valid
    wheel[STEP] = step / T
    slid = (step - rolling) * valid
    gain = 1.0 - math.exp(-T / SMOOTHING)
    wheel[SLIP] += gain * (slid / T - wheel[SLIP])
    wheel[ANGLE] += slid
    wheel[TRAVEL] = np.where(valid > 0.0, z, wheel[TRAVEL] + rolling)
    held = (valid > 0.0) & (np.abs(step) < FROZEN_STEP * model.tick)
    wheel[FROZEN_FOR] = np.where(held, wheel[FROZEN_FOR] + T * (np.abs(rolling) > 0.05 * T), 0.0)


@kernel
def watch_slope(model: Model, memory: Memory) -> None:
    """Which wheels' slip speed has stopped changing: means over the last two spans of frames."""
    clock = memory.clock
    at = clock[SLOPE_AT]
    memory.slope[at] = memory.wheel[SLIP]
    clock[SLOPE_AT] = (at + 1) % (2 * SLOPE)
    clock[SLOPE_FILL] = min(clock[SLOPE_FILL] + 1, 2 * SLOPE)
    if memory.wheel[PROBABILITY].max() <= 0.5:
        memory.wheel[FLAT] = 1.0  # nobody slips: nothing to judge
        return
    if clock[SLOPE_FILL] < 2 * SLOPE:
        memory.wheel[FLAT] = 1.0
        return
    for i in range(model.wheels):
        old = new = 0.0
        for k in range(SLOPE):
            new += memory.slope[(at - k) % (2 * SLOPE), i]
            old += memory.slope[(at - SLOPE - k) % (2 * SLOPE), i]
        memory.wheel[FLAT, i] = 1.0 if abs(new - old) < SLOPE * model.flat_speed else 0.0


@kernel
def frictionless(memory: Memory, T: float) -> float:
    """Variance (m/s)^2 to add because the slip believed in does not change.

    Friction acts on wheels that slide and changes their slip; where wheels turn and all their
    slip speeds stay the same while the base moves on, it is the velocity that is wrong. Wheels
    that stand are left out: the hand that pushes such a base may balance the friction.
    """
    m, wheel = memory.m, memory.wheel
    slides = np.where(wheel[PROBABILITY] > 0.5, np.abs(wheel[SLIP]), 0.0)
    flat = np.where(wheel[PROBABILITY] > 0.5, wheel[FLAT], 1.0).min()
    turning = np.abs(wheel[STEP]).max() > 0.05
    if flat > 0.0 and turning and slides.max() > 0.1:
        push = math.hypot(float(m[SLOW_AX]), float(m[SLOW_AY]))
        m[GLIDING] += T / GLIDE_TIME + max(0.0, push - GLIDE_PUSH) * T / GLIDE_SPEED
    else:
        m[GLIDING] = 0.0
    if m[GLIDING] < 1.0:
        return 0.0
    return float((0.5 * slides.max()) ** 2 * T / GLIDE_RATE)


@kernel
def unlock(model: Model, memory: Memory, T: float) -> None:
    """Let the velocity grow uncertain along directions that no gripping wheel holds."""
    m, P = memory.m, memory.P
    xx = xy = yy = 0.0
    if memory.wheel[PROBABILITY].max() <= 0.5:
        m[LOCKED_FOR] = 0.0
        m[GLIDING] = 0.0
        return
    for i in range(model.wheels):
        share = 0.0 if memory.wheel[PROBABILITY, i] > 0.5 else 2.0 / model.wheels
        ax, ay = memory.rows[i, 0], memory.rows[i, 1]
        xx += share * ax * ax
        xy += share * ax * ay
        yy += share * ay * ay
    mean, half = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    if mean - half >= UNHELD:
        m[LOCKED_FOR] = 0.0
        m[GLIDING] = 0.0
        return
    m[LOCKED_FOR] += T
    t = float(m[LOCKED_FOR])
    grow = model.drift_apart ** 2 * t * T * 2.0 + frictionless(memory, T)
    if mean + half < UNHELD:
        P[VX, VX] += grow
        P[VY, VY] += grow
        return
    angle = 0.5 * math.atan2(2.0 * xy, xx - yy) + 0.5 * math.pi  # eigenvector of the smaller one
    ex, ey = math.cos(angle), math.sin(angle)
    P[VX, VX] += grow * ex * ex
    P[VX, VY] += grow * ex * ey
    P[VY, VX] += grow * ex * ey
    P[VY, VY] += grow * ey * ey


@kernel
def uncertainty(model: Model, memory: Memory) -> None:
    """Standard deviation (W,) m/s of each slip speed: sigma^2 = A_i P_v A_i' + (5 mm/s)^2."""
    x, P = memory.x, memory.P
    lateral = 1.0 + float(x[KY])
    ax, ay = memory.rows[:, 0], memory.rows[:, 1] * lateral
    memory.wheel[SIGMA] = np.sqrt(ax * ax * P[VX, VX] + 2.0 * ax * ay * P[VX, VY]
                                  + ay * ay * P[VY, VY] + 25e-6)
