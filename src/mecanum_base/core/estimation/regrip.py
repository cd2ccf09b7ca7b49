"""The end of a slip that was never seen, taken for the beginning of another one.

A slip that begins slowly enough, at less than about 0.1 m/s^2, is not seen: the velocity follows
the wheels. When they grip again they pull the base back to their own speed within tenths of a
second; the accelerometer shows that, and the filter believes that a slip the other way has begun:

    truth, A_i v   --____/--    wheels, z_i'   --------    believed, s_i = z_i' - A_i v   -----___

Three things tell them apart. Wheels that grip do so within tenths of a second, and keep the slip
that is wrongly believed in constant to a few mm/s from then on; slip that begins slowly, as that
of gravity on an uneven floor, may become constant too. So it must have come quickly: a share
:data:`QUICK` of it within 0.1 s. Its wheels have not jumped to another speed. And where a slip
begins, the wheel has changed its speed by it; here the base has, by -s_i, as its velocity less the
corrections by the wheels shows; then it may change a little more, for the offset of the
accelerometer was dragged along. Only while other wheels grip, and have gripped since the slip
began: where all slide, it may be ice, or a wall (:mod:`.obstacle`) along which the base rubs later
on; and only where a wheel turns: a hand may push a base that stands.

What has been found out then is more than that the wheels grip: they have slipped, for a second or
two, until they did. The readings since :data:`BACK` are taken again with those wheels free until
they gripped. The IMU keeps the velocity meanwhile, the grip at the end shows what has become of
its error, and the covariance carries that to the position: the distance lost unseen comes back.
Where a second look just before has left no snapshot that old, the wheels are believed from here on
and the distance stays lost. What lasts longer than the snapshots reach is left to
:func:`.slip.frictionless`.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.doubt import admit
from mecanum_base.core.estimation.hindsight import (
    BACK,
    SLOTS,
    TAPE,
    corrections,
    kept_travel,
    usable,
    youngest,
)
from mecanum_base.core.estimation.layout import (
    ALL_SLID,
    BAX,
    BAY,
    CHANGE,
    FORCED,
    KICK,
    LAST_FRAME,
    LOCKED_FOR,
    LOOSE_FOR,
    OVER_FOR,
    PROBABILITY,
    REEL_COUNT,
    REEL_SLOT,
    SIGMA,
    SLIP,
    SLOPE,
    SLOPE_FILL,
    STEP,
    VX,
    VY,
    Memory,
)
from mecanum_base.core.estimation.model import Model

LEAST, MOST = 0.05, 0.5  # m/s of slip
TURNING = 0.05  # m/s, the fastest wheel
STEADY = 0.006  # m/s of change within 0.1 s: that of wheels that grip
NEARLY = 0.0125  # m/s, the same where the base has made the slip
STEADY_SHARE = 0.02  # of the slip, that it may change besides: its offset was dragged along
QUICK = 0.28  # share of the slip that must have come within 0.1 s
EARLY = 2.2  # s, slip that is constant so soon: 1 s may have been looked back
JUMP = 0.5  # share of the slip, by which the wheel itself may not have jumped
SPAN = 2  # snapshots, over which the speed of a wheel is measured
AT_ONCE = 5  # snapshots, in which a wheel jumps
FEWEST = 10  # snapshots
ENOUGH = 0.08  # s, in which the wheels have gripped
SIGMAS = 3.0
OVER = BACK * 1e-9  # s, in which a wrong offset makes a slip
BEFORE = 100_000_000  # ns before the slip, from where on the speed of the base counts
LEAST_SHARE, MOST_SHARE = 0.4, 2.0  # of the slip, that the base may have made of it


@kernel
def most_slipping(memory: Memory) -> int:
    """The wheel that slips most of those believed to slip, or -1."""
    found, most = -1, 0.0
    for i in range(memory.axis.shape[0]):
        slid = abs(memory.each[SLIP, i])
        if memory.each[PROBABILITY, i] > 0.5 and slid > most:
            found, most = i, slid
    return found


@kernel
def made_by_base(memory: Memory) -> bool:
    """Has the base, not the wheel that slips most, changed its speed by about that slip?"""
    x = memory.s
    now = memory.clock[LAST_FRAME]
    slot = youngest(memory, now, int(memory.m[LOCKED_FOR] * 1e9) + BEFORE)
    worst = most_slipping(memory)
    if slot < 0 or worst < 0:
        return False
    n = memory.P.shape[0]
    old = memory.kept[slot]
    if old[n + n * n + LOOSE_FOR] > 0.0:
        return False  # just after a slip the velocity is not known
    dx, dy = corrections(memory, now, slot)
    vx, vy = x[VX] - float(old[VX]) - dx, x[VY] - float(old[VY]) - dy
    size = memory.each[SLIP, worst]
    made = -(memory.axis[worst, 0] * vx + memory.axis[worst, 1] * vy)
    if size < 0.0:
        size, made = -size, -made
    return bool(LEAST_SHARE * size < made < MOST_SHARE * size)


@kernel
def jumped(memory: Memory) -> bool:
    """Has the wheel that slips most changed its speed at once, other than steadily, by the slip?

    True also where no wheel slips, or too few snapshots are left to tell.
    """
    reel, kept_ns = memory.reel, memory.kept_ns
    now = memory.clock[LAST_FRAME]
    begin = now - int(memory.m[LOCKED_FOR] * 1e9) - BEFORE
    worst = most_slipping(memory)
    if worst < 0:
        return True
    t, travel = np.zeros(SLOTS), np.zeros(SLOTS)
    count = 0
    for back in range(SLOTS):
        slot = (reel[REEL_SLOT] - back) % SLOTS
        if kept_ns[slot, 1] < reel[REEL_COUNT] - TAPE:
            break
        t[count] = (kept_ns[slot, 0] - now) * 1e-9
        travel[count] = kept_travel(memory, slot, worst)
        count += 1
        if kept_ns[slot, 0] <= begin:
            break
    if count < FEWEST:
        return True
    count -= SPAN
    speed = (travel[:count] - travel[SPAN:count + SPAN]) / (t[:count] - t[SPAN:count + SPAN])
    size = memory.each[SLIP, worst]
    if size < 0.0:
        size, speed = -size, -speed
    steadily = (speed[0] - speed[count - 1]) / (t[0] - t[count - 1])
    most = 0.0
    for k in range(count - AT_ONCE):
        last = k + AT_ONCE
        most = max(most, speed[k] - speed[last] - steadily * (t[k] - t[last]))
    return bool(most > JUMP * size)


@part
def watch_regrip(model: Model, memory: Memory, T: float) -> None:
    """Add up the time for which the slip believed in looks like the end of another one."""
    m, each = memory.m, memory.each
    if m[LOCKED_FOR] == 0.0:
        m[OVER_FOR] = 0.0
        m[KICK] = 0.0
        m[ALL_SLID] = 0.0
        return
    grips = forced = False
    size = change = fastest = 0.0
    for i in range(model.wheels):
        forced = forced or each[FORCED, i] > 0.0
        fastest = max(fastest, abs(each[STEP, i]))
        if each[PROBABILITY, i] > 0.5:
            size = max(size, abs(each[SLIP, i]))
            change = max(change, each[CHANGE, i])
        else:
            grips = True
    if not grips:
        m[ALL_SLID] = 1.0
    if memory.clock[SLOPE_FILL] < 2 * SLOPE:
        return
    m[KICK] = max(m[KICK], change)
    if forced:  # taken once more: its slip may not have begun yet
        return
    if (m[ALL_SLID] > 0.0 or size < LEAST or size > MOST or fastest < TURNING
            or change >= model.flat_speed or m[KICK] < QUICK * size):
        return
    own = STEADY_SHARE * size
    if m[LOCKED_FOR] < EARLY and (
            (change < STEADY + own and not jumped(memory))
            or (change < NEARLY + own and made_by_base(memory))):
        m[OVER_FOR] += T


@part
def known_to_grip(memory: Memory) -> bool:
    """Has the base made the slip, and no longer than :data:`EARLY` ago?

    Only asked where the slip has also come quickly; then only its wheels can have done it.
    """
    return bool(memory.m[LOCKED_FOR] < EARLY and made_by_base(memory))


@part
def believe_wheels(model: Model, memory: Memory, surely: bool) -> None:
    """From here on all wheels grip, and the velocity is as wrong as has been doubted.

    Where it is known from elsewhere that they do (``surely``) while the IMU says with more than 3
    sigma that they do not, the slip is older than the snapshot: velocity and offset of the
    accelerometer were wrong by it from the start.
    """
    off = 0.0
    for i in range(memory.axis.shape[0]):
        slid = abs(memory.each[SLIP, i])
        if memory.each[FORCED, i] > 0.0 and slid > SIGMAS * memory.each[SIGMA, i]:
            off = max(off, slid)
    admit(model, memory, np.zeros(model.wheels))
    if surely:
        set_free(memory, off)
    memory.wheel[FORCED] = 0.0
    all_grip(memory)


@kernel
def doubt_slip(memory: Memory) -> None:
    """From here on all wheels grip; for where no snapshot from before the slip is left.

    Velocity and offset of the accelerometer are as wrong as the slip that was believed in.
    """
    off = 0.0
    for i in range(memory.axis.shape[0]):
        if memory.each[PROBABILITY, i] > 0.5:
            off = max(off, abs(memory.each[SLIP, i]))
    set_free(memory, off)
    memory.m[OVER_FOR] = 0.0
    all_grip(memory)


@kernel
def set_free(memory: Memory, off: float) -> None:
    """Velocity may be wrong by ``off`` m/s, the accelerometer by what has led to that."""
    for i, size in ((VX, off), (VY, off), (BAX, off / OVER), (BAY, off / OVER)):
        memory.P[i, i] += size * size


@kernel
def all_grip(memory: Memory) -> None:
    """No wheel slips, for certain."""
    memory.wheel[SLIP] = 0.0
    memory.wheel[PROBABILITY] = 0.0
    memory.mode[:] = 0.0
    memory.mode[0] = 1.0


@part
def gripped_again(memory: Memory, now: int) -> int:
    """Snapshot from before the slip not seen, where it has turned out that it is over, or -1."""
    if memory.m[OVER_FOR] < ENOUGH:
        return -1
    return usable(memory, now, int(memory.m[LOCKED_FOR] * 1e9), BACK)
