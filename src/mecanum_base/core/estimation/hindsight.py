"""Second look at the moment a slip began.

The first frames of a slip look like traction or a late stamp and pull the velocity along; when the
slip is seen, the filter goes back to a snapshot taken shortly before and takes the readings since
then once more, with the wheels that slip now free from there on:

    slips(now) -> restore(snapshot), for each reading since: take it again, with hypotheses
                  restricted to those in which these wheels slip

Slip that begins slowly never shows in one frame: the filter takes it for a wrong velocity and a
wrong accelerometer. Therefore the corrections of velocity and accelerometer offset by the wheels
are summed up; what the IMU alone says about the velocity since a snapshot of age T follows:

    d = v - v_imu = sum dv - sum(T_k db_k),  T_k the time since correction k
    sigma^2 = P_v + P_b T^2 + q_a T + q_b T^3/3
              + (scale |dv|)^2 + (creep a)^2 + P_tilt (turn T/2)^2

and a wheel with |A_i d + c_i| above 4.5 sigma must have slipped (6 where all wheels stand: a base
hardly ever glides on them, but that the offset is still being found is common there). c_i is what
its creep has grown by: a slip that the filter takes for creep has not been a correction. The slip
began about when that less 3 sigma is largest: back by 2.5 times that T. Going back farther would
leave the velocity to the IMU for longer than need be, and so unsure that the slip is lost in it.

The past that was published stays; position and velocity of this moment are as good as if the
slip had been known in time. Snapshots are whole copies of the memory, the tape holds the readings.
"""

from __future__ import annotations

