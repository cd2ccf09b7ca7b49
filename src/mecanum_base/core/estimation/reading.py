"""One reading taken: used, put on the tape and, where a slip has begun, looked at once more.

The second look (:mod:`.hindsight`) starts from a snapshot shortly before; it has three causes: the
frame itself shows a wheel that did not slip before, the sum of small corrections over up to a
second says that wheels must have been slipping unnoticed, or the slip believed in turns out to be
the end of another one (:mod:`.regrip`).
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.frame import allow_calm, step_frame, step_imu
from mecanum_base.core.estimation.hindsight import (
    OLDEST,
    TAPE,
    YOUNGEST,
    close_gap,
    forget,
    keep,
    record,
    rewind,
    suspect,
    usable,
)
from mecanum_base.core.estimation.layout import (
    CARRIED,
    FORCED,
    FRAME,
    GAP_X,
    GAP_Y,
    GAP_YAW,
    IMU,
    LAST_FRAME,
    OVER_FOR,
    PX,
    PY,
    REEL_COUNT,
    STILL,
    YAW,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.output import remember
from mecanum_base.core.estimation.regrip import (
    ENOUGH,
    believe_wheels,
    doubt_slip,
    gripped_again,
    known_to_grip,
)
from mecanum_base.core.estimation.trail import mark
from mecanum_base.core.parameter import FloatArray

NEVER = 2 ** 63 - 1  # ns


@part
def take_imu(model: Model, memory: Memory, now: int, gyro: float, ax: float, ay: float,
             roll: float, pitch: float) -> None:
    """Use one IMU reading in base axes: gyro z, specific force x, y, gyro x, y; NaN = missing."""
    at, tape = record(memory, now, IMU), memory.tape
    tape[at, 0] = gyro
    tape[at, 1] = ax
    tape[at, 2] = ay
    tape[at, 3] = roll
    tape[at, 4] = pitch
    step_imu(model, memory, now, gyro, ax, ay, roll, pitch)


@kernel
def take_frame(model: Model, memory: Memory, now: int, z: FloatArray, valid: FloatArray) -> None:
    """Use the travel z (W,) m of one encoder frame; ``valid`` (W,) is 1 where it is known.

    Where it shows that a slip has begun, the readings since shortly before are taken once more.
    """
    close_gap(memory, (now - memory.clock[LAST_FRAME]) * 1e-9)
    keep(memory, now)
    w, at, tape = model.wheels, record(memory, now, FRAME), memory.tape
    for i in range(w):
        tape[at, i] = z[i]
        tape[at, w + i] = valid[i]
    begins = step_frame(model, memory, now, z, valid)
    remember(model, memory)
    mark(memory)
    if memory.m[CARRIED] > 0.0:
        return
    slips = np.zeros(w)
    slot = -1
    if begins:
        slot = usable(memory, now, YOUNGEST, OLDEST)
    if slot < 0 and memory.m[STILL] == 0.0:
        slot = suspect(model, memory, now, slips)
    over = gripped_again(memory, now)
    if over >= 0:
        again(model, memory, over, np.zeros(w), now - round(ENOUGH * 1e9),
              known_to_grip(memory))
        forget(memory)  # its sums hold the slip that was not seen
    elif slot >= 0:
        again(model, memory, slot, slips, NEVER, False)
    elif memory.m[OVER_FOR] >= ENOUGH:  # an end, but no snapshot is left from before it
        doubt_slip(memory)
        forget(memory)


@kernel
def again(model: Model, memory: Memory, slot: int, slips: FloatArray, grip: int,
          surely: bool) -> None:
    """Go back to snapshot ``slot``; the wheels (W,) marked 1 or slipping now slip from there.

    From the stamp ``grip`` [ns] on they grip, ``surely`` where more than steady slip says so.
    """
    w, tape = model.wheels, memory.tape
    m, x = memory.m, memory.x
    shown_x, shown_y = float(x[PX] + m[GAP_X]), float(x[PY] + m[GAP_Y])
    shown_yaw = float(x[YAW] + m[GAP_YAW])
    first = rewind(memory, slot, slips)
    for count in range(first, memory.reel[REEL_COUNT]):
        at = count % TAPE
        stamp = memory.tape_ns[at, 0]
        if stamp >= grip:
            believe_wheels(model, memory, surely)
            grip = NEVER
        if memory.tape_ns[at, 1] == FRAME:
            z, valid = np.empty(w), np.empty(w)
            for i in range(w):
                z[i], valid[i] = tape[at, i], tape[at, w + i]
            step_frame(model, memory, stamp, z, valid)
            remember(model, memory)
            mark(memory)
        else:
            step_imu(model, memory, stamp, tape[at, 0], tape[at, 1], tape[at, 2], tape[at, 3],
                     tape[at, 4])
    memory.wheel[FORCED] = 0.0
    allow_calm(model, memory)
    m[GAP_X], m[GAP_Y] = shown_x - x[PX], shown_y - x[PY]
    m[GAP_YAW] = shown_yaw - x[YAW]
