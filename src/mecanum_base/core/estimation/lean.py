"""Tilt of the base followed by the gyro's x and y axes, so that gravity is not taken for a push.

A tilted base feels gravity along x and y; that part of the accelerometer's offset o turns with the
base, the part b that belongs to the sensor does not:

    o_x' = -g w_y + wz (o_y - b_y)        o_y' = g w_x - wz (o_x - b_x)

Rates w_x, w_y are what the gyro reads less its rest value and less m wz, where m is how much of
the yaw rate leaks into that axis (mount and cross axis), learnt by least squares while driving:

    m = sum(w wz dt) / (s0 + sum(wz^2 dt)),  s0 = (floor / g)^2 / LEAK^2

Unmeasured, o wanders like floors do, by ``floor`` m/s^2/rts. Measured, the two are weighed:
gain = vf/(vf + vm), variance a second vf vm/(vf + vm), with the variances vf of the floor and vm
of the measurement. Where a base tips (the edge of a ramp) the mean rate q over 40 ms is far
beyond both; then the floor has that much more,

    vf += g^2 (q^2 - q0^2) 1 s,  q0^2 = 6 ((n + vf / g^2) / 40 ms + e^2)

with the noise density n of the gyro and the variance e^2 of offset and leak;
what was missed of the rate until then is made up for, and m learns little from it. Axes that read
exactly 0 for long, or nothing, are not measured. Angles are small.
"""

from __future__ import annotations

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.layout import (
    BAX,
    BAY,
    BSX,
    BSY,
    HAVE_GYRO,
    LEAN_EVEN,
    LEAN_GAIN,
    LEAN_REST,
    LEAN_RX,
    LEAN_RY,
    LEAN_SEEN,
    LEAN_X,
    LEAN_XZ,
    LEAN_Y,
    LEAN_YZ,
    LEAN_ZZ,
    TREMOR,
    WANDER,
    WZ,
    Memory,
)
from mecanum_base.core.estimation.model import Model

FASTEST = 60.0  # rad/s, no base rolls and pitches like that
GRAVITY = 9.80665  # m/s^2
DEAF = 0.1  # s of nothing but 0, 0 until the axes x and y count as missing
LEAK = 0.015  # share of the yaw rate seen by another axis, standard deviation before learning
REST_MOST = 10.0  # s of rest over which the offsets of x and y are averaged
REST_WANDER = 1.5e-4  # rad/s, how far these offsets are off at best
REST_UNKNOWN = 0.05  # rad/s, how far they are off before the first standstill
TIPPING = 0.04  # s over which rates are averaged to see that the base tips
TIPS_FOR = 1.0  # s, turns the square of such a rate into a variance a second
SURELY = 6.0  # times the variance that noise and a wandering floor explain
SHARE = 0.02  # of a tilt that its measurement misses: scale of the gyro, delay
LASTING = 1.0  # s over which a wrong rate stays the same


@part
def turn_offset(memory: Memory, turn: float) -> None:
    """Turn the gravity part of the accelerometer's offset with the base, by ``turn`` rad."""
    s = memory.s
    bx, by = s[BAX], s[BAY]
    s[BAX] = bx + turn * (by - s[BSY])
    s[BAY] = by - turn * (bx - s[BSX])


@part
def follow(memory: Memory, roll: float, pitch: float, dt: float) -> None:
    """Take the rates about x and y [rad/s] of one reading that stands for ``dt`` s."""
    m = memory.m
    rate = abs(roll) + abs(pitch)
    if rate > 0.0:
        m[LEAN_SEEN] = DEAF
    else:  # a coarse gyro reads 0, 0 now and then; one that has no such axes always does
        m[LEAN_SEEN] = max(m[LEAN_SEEN] - dt, 0.0)
    if not rate < FASTEST:  # absurd, or not a number
        m[LEAN_SEEN] = 0.0
    if m[LEAN_SEEN] == 0.0:
        return
    roll -= m[LEAN_X]
    pitch -= m[LEAN_Y]
    wz, xz, yz, zz = m[WZ], m[LEAN_XZ], m[LEAN_YZ], m[LEAN_ZZ]
    step = GRAVITY * m[LEAN_GAIN] * dt
    about_x, about_y = roll - xz / zz * wz, pitch - yz / zz * wz
    memory.s[BAX] -= step * about_y
    memory.s[BAY] += step * about_x
    share = dt / (TIPPING + dt)
    m[LEAN_RX] += share * (about_x - m[LEAN_RX])
    m[LEAN_RY] += share * (about_y - m[LEAN_RY])
    if m[LEAN_REST] > 0.0:
        spin = m[LEAN_EVEN] * wz * dt
        m[LEAN_XZ] = xz + roll * spin
        m[LEAN_YZ] = yz + pitch * spin
        m[LEAN_ZZ] = zz + wz * spin


@part
def wander(model: Model, memory: Memory) -> float:
    """Variance (m/s^2)^2 a second by which tilt changes unseen; sets the gain of the gyro axes.

    Where the gain rises because the base tips, the offset gets what it has missed until now.
    """
    m = memory.m
    floor = model.accel_drift ** 2
    if m[LEAN_SEEN] == 0.0 or m[HAVE_GYRO] == 0.0:
        m[LEAN_GAIN] = 0.0
        m[WANDER] = floor
        return floor
    rest = m[LEAN_REST]
    if rest > 0.0:
        offset = model.gyro_noise ** 2 / rest + REST_WANDER ** 2
    else:
        offset = REST_UNKNOWN ** 2
    wz = m[WZ]
    leak = (floor / GRAVITY ** 2) / m[LEAN_ZZ] * wz * wz
    quick = max(model.gyro_noise ** 2, 1.5 * m[TREMOR])
    noise = quick + LASTING * (offset + leak)
    tips = m[LEAN_RX] ** 2 + m[LEAN_RY] ** 2
    seen = GRAVITY ** 2 * (noise + LASTING * 0.5 * SHARE ** 2 * tips)
    chance = SURELY * ((quick + floor / GRAVITY ** 2) / TIPPING + offset + leak)
    m[LEAN_EVEN] = 1.0
    if tips > chance:
        floor += GRAVITY ** 2 * TIPS_FOR * (tips - chance)
        m[LEAN_EVEN] = (chance / tips) ** 2
    gain = floor / (floor + seen)
    late = GRAVITY * (gain - m[LEAN_GAIN]) * TIPPING
    memory.s[BAX] -= late * m[LEAN_RY]
    memory.s[BAY] += late * m[LEAN_RX]
    m[LEAN_GAIN] = gain
    m[WANDER] = gain * seen
    return float(gain * seen)


@kernel
def rest(memory: Memory, roll: float, pitch: float, span: float) -> None:
    """Average the rates read at rest: means [rad/s] over ``span`` s of standstill."""
    m = memory.m
    if roll == 0.0 and pitch == 0.0:
        return  # no such axes
    total = min(m[LEAN_REST] + span, REST_MOST)
    m[LEAN_RX] = m[LEAN_RY] = 0.0
    m[LEAN_X] += span / total * (roll - m[LEAN_X])
    m[LEAN_Y] += span / total * (pitch - m[LEAN_Y])
    m[LEAN_REST] = total
