"""What the filter makes of every frame, a row each, kept until no second look can change it.

A second look (:mod:`.hindsight`) takes the readings of up to 2.5 s once more; the rows of the
frames it takes again are written anew. A row is final once no snapshot from before it can serve
any more. Nothing in the filter reads the trail: with room for no row (the live node) it costs
next to nothing, and the odometry is the same either way.

A row holds the first S = 10 states x and their covariance P after the frame, the same before it
(x-, P-; only where the frame was judged), flags, and for every wheel what its slip needs:

    x (S) | P (S, S) | x- (S) | P- (S, S) | flags | slip speed (W) m/s | A_x (W) | A_y (W)

with the lateral gains known at that frame in A_y.

The pose is that of the filter, without the gap to what was published.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.estimation.acceleration import part
from mecanum_base.core.estimation.hindsight import BACK, TAPE
from mecanum_base.core.estimation.layout import (
    BAY,
    HAVE_ACCEL,
    HAVE_GYRO,
    JUDGED,
    LAST_FRAME,
    REEL_COUNT,
    REEL_ROWS,
    SLIP,
    STILL,
    WZ,
    K,
    Memory,
)
from mecanum_base.core.parameter import FloatArray, IntArray

S = BAY + 1  # pose, velocity, gyro bias and scale, lever gain, accelerometer offset
P_AFTER, X_BEFORE, P_BEFORE, FLAGS = S, S + S * S, 2 * S + S * S, 2 * (S + S * S)
WAS_STILL, WAS_JUDGED, WITH_GYRO, WITH_ACCEL, TURN, WHEELS = range(FLAGS, FLAGS + 6)
_LEAST = 256  # rows


def row_width(wheels: int) -> int:
    """Length of one row."""
    return WHEELS + 3 * wheels


@part
def expect(memory: Memory) -> None:
    """Note what is expected of the frame that is about to be judged, if there is room."""
    count = memory.reel[REEL_ROWS]
    if count >= memory.trail.shape[0]:
        return
    row = memory.trail[count]
    row[X_BEFORE:P_BEFORE] = memory.x[:S]
    row[P_BEFORE:FLAGS].reshape((S, S))[:, :] = memory.P[:S, :S]


@part
def mark(memory: Memory) -> None:
    """Write the row of the frame just used, if there is room."""
    count = memory.reel[REEL_ROWS]
    if count >= memory.trail.shape[0]:
        return
    m, rows, w = memory.m, memory.rows, memory.rows.shape[0]
    now = memory.clock[LAST_FRAME]
    row = memory.trail[count]
    row[:S] = memory.x[:S]
    row[P_AFTER:X_BEFORE].reshape((S, S))[:, :] = memory.P[:S, :S]
    row[WAS_STILL] = m[STILL]
    row[WAS_JUDGED] = 1.0 if memory.clock[JUDGED] == now else 0.0
    row[WITH_GYRO] = m[HAVE_GYRO]
    row[WITH_ACCEL] = m[HAVE_ACCEL]
    row[TURN] = m[WZ]
    row[WHEELS:WHEELS + w] = memory.wheel[SLIP]
    row[WHEELS + w:WHEELS + 2 * w] = rows[:, 0]
    row[WHEELS + 2 * w:WHEELS + 3 * w] = rows[:, 1] * (1.0 + memory.x[K + 3 * w:K + 4 * w])
    memory.trail_ns[count] = now
    memory.reel[REEL_ROWS] = count + 1


def free(memory: Memory) -> int:
    """Number of frames that there is room for."""
    return len(memory.trail) - int(memory.reel[REEL_ROWS])


def settled(memory: Memory) -> int:
    """Number of rows, from the first, that no second look can reach any more."""
    count = int(memory.reel[REEL_ROWS])
    if not count:
        return 0
    kept = np.asarray(memory.kept_ns)
    able = ((kept[:, 1] >= memory.reel[REEL_COUNT] - TAPE)
            & (kept[:, 0] >= memory.trail_ns[count - 1] - BACK))
    return min(count, int(kept[able, 3].min())) if able.any() else count


def intact(memory: Memory) -> int:
    """Number of rows, from the first, up to the frame that has broken the numbers."""
    rows = memory.trail[:max(int(memory.reel[REEL_ROWS]) - 1, 0)]
    broken = np.flatnonzero(~np.isfinite(rows[:, :X_BEFORE]).all(axis=1))
    return int(broken[0]) if len(broken) else len(rows)


def with_room(memory: Memory, frames: int) -> Memory:
    """The same memory with room for the rows of ``frames`` more."""
    if free(memory) >= frames:
        return memory
    count = int(memory.reel[REEL_ROWS])
    size = max(5 * len(memory.trail) // 4, count + frames, _LEAST)
    trail = np.zeros((size, memory.trail.shape[1]))
    stamp = np.zeros(size, dtype=np.int64)
    trail[:count], stamp[:count] = memory.trail[:count], memory.trail_ns[:count]
    return memory._replace(trail=trail, trail_ns=stamp)


def hand_out(memory: Memory, rows: int) -> tuple[Memory, IntArray, FloatArray]:
    """Take the first ``rows`` out of the trail: stamps (rows,) and rows (rows, row_width(W)).

    The arrays themselves are handed out; the memory that comes with them has others.
    """
    left = int(memory.reel[REEL_ROWS]) - rows
    trail = np.zeros(memory.trail.shape)
    stamp = np.zeros(len(trail), dtype=np.int64)
    trail[:left] = memory.trail[rows:rows + left]
    stamp[:left] = memory.trail_ns[rows:rows + left]
    memory.reel[REEL_ROWS] = left
    np.asarray(memory.kept_ns)[:, 3] -= rows
    return (memory._replace(trail=trail, trail_ns=stamp), memory.trail_ns[:rows],
            memory.trail[:rows])
