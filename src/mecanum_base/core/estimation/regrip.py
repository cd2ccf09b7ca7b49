"""The end of a slip that was never seen, taken for the beginning of another one.

A slip that begins slowly enough, at less than about 0.1 m/s^2, is not seen: the velocity follows
the wheels. When they grip again they pull the base back to their own speed within tenths of a
second; the accelerometer shows that, and the filter believes that a slip the other way has begun:

    truth, A_i v      --\\____/--      wheels, z_i'   --------       believed, s_i   ______/----

From then on the wheels grip, so the slip that is wrongly believed in stays the same to a few mm/s,
while friction would change that of wheels that slide; and where it does change, because the offset
of the accelerometer was dragged along too, friction seems to push the base the wrong way, against
the slip. A slip for which this has held long enough is taken back: the readings since before it
are taken again, with the wheels believed. Only while other wheels grip: where all slide, it may
be ice, or a wall (:mod:`.obstacle`); and only where a wheel turns: a hand may push a base that
stands. Slip that has lasted for longer is left to :func:`.slip.frictionless`.
"""

from __future__ import annotations

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.hindsight import EVERY, usable
from mecanum_base.core.estimation.layout import (
    CHANGE,
    EVEN_AX,
    EVEN_AY,
    FORCED,
    LOCKED_FOR,
    OVER,
    PROBABILITY,
    SLIP,
    SLOPE,
    SLOPE_FILL,
    STEP,
    Memory,
)
from mecanum_base.core.estimation.model import Model

LEAST = 0.05  # m/s of slip
TURNING = 0.05  # m/s, the fastest wheel
STEADY = 0.01  # m/s of change within 0.1 s: that of wheels that grip
STEADY_TIME = 0.2  # s
AGAINST = -0.2  # m/s^2 along the slip: no friction does that
AGAINST_TIME = 0.08  # s
RECENT = 1.05  # s; over a hole or on ice a slip that has lasted may be constant


@kernel
def pushed_against(memory: Memory) -> bool:
    """Does the base accelerate against the slip of a wheel?"""
    m = memory.m
    for i in range(memory.axis.shape[0]):
        if memory.each[PROBABILITY, i] > 0.5:
            along = memory.axis[i, 0] * m[EVEN_AX] + memory.axis[i, 1] * m[EVEN_AY]
            if memory.each[SLIP, i] < 0.0:
                along = -along
            if along < AGAINST:
                return True
    return False


@part
def watch_regrip(model: Model, memory: Memory, T: float) -> None:
    """Add up, T s after the last frame, what speaks for the end of another slip."""
    m, each = memory.m, memory.each
    if m[LOCKED_FOR] == 0.0:
        m[OVER] = 0.0
        return
    if m[LOCKED_FOR] > RECENT or memory.clock[SLOPE_FILL] < 2 * SLOPE:
        return
    grips = False
    size = change = fastest = 0.0
    for i in range(model.wheels):
        if each[FORCED, i] > 0.0:  # taken once more: its slip may not have begun yet
            return
        fastest = max(fastest, abs(each[STEP, i]))
        if each[PROBABILITY, i] > 0.5:
            size = max(size, abs(each[SLIP, i]))
            change = max(change, each[CHANGE, i])
        else:
            grips = True
    if not grips or size < LEAST or fastest < TURNING or change >= model.flat_speed:
        return
    if pushed_against(memory):
        m[OVER] += T / AGAINST_TIME
    elif change < STEADY:
        m[OVER] += T / STEADY_TIME


@part
def gripped_again(memory: Memory, now: int) -> int:
    """Snapshot from before the slip that there has not been, or -1."""
    if memory.m[OVER] < 1.0:
        return -1
    lasted = int(memory.m[LOCKED_FOR] * 1e9)
    return usable(memory, now, lasted, lasted + 2 * EVERY)
