"""The end of a slip that was never seen, taken for the beginning of another one.

A slip that begins slowly enough, at less than about 0.1 m/s^2, is not seen: the velocity follows
the wheels. When they grip again they pull the base back to their own speed within tenths of a
second; the accelerometer shows that, and the filter believes that a slip the other way has begun:

    truth, A_i v   --____/--    wheels, z_i'   --------    believed, s_i = z_i' - A_i v   -----___

Whose doing it was tells the two apart. Where a slip begins, the wheel has changed its speed by it;
here the base has, by -s_i, as its velocity less the corrections by the wheels shows. Besides,
wheels that grip keep the slip that is wrongly believed in constant to a few mm/s, while friction
changes that of wheels that slide; and where it does change, because the offset of the
accelerometer was dragged along too, friction seems to push the base the wrong way, against the
slip. A slip for which this has held long enough is taken back: the readings since before it are
taken again, with the wheels believed. Only while other wheels grip: where all slide, it may be
ice, or a wall (:mod:`.obstacle`); and only where a wheel turns: a hand may push a base that
stands. What lasts longer than the snapshots reach is left to :func:`.slip.frictionless`.
"""

from __future__ import annotations

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.hindsight import (
    EVERY,
    corrections,
    usable,
    youngest,
)
from mecanum_base.core.estimation.layout import (
    BAX,
    BAY,
    CHANGE,
    EVEN_AX,
    EVEN_AY,
    FORCED,
    LAST_FRAME,
    LOCKED_FOR,
    LOOSE_FOR,
    OVER_FOR,
    PROBABILITY,
    ROLLS,
    SLIP,
    SLOPE,
    SLOPE_FILL,
    STEP,
    VX,
    VY,
    Memory,
)
from mecanum_base.core.estimation.model import Model

LEAST = 0.05  # m/s of slip
TURNING = 0.05  # m/s, the fastest wheel
STEADY = 0.0125  # m/s of change within 0.1 s: that of wheels that grip
AGAINST = -0.2  # m/s^2 along the slip: no friction does that
ENOUGH = 0.2  # s
DRAGGED = 0.05  # m/s^2
BEFORE = 100_000_000  # ns before the slip, from where on the speed of the base counts
LEAST_SHARE, MOST_SHARE = 0.4, 2.0  # of the slip, that the base may have made of it


@kernel
def made_by_base(memory: Memory) -> bool:
    """Has the base, not the wheel that slips most, changed its speed by about that slip?"""
    x = memory.s
    now = memory.clock[LAST_FRAME]
    slot = youngest(memory, now, int(memory.m[LOCKED_FOR] * 1e9) + BEFORE)
    if slot < 0:
        return False
    n = memory.P.shape[0]
    old = memory.kept[slot]
    if old[n + n * n + LOOSE_FOR] > 0.0:
        return False  # just after a slip the velocity is not known
    dx, dy = corrections(memory, now, slot)
    vx, vy = x[VX] - float(old[VX]) - dx, x[VY] - float(old[VY]) - dy
    size = made = 0.0
    for i in range(memory.axis.shape[0]):
        slid = memory.each[SLIP, i]
        if memory.each[PROBABILITY, i] > 0.5 and abs(slid) > size:
            size = abs(slid)
            made = -(memory.axis[i, 0] * vx + memory.axis[i, 1] * vy)
            if slid < 0.0:
                made = -made
    return bool(LEAST_SHARE * size < made < MOST_SHARE * size)


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
    """Add up the time for which the slip believed in looks like the end of another one."""
    m, each = memory.m, memory.each
    if m[LOCKED_FOR] == 0.0:
        m[OVER_FOR] = 0.0
        return
    if memory.clock[SLOPE_FILL] < 2 * SLOPE:
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
    if (change < STEADY or pushed_against(memory)) and made_by_base(memory):
        m[OVER_FOR] += T


@part
def believe_wheels(memory: Memory) -> None:
    """From here on no wheel slips; the slip not seen has dragged the accelerometer's offset."""
    memory.wheel[FORCED] = 0.0
    memory.m[ROLLS] = 1.0
    for i in (BAX, BAY):
        memory.P[i, i] += DRAGGED ** 2


@part
def gripped_again(memory: Memory, now: int) -> int:
    """Snapshot from before the slip that there has not been, or -1."""
    if memory.m[OVER_FOR] < ENOUGH:
        return -1
    lasted = int(memory.m[LOCKED_FOR] * 1e9)
    return usable(memory, now, lasted, lasted + 2 * EVERY)