import math

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.layout import (
    BAX,
    BAY,
    BSX,
    BSY,
    CALM,
    FIX_BX,
    FIX_BY,
    FIX_PX,
    FIX_PY,
    FIX_VX,
    FIX_VY,
    FORCED,
    GAP_X,
    GAP_Y,
    GAP_YAW,
    HAVE_ACCEL,
    JUDGED,
    LOOSE_FOR,
    M_SIZE,
    PROBABILITY,
    PX,
    PY,
    REEL_COUNT,
    REEL_ROWS,
    REEL_SLOT,
    SHAKE,
    SLOW_AX,
    SLOW_AY,
    TRAVEL,
    VX,
    VY,
    WANDER,
    YAW,
    K,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.propagation import SHAKEN
from mecanum_base.core.parameter import FloatArray

SLOTS = 65  # snapshots kept
EVERY = 40_000_000  # ns between snapshots
OLDEST = 150_000_000  # ns, age of a snapshot that serves when a slip is seen
YOUNGEST = 25_000_000  # ns
TAPE = 4096  # readings
RERUNS = 4  # second looks that one snapshot may serve
SHORT = 240_000_000  # ns, least ages of the snapshots that show hidden slip
LONG = 960_000_000
REACH = 5  # halves of the age that shows hidden slip best: so far back
FARTHEST = 1_050_000_000  # ns, so far back at most because of hidden slip
BACK = 2_500_000_000  # ns, farther back no second look goes at all
WORTH = 3.0  # standard deviations that an older snapshot must show more
GAP_TIME = 0.15  # s in which the published pose runs into a corrected one
HIDDEN_SPEED = 0.06  # m/s
HIDDEN_SIGMAS = 4.5
STANDING = 0.02  # m, wheels that have turned less stand
STANDING_SIGMAS = 6.0  # a wrong offset is likelier than a base that glides on them
HIDDEN_CREEP = 0.012  # s, creep of wheels that grip, per acceleration


@part
def record(memory: Memory, now: int, kind: int) -> int:
    """Put one reading on the tape: the row of it that its values belong in."""
    count = memory.reel[REEL_COUNT]
    at = count % TAPE
    memory.tape_ns[at, 0] = now
    memory.tape_ns[at, 1] = kind
    memory.reel[REEL_COUNT] = count + 1
    return int(at)


@part
def keep(memory: Memory, now: int) -> None:
    """Take a snapshot when the last one is old enough; to be called before a frame is used."""
    reel = memory.reel
    last = reel[REEL_SLOT]
    if now - memory.kept_ns[last, 0] < EVERY:
        return
    slot = (last + 1) % SLOTS
    reel[REEL_SLOT] = slot
    memory.kept_ns[slot, 0] = now
    memory.kept_ns[slot, 1] = reel[REEL_COUNT]
    memory.kept_ns[slot, 2] = RERUNS
    memory.kept_ns[slot, 3] = reel[REEL_ROWS]
    memory.kept_clock[slot] = memory.clock
    memory.kept[slot] = memory.store


@kernel
def forget(memory: Memory) -> None:
    """No snapshot is of use any more: what the state has become does not follow from them."""
    for slot in range(SLOTS):
        memory.kept_ns[slot, 1] = -TAPE - 1


@part
def close_gap(memory: Memory, dt: float) -> None:
    """Let the published pose run into that of the filter, without a step: odom is continuous."""
    m = memory.m
    x, y, yaw = m[GAP_X], m[GAP_Y], m[GAP_YAW]
    if x == 0.0 and y == 0.0 and yaw == 0.0:
        return
    share = math.exp(-dt / GAP_TIME)
    m[GAP_X] = share * x if abs(x) > 1e-9 else 0.0
    m[GAP_Y] = share * y if abs(y) > 1e-9 else 0.0
    m[GAP_YAW] = share * yaw if abs(yaw) > 1e-9 else 0.0


@part
def slipping_set(memory: Memory, wheels: int) -> int:
    """The wheels that slip now, as bits."""
    found = 0
    for i in range(wheels):
        if memory.each[PROBABILITY, i] > 0.5:
            found |= 1 << i
    return found


@kernel
def usable(memory: Memory, now: int, youngest: int, oldest: int) -> int:
    """The oldest snapshot whose age [ns] lies within these bounds, or -1.

    Snapshots lie EVERY apart or more, so none that is young enough lies further back in the ring.
    """
    last, first = memory.reel[REEL_SLOT], memory.reel[REEL_COUNT] - TAPE
    kept = memory.kept_ns
    for back in range(min(oldest // EVERY, SLOTS - 1), -1, -1):
        slot = (last - back) % SLOTS
        if (youngest <= now - kept[slot, 0] <= oldest and kept[slot, 1] >= first
                and kept[slot, 2] > 0):
            return int(slot)
    return -1


@kernel
def youngest(memory: Memory, now: int, age: int) -> int:
    """The youngest snapshot of at least this ``age`` [ns], or -1."""
    last, first = memory.reel[REEL_SLOT], memory.reel[REEL_COUNT] - TAPE
    for back in range(SLOTS):
        slot = (last - back) % SLOTS
        if now - memory.kept_ns[slot, 0] >= age and memory.kept_ns[slot, 1] >= first:
            return int(slot)
    return -1


@part
def kept_travel(memory: Memory, slot: int, i: int) -> float:
    """Travel [m] of wheel i when snapshot ``slot`` was taken."""
    n, wheels = memory.P.shape[0], memory.axis.shape[0]
    rows = n + n * n + M_SIZE + 3 * wheels + memory.hinge.shape[0] + memory.mode.shape[0]
    return float(memory.kept[slot, rows + TRAVEL * wheels + i])


@part
def corrected(memory: Memory) -> tuple[float, float, float, float, float, float, float]:
    """What a frame may correct: pose, velocity and offset of the accelerometer."""
    s = memory.s
    return s[PX], s[PY], s[YAW], s[VX], s[VY], s[BAX], s[BAY]


@part
def wait(memory: Memory, T: float) -> None:
    """T s go by in which nothing is corrected: what offsets were corrected before acts on."""
    m = memory.m
    m[FIX_PX] += T * m[FIX_BX]
    m[FIX_PY] += T * m[FIX_BY]


@part
def account(memory: Memory, T: float, px: float, py: float, yaw: float, vx: float, vy: float,
            bx: float, by: float) -> None:
    """Sum up, in odom axes, what this frame has corrected since these were :func:`corrected`.

    What it has done to the pose goes to the gap, so that what is published has no step. Without an
    accelerometer every change of speed is a correction, and none of them speaks of slip.
    """
    wait(memory, T)
    m, s = memory.m, memory.s
    now = s[YAW]
    if m[HAVE_ACCEL] > 0.0:
        cos, sin = math.cos(now), math.sin(now)
        dx, dy = s[VX] - vx, s[VY] - vy
        m[FIX_VX] += cos * dx - sin * dy
        m[FIX_VY] += sin * dx + cos * dy
        dx, dy = s[BAX] - bx, s[BAY] - by
        m[FIX_BX] += cos * dx - sin * dy
        m[FIX_BY] += sin * dx + cos * dy
    m[GAP_X] += px - s[PX]
    m[GAP_Y] += py - s[PY]
    m[GAP_YAW] += yaw - now


@part
def have_stood(memory: Memory, old: FloatArray, wheels: int) -> bool:
    """Have all wheels kept their place, within 2 cm, since the snapshot row ``old``?"""
    for i in range(K + wheels, K + 2 * wheels):
        if abs(memory.x[i] - old[i]) > STANDING:
            return False
    return True


@kernel
def corrections(memory: Memory, now: int, slot: int) -> tuple[float, float]:
    """d, m/s in the axes of the base: by how much the wheels have changed the velocity since.

    The velocity that the IMU alone would have led to since ``slot`` is that of the filter less d.
    """
    m = memory.m
    old = memory.kept[slot]
    n = memory.P.shape[0]
    k = n + n * n  # where the scalars begin
    summed = (now - memory.kept_clock[slot, JUDGED]) * 1e-9  # sums reach from frame to frame
    dx = (m[FIX_VX] - float(old[k + FIX_VX]) - (m[FIX_PX] - float(old[k + FIX_PX]))
          + float(old[k + FIX_BX]) * summed)
    dy = (m[FIX_VY] - float(old[k + FIX_VY]) - (m[FIX_PY] - float(old[k + FIX_PY]))
          + float(old[k + FIX_BY]) * summed)
    c, s = math.cos(memory.s[YAW]), math.sin(memory.s[YAW])
    return c * dx + s * dy, -s * dx + c * dy


@kernel
def hidden(model: Model, memory: Memory, now: int, slot: int, slips: FloatArray) -> float:
    """Mark in ``slips`` (W,) the wheels that must have slipped, unnoticed, since ``slot``.

    Slip of wheel i is A_i d. Returns the largest, m/s, less what may be an error of it.
    """
    m = memory.m
    n = memory.P.shape[0]
    old = memory.kept[slot]
    k = n + n * n
    age = (now - memory.kept_ns[slot, 0]) * 1e-9
    bx, by = corrections(memory, now, slot)
    first = K + 2 * model.wheels
    crept = 0.0
    for i in range(first, first + model.wheels):
        crept = max(crept, abs(float(memory.x[i])))
    if math.hypot(bx, by) + crept < HIDDEN_SPEED:
        return 0.0
    before = old[k:k + M_SIZE]
    if before[LOOSE_FOR] > 0.0:
        return 0.0  # just after a slip the velocity is surer than it should be
    var = 0.5 * (old[n + VX * n + VX] + old[n + VY * n + VY])
    var += 0.5 * (old[n + BAX * n + BAX] + old[n + BAY * n + BAY]) * age * age
    change = math.hypot(memory.x[VX] - old[VX], memory.x[VY] - old[VY])
    push = max(math.hypot(m[SLOW_AX], m[SLOW_AY]), math.hypot(before[SLOW_AX], before[SLOW_AY]))
    creep = HIDDEN_CREEP * push + model.creep_hard * push * push
    noise = max(model.accel_noise ** 2 + (model.accel_shake * math.hypot(memory.x[VX],
                                                                         memory.x[VY])) ** 2,
                SHAKEN * float(m[SHAKE]))
    var += noise * age + max(float(m[WANDER]), float(before[WANDER])) * age ** 3 / 3.0
    var += (0.015 * change) ** 2 + creep * creep
    tilt = 0.0  # variance of what turns with the base: offset less its part fixed to the sensor
    for i, j in ((BAX, BSX), (BAY, BSY)):
        tilt += 0.5 * (old[n + i * n + i] + old[n + j * n + j] - 2.0 * old[n + i * n + j])
    turn = float(memory.x[YAW] - old[YAW])
    var += tilt * (0.5 * turn * age) ** 2
    sigma = math.sqrt(var)
    sigmas = STANDING_SIGMAS if have_stood(memory, old, model.wheels) else HIDDEN_SIGMAS
    limit = max(HIDDEN_SPEED, sigmas * sigma)
    most = 0.0
    for i in range(model.wheels):
        slid = abs(memory.axis[i, 0] * bx + memory.axis[i, 1] * by
                   + float(memory.x[first + i] - old[first + i]))
        most = max(most, slid)
        if slid > limit:
            slips[i] = 1.0
    return float(most - WORTH * sigma)


@part
def suspect(model: Model, memory: Memory, now: int, slips: FloatArray) -> int:
    """Snapshot to go back to because of hidden slip, or -1; marks the wheels in ``slips`` (W,)."""
    if abs(memory.m[FIX_VX]) + abs(memory.m[FIX_VY]) == 0.0:
        return -1  # no correction yet
    most = 0.0
    since = SHORT
    for age in (SHORT, 2 * SHORT, LONG):
        slot = usable(memory, now, age, age + 2 * EVERY)
        if slot >= 0:
            slid = hidden(model, memory, now, slot, slips)
            if slid > most:
                most = slid
                since = age
    for i in range(model.wheels):
        if slips[i] > memory.each[PROBABILITY, i] + 0.5:
            return usable(memory, now, SHORT, min(REACH * since // 2, FARTHEST))
    return -1


@kernel
def rewind(memory: Memory, found: int, wheels: FloatArray) -> int:
    """Restore snapshot ``found``; number of the first reading to take again.

    From there on the wheels (W,) marked 1, and those that slip now, slip for certain.
    """
    reel = memory.reel
    forced = wheels.copy()
    for i in range(len(forced)):
        if memory.wheel[PROBABILITY, i] > 0.5:
            forced[i] = 1.0
    memory.store[:] = memory.kept[found]
    memory.clock[:] = memory.kept_clock[found]
    memory.wheel[FORCED] = forced
    memory.m[CALM] = 0.0
    memory.kept_ns[found, 2] -= 1
    for slot in range(SLOTS):  # what came after belongs to another past
        if memory.kept_ns[slot, 0] > memory.kept_ns[found, 0]:
            memory.kept_ns[slot, 1] = -TAPE - 1
    reel[REEL_SLOT] = found
    reel[REEL_ROWS] = memory.kept_ns[found, 3]
    return int(memory.kept_ns[found, 1])
