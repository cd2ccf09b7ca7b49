"""Slip speed of every wheel after a frame, and the way back when slip lasts.

    s_i = (z_i step - A_i twist T) / T      m/s along the roller axis, smoothed over 12 ms

A wheel may grip again only when its slip speed has stopped changing: constant common slip cannot
be told from rolling, so the slope of the slip speed decides, not its size. Where the slip of a
diagonal has come slowly and has not changed at once since by as much as it is, it must besides be
within the doubt of the velocity (:mod:`.wheel_update`). While a direction is held by no gripping
wheel, the velocity along it is doubted like unmodelled tilt, sigma = drift_apart * t
(:mod:`.doubt`). Slip that stays the same for long, or whatever the wheels do
(:mod:`.indifference`), is taken for an error of the velocity. After ``patience`` seconds without
any grip the accelerometer is trusted less and less, until the wheels win again: no gate without a
way back.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.doubt import (
    doubt_held,
    doubt_velocity,
    forget_doubt,
    velocity_covariance,
    wrong_along_slip,
)
from mecanum_base.core.estimation.indifference import follows
from mecanum_base.core.estimation.layout import (
    ANGLE,
    CHANGE,
    FLAT,
    FROZEN_FOR,
    GLIDING,
    KL,
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
    WZ,
    K,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.obstacle import held
from mecanum_base.core.parameter import FloatArray

SMOOTHING = 0.012  # s
DOUBTED = 0.2  # probability of a late stamp above which a step says nothing of slip yet
FROZEN_STEP = 0.25  # counts a wheel may move in a frame and be frozen
GLIDE_TIME = 4.0  # s of unchanging slip until it is doubted
GLIDE_PUSH = 0.4  # m/s^2 of it that is not noticed
GLIDE_SPEED = 0.1  # m/s gained beyond it with unchanging slip until that is doubted
GLIDE_DOUBT = 1.2  # s in which doubt reaches the slip speed
FOLLOW_DOUBT = 0.05  # s of it where the base follows its wheels
KINK = 3  # frames averaged on either side to see that a change has just ended
KINK_BEFORE = 0.1  # m/s of change between the long means
KINK_AFTER = 0.02  # m/s of change between the short means that counts as none
KINK_SLIP = 0.15  # m/s of slip that may be an error of the velocity
UNHELD = 0.3  # share of a direction held by gripping wheels below which it counts as unheld


@part
def measure(model: Model, memory: Memory, z: FloatArray, valid: FloatArray, T: float) -> None:
    """Slip speed, slip travel and the slope ring from the step of travel (W,) over T [s]."""
    m, s, each, axis = memory.m, memory.s, memory.each, memory.axis
    late = m[LATE] > DOUBTED
    waited = m[PENDING_T]
    m[PENDING_T] = waited + T if late else 0.0
    side = K + 3 * model.wheels
    vx, vy, wz = s[VX], s[VY], (1.0 + s[KL]) * m[WZ]
    whole = waited + T
    gain = 1.0 - math.exp(-whole / SMOOTHING)
    for i in range(model.wheels):
        lateral = axis[i, 1] * (1.0 + s[side + i]) * vy
        speed = (1.0 + s[K + i]) * (axis[i, 0] * vx + lateral + axis[i, 2] * wz)
        rolling = each[PENDING, i] + speed * T
        if late:  # the step belongs to another time: judge it with the next frame
            each[PENDING, i] = rolling
            continue
        each[PENDING, i] = 0.0
        if valid[i] == 0.0:
            step = slid = 0.0
            each[TRAVEL, i] += rolling
            each[FROZEN_FOR, i] = 0.0
        else:
            step = z[i] - each[TRAVEL, i]
            slid = step - rolling
            each[TRAVEL, i] = z[i]
            if abs(step) >= FROZEN_STEP * model.tick[i]:
                each[FROZEN_FOR, i] = 0.0
            elif abs(rolling) > 0.05 * whole:
                each[FROZEN_FOR, i] += whole
        each[STEP, i] = step / whole
        each[SLIP, i] += gain * (slid / whole - each[SLIP, i])
        each[ANGLE, i] += slid


@part
def watch_slope(model: Model, memory: Memory) -> None:
    """Which wheels' slip speed has stopped changing: means over the last two spans of frames.

    FLAT of a wheel: 1 has not changed for long, 0.5 changed by much and has just stopped near zero
    (it may grip again, but nothing else follows from it), 0 changes.
    """
    clock = memory.clock
    at, each = clock[SLOPE_AT], memory.each
    slips = False
    for i in range(model.wheels):
        memory.slope[at, i] = each[SLIP, i]
        slips = slips or each[PROBABILITY, i] > 0.5
    clock[SLOPE_AT] = (at + 1) % (2 * SLOPE)
    clock[SLOPE_FILL] = min(clock[SLOPE_FILL] + 1, 2 * SLOPE)
    if not slips or clock[SLOPE_FILL] < 2 * SLOPE:  # nobody slips: nothing to judge
        for i in range(model.wheels):
            each[FLAT, i] = 1.0
        return
    for i in range(model.wheels):
        old = new = 0.0
        for k in range(SLOPE):
            new += memory.slope[(at - k) % (2 * SLOPE), i]
            old += memory.slope[(at - SLOPE - k) % (2 * SLOPE), i]
        change = abs(new - old) / SLOPE
        each[CHANGE, i] = change
        if change < model.flat_speed:
            each[FLAT, i] = 1.0
            continue
        lately = 0.0
        for k in range(KINK):
            lately += memory.slope[(at - k) % (2 * SLOPE), i]
            lately -= memory.slope[(at - KINK - k) % (2 * SLOPE), i]
        sudden = (change > KINK_BEFORE and abs(lately) < KINK * KINK_AFTER
                  and abs(each[SLIP, i]) < KINK_SLIP)
        each[FLAT, i] = 0.5 if sudden else 0.0


@part
def unfelt(memory: Memory) -> float:
    """Acceleration [m/s^2] that sliding wheels do not follow by chance, nor cause by friction.

    Friction pushes the base along the slip. Across it the rollers of a diagonal roll freely; only
    where all wheels slide, their slip would have to change with it.
    """
    m, each = memory.m, memory.each
    x = y = 0.0
    everything = True
    for i in range(memory.axis.shape[0]):
        if each[PROBABILITY, i] > 0.5:
            x += memory.axis[i, 0] * each[SLIP, i]
            y += memory.axis[i, 1] * each[SLIP, i]
        else:
            everything = False
    size = max(1e-6, math.hypot(x, y))
    along = min(0.0, (m[SLOW_AX] * x + m[SLOW_AY] * y) / size)
    across = (m[SLOW_AX] * y - m[SLOW_AY] * x) / size
    return math.hypot(along, across) if everything else -along


@kernel
def frictionless(memory: Memory, T: float) -> bool:
    """Has the slip believed in stayed the same for too long, T s after the last frame?

    Friction acts on wheels that slide and changes their slip; where wheels turn and all their
    slip speeds stay the same while the base moves on, it is the velocity that is wrong. Wheels
    that stand are left out: the hand that pushes such a base may balance the friction.
    """
    m, wheel = memory.m, memory.wheel
    slides = np.where(wheel[PROBABILITY] > 0.5, np.abs(wheel[SLIP]), 0.0)
    flat = np.where(wheel[PROBABILITY] > 0.5, wheel[FLAT], 1.0).min()  # all have been for long
    turning = np.abs(wheel[STEP]).max() > 0.05
    if flat == 1.0 and turning and slides.max() > 0.1:
        if not held(memory):
            m[GLIDING] += T / GLIDE_TIME
        m[GLIDING] += max(0.0, unfelt(memory) - GLIDE_PUSH) * T / GLIDE_SPEED
    else:
        m[GLIDING] = 0.0
    return bool(m[GLIDING] >= 1.0)


@part
def unlock(model: Model, memory: Memory, T: float) -> None:
    """Doubt the velocity along directions that no gripping wheel holds."""
    m = memory.m
    xx = xy = yy = 0.0
    slips = False
    for i in range(model.wheels):
        if memory.each[PROBABILITY, i] > 0.5:
            slips = True
            continue
        share = 2.0 / model.wheels
        ax, ay = memory.axis[i, 0], memory.axis[i, 1]
        xx += share * ax * ax
        xy += share * ax * ay
        yy += share * ay * ay
    mean, half = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    if not slips or mean - half >= UNHELD:
        m[LOCKED_FOR] = 0.0
        m[GLIDING] = 0.0
        forget_doubt(memory)
        return
    m[LOCKED_FOR] += T
    t = m[LOCKED_FOR]
    grow = model.drift_apart ** 2 * t * T * 2.0
    if follows(model, memory, T):
        wrong_along_slip(model, memory, T / FOLLOW_DOUBT)
    elif frictionless(memory, T):
        wrong_along_slip(model, memory, T / GLIDE_DOUBT)
    if mean + half < UNHELD:
        if held(memory):
            doubt_held(model, memory, grow)
        else:
            doubt_velocity(memory, grow, 0.0, grow)
        return
    angle = 0.5 * math.atan2(2.0 * xy, xx - yy) + 0.5 * math.pi  # eigenvector of the smaller one
    ex, ey = math.cos(angle), math.sin(angle)
    doubt_velocity(memory, grow * ex * ex, grow * ex * ey, grow * ey * ey)


@part
def uncertainty(model: Model, memory: Memory) -> None:
    """Standard deviation (W,) m/s of the slip speeds: A_i (P_v + D) A_i' + (5 mm/s)^2, root."""
    axis = memory.axis
    side = K + 3 * model.wheels
    xx, xy, yy = velocity_covariance(memory)
    for i in range(model.wheels):
        ax, ay = axis[i, 0], axis[i, 1] * (1.0 + memory.s[side + i])
        variance = ax * ax * xx + 2.0 * ax * ay * xy + ay * ay * yy
        memory.each[SIGMA, i] = math.sqrt(max(variance, 0.0) + 25e-6)
