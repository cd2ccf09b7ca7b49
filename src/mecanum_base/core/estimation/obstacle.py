"""A base that something holds while all its wheels slide on.

    u = A+ s / |A+ s|          0 = u . v + noise,  noise of 5 cm/s

s slip speeds of the wheels (W,) m/s, A+ the least-squares inverse, v velocity of the base. Wheels
that slide push the base with their friction. Where all of them turn and slide, their slip stays
the same and the base gains no speed along it, something must balance that push: a wall, a step,
a load. Then the base stands in that direction, and no wheel grips before its slip has changed.
It is believed only where the base has lost such a speed at once, as the accelerometer shows,
where the velocity known from then agrees, and is far from the speed that the wheels claim. Along
a wall u turns with the velocity that it is computed from, u' across u, left of it:

    d(u . v)/dv = u - u' (u' . v) / |A+ s|

so that v is drawn to the circle of velocities across their own slip, and rubbing along the wall
adds noise of 0.2 (u' . v). A base that turns may be held at a corner while its middle moves: its
velocity is left alone. Not modelled: a load that gives way slowly (5 cm/s are allowed for).
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.layout import (
    EVEN_AX,
    EVEN_AY,
    FLAT,
    HELD_FOR,
    HIT,
    PROBABILITY,
    SLIP,
    SLOPE,
    STEP,
    VX,
    VY,
    WZ,
    Memory,
)
from mecanum_base.core.estimation.model import Model

SLOWEST = 0.05  # m/s, the fastest wheel of a base that is held turns at least like this
LEAST_SLIP = 0.1  # m/s
PUSH = 0.2  # m/s^2 of acceleration along the slip that still counts as none
TIME = 0.08  # s beyond the time that tells that slip does not change
NOISE = 0.05  # m/s
AGREES = 1.5  # standard deviations of the velocity along the slip
RUB = 0.2  # coefficient of friction of an obstacle that the base rubs along
TURNING = 0.1  # rad/s, a base that turns is held at a corner: its middle moves
HIT_TIME = 0.4  # s within which what is in the way takes the speed from the base
HIT_FADES = 0.5  # s
MARGIN = 4.0  # squared standard deviations by which standing must beat gripping


@kernel
def held(memory: Memory) -> bool:
    """Is something in the way of the base?"""
    return bool(memory.m[HELD_FOR] >= TIME)


@kernel
def perhaps_held(memory: Memory) -> bool:
    """Did the last frame look as if something were in the way? No wheel may grip meanwhile."""
    return bool(memory.m[HELD_FOR] > 0.0)


@kernel
def slides_evenly(model: Model, memory: Memory) -> bool:
    """Do all wheels slide, with slip speeds that do not change, and does one of them turn?"""
    each = memory.each
    turns = False
    for i in range(model.wheels):
        if each[PROBABILITY, i] <= 0.5 or each[FLAT, i] < 1.0:
            return False
        turns = turns or abs(each[STEP, i]) > SLOWEST
    return turns


@part
def watch_hits(model: Model, memory: Memory, T: float) -> None:
    """Remember the hardest change of speed, 0.1 s means of it, for as long as all wheels slide."""
    m = memory.m
    slide = True
    for i in range(model.wheels):
        slide = slide and memory.each[PROBABILITY, i] > 0.5
    before = m[HIT] if slide else m[HIT] * math.exp(-T / HIT_FADES)
    m[HIT] = max(before, math.hypot(m[EVEN_AX], m[EVEN_AY]))


@kernel
def stop_at_obstacle(model: Model, memory: Memory, T: float) -> None:
    """Find out, T s after the last frame, whether the base is held; its velocity then is 0."""
    m, x, P = memory.m, memory.x, memory.P
    watch_hits(model, memory, T)
    if not slides_evenly(model, memory):
        m[HELD_FOR] = 0.0
        return
    lost = model.inverse @ memory.wheel[SLIP]
    size = max(1e-3, math.hypot(lost[0], lost[1]))
    ux, uy = float(lost[0]) / size, float(lost[1]) / size
    if abs(ux * m[EVEN_AX] + uy * m[EVEN_AY]) > PUSH:
        m[HELD_FOR] = 0.0
        return
    speed = float(ux * x[VX] + uy * x[VY])
    variance = float(ux * ux * P[VX, VX] + 2.0 * ux * uy * P[VX, VY] + uy * uy * P[VY, VY])
    # the slip, and so its direction u, changes with the velocity: d(u.v)/dv = u - u' (u'.v) / size
    across = float(ux * x[VY] - uy * x[VX])
    jx, jy = ux + uy * across / size, uy - ux * across / size
    column = jx * P[:, VX] + jy * P[:, VY]
    spread = float(jx * column[VX] + jy * column[VY])
    agrees = speed * speed < AGREES * AGREES * spread
    if m[HELD_FOR] < TIME and (size < LEAST_SLIP or size > HIT_TIME * m[HIT] or not agrees
                               or speed * speed * variance
                               > (size * size - MARGIN * variance) * spread):
        m[HELD_FOR] = 0.0
        return
    m[HELD_FOR] += T
    if (m[HELD_FOR] < TIME or spread < NOISE * NOISE or not agrees
            or abs(m[WZ]) > TURNING):
        return
    gain = column / (spread + NOISE * NOISE + (RUB * across) ** 2)
    x[:] -= speed * gain
    P[:, :] -= np.outer(gain, column)
    vx, vy = speed * float(gain[VX]), speed * float(gain[VY])
    for i in range(model.wheels):  # the slope of slip must not see this step
        change = memory.axis[i, 0] * vx + memory.axis[i, 1] * vy
        memory.each[SLIP, i] += change
        for k in range(2 * SLOPE):
            memory.slope[k, i] += change
