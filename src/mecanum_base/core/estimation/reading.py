"""One reading taken: used, put on the tape and, where a slip has begun, looked at once more.

The second look (:mod:`.hindsight`) starts from a snapshot shortly before; it has two causes: the
frame itself shows a wheel that did not slip before, or the sum of small corrections over up to a
second says that wheels must have been slipping unnoticed.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel
from mecanum_base.core.estimation.frame import step_frame, step_imu
from mecanum_base.core.estimation.hindsight import (
    OLDEST,
    TAPE,
    YOUNGEST,
    close_gap,
    keep,
    onset,
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
    PROBABILITY,
    PX,
    PY,
    REEL_COUNT,
    STILL,
    YAW,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.output import remember
from mecanum_base.core.parameter import FloatArray


@kernel
def take_imu(model: Model, memory: Memory, now: int, gyro: float, ax: float, ay: float,
             roll: float, pitch: float) -> None:
    """Use one IMU reading in base axes: gyro z, specific force x, y, gyro x, y; NaN = missing."""
    record(memory, now, IMU, np.array([gyro, ax, ay]), np.array([roll, pitch]))
    step_imu(model, memory, now, gyro, ax, ay, roll, pitch)


@kernel
def take_frame(model: Model, memory: Memory, now: int, z: FloatArray, valid: FloatArray) -> None:
    """Use the travel z (W,) m of one encoder frame; ``valid`` (W,) is 1 where it is known.

    Where it shows that a slip has begun, the readings since shortly before are taken once more.
    """
    close_gap(memory, (now - memory.clock[LAST_FRAME]) * 1e-9)
    keep(memory, now)
    record(memory, now, FRAME, z, valid)
    before = memory.wheel[PROBABILITY].copy()
    step_frame(model, memory, now, z, valid)
    remember(model, memory)
    slips = np.zeros(model.wheels)
    slot = -1
    if onset(memory, before):
        slot = usable(memory, now, YOUNGEST, OLDEST)
    if slot < 0 and memory.m[STILL] == 0.0 and memory.m[CARRIED] == 0.0:
        slot = suspect(model, memory, now, slips)
    if slot >= 0:
        again(model, memory, slot, slips)


@kernel
def again(model: Model, memory: Memory, slot: int, slips: FloatArray) -> None:
    """Go back to snapshot ``slot``; the wheels (W,) marked 1 or slipping now slip from there."""
    w = model.wheels
    m, x = memory.m, memory.x
    shown_x, shown_y = float(x[PX] + m[GAP_X]), float(x[PY] + m[GAP_Y])
    shown_yaw = float(x[YAW] + m[GAP_YAW])
    first = rewind(memory, slot, slips)
    for count in range(first, memory.reel[REEL_COUNT]):
        at = count % TAPE
        stamp, a = memory.tape_ns[at, 0], memory.tape[at]
        if memory.tape_ns[at, 1] == FRAME:
            step_frame(model, memory, stamp, a[:w].copy(), a[w:2 * w].copy())
            remember(model, memory)
        else:
            step_imu(model, memory, stamp, a[0], a[1], a[2], a[3], a[4])
    memory.wheel[FORCED] = 0.0
    m[GAP_X], m[GAP_Y] = shown_x - x[PX], shown_y - x[PY]
    m[GAP_YAW] = shown_yaw - x[YAW]
