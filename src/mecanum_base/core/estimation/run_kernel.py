"""Many settled readings in one call: the loop of the estimator without Python in between.

The kernels called, their order and their arguments are those of :class:`.filter.BodyFilter` fed
one sample after the other, so the numbers are the same to the last bit.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel, unowned
from mecanum_base.core.estimation.frame import arm, predict, sound
from mecanum_base.core.estimation.layout import (
    CARRIED,
    FRAME,
    FROZEN_FOR,
    LAST_FRAME,
    LAST_IMU,
    NOW,
    SLIP,
    STEP,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.output import describe
from mecanum_base.core.estimation.reading import take_frame, take_imu
from mecanum_base.core.parameter import FloatArray, IntArray

DONE, SILENCE, BROKEN = 0, 1, 2  # why the run ended
USED_IMU, STALE_IMU, USED_FRAME = 0, 1, 2  # counters
STARTED, ARMED, PUBLISHED = 0, 1, 2  # of progress


@kernel
def run(model: Model, memory: Memory, kind: IntArray, stamp: IntArray, value: FloatArray,
        limits: IntArray, progress: IntArray, table: FloatArray, row_stamp: IntArray,
        row_predicted: IntArray, marks: FloatArray, counts: IntArray) -> tuple[int, int, int]:
    """Take N readings in the order of their stamps.

    ``value`` (N, V): gyro z, acceleration x, y and gyro x, y, or the travel (W,) m of a frame;
    ``limits``: longest silence and period of predictions, ns; ``progress`` (3,): whether the
    filter has started and is armed, stamp of the last row (-1: none yet); it is changed. One row
    an estimate goes to ``table`` (R, row size), ``row_stamp``, ``row_predicted`` and ``marks``
    (R, 3, W): slip, speed, time frozen. ``counts`` (3,) is added to.

    Returns (readings taken, rows written, reason): after SILENCE the next reading needs care,
    after BROKEN the last one has broken the numbers.
    """
    model, memory = unowned(model), unowned(memory)
    clock, w = memory.clock, model.wheels
    valid = np.ones(w)
    rows = 0
    for k in range(len(kind)):
        now = stamp[k]
        fresh = progress[STARTED] == 0
        if fresh:
            progress[STARTED] = 1
            clock[NOW] = now
            clock[LAST_IMU] = now
            clock[LAST_FRAME] = now
        elif now - clock[NOW] > limits[0]:
            return k, rows, SILENCE
        if kind[k] == FRAME and progress[ARMED] == 0:
            predict(model, memory, now)
            arm(model, memory, now, value[k, :w])
            progress[ARMED] = 1
            counts[USED_FRAME] += 1
            if progress[PUBLISHED] < 0:
                progress[PUBLISHED] = now
            continue
        if kind[k] == FRAME:
            take_frame(model, memory, now, value[k, :w], valid)
            counts[USED_FRAME] += 1
            if memory.m[CARRIED] == 0.0 and not sound(memory):
                return k + 1, rows, BROKEN
            describe(model, memory, table[rows])
            marks[rows, 0] = memory.wheel[SLIP]
            marks[rows, 1] = memory.wheel[STEP]
            marks[rows, 2] = memory.wheel[FROZEN_FOR]
            row_predicted[rows] = 0
        else:
            if not fresh and (now <= clock[LAST_IMU] or now < clock[NOW]):
                counts[STALE_IMU] += 1
            else:
                take_imu(model, memory, now, value[k, 0], value[k, 1], value[k, 2], value[k, 3],
                         value[k, 4])
                counts[USED_IMU] += 1
            if progress[PUBLISHED] < 0 or now - progress[PUBLISHED] < limits[1]:
                continue
            if now > clock[NOW] or (now == clock[NOW] and memory.m[CARRIED] > 0.0):
                predict(model, memory, now)
            describe(model, memory, table[rows])
            row_predicted[rows] = 1
        row_stamp[rows] = now
        progress[PUBLISHED] = now
        rows += 1
    return len(kind), rows, DONE
