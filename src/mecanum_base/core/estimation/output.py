"""From the filter's memory to the numbers that are published, one flat row an estimate.

    slip rate_i  = s_i / c_i                           rad/s, c_i travel a radian
    Tlale's s    = d_real / d_wheel over a window      T eq. 4: 1 rolling, 0 spinning on the spot
    slip twist   = A^+ s                               wheels' claim minus body motion

The ratio is NaN where a wheel has turned less than 5 cm in the window: never 0, never infinite.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel
from mecanum_base.core.estimation.layout import (
    ANGLE,
    BG,
    CARRIED,
    GAP_X,
    GAP_YAW,
    HAVE_GYRO,
    KG,
    LAST_FRAME,
    PAST,
    PAST_AT,
    PAST_FILL,
    PAST_OLD,
    PAST_STAMP,
    PX,
    SIGMA,
    SLIP,
    STILL,
    TRAVEL,
    VX,
    VY,
    WZ,
    YAW,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.records import Estimate, SlipEstimate

THRESHOLD = 0.045  # m/s along the roller axis: more is slip, less is creep
ROOT3 = math.sqrt(3.0)
POSE, POSE_COV, TWIST, TWIST_COV, SLIP_TWIST, SLIP_COV, BODY, WHEELS = 0, 3, 12, 15, 24, 27, 36, 37
# from WHEELS on: rate W, angle W, probability W, ratio W + 1


def row_size(wheels: int) -> int:
    """Length of one output row."""
    return WHEELS + 4 * wheels + 1


@kernel
def remember(model: Model, memory: Memory) -> None:
    """Keep travel and slid travel of this frame for the ratio window."""
    clock = memory.clock
    now = clock[LAST_FRAME]
    if (now - clock[PAST_STAMP]) * 1e-9 < model.ratio_window / (PAST - 8):
        return
    clock[PAST_STAMP] = now
    clock[PAST_AT] = (clock[PAST_AT] + 1) % PAST
    clock[PAST_FILL] = min(clock[PAST_FILL] + 1, PAST)
    if clock[PAST_OLD] == clock[PAST_AT]:  # the ring has caught up with its oldest slot
        clock[PAST_OLD] = (clock[PAST_AT] + 1) % PAST
    slot = memory.past[clock[PAST_AT]]
    w = model.wheels
    slot[0] = now * 1e-9
    slot[1:1 + w] = memory.wheel[TRAVEL]
    slot[1 + w:1 + 2 * w] = memory.wheel[ANGLE]


@kernel
def ratios(model: Model, memory: Memory, out: FloatArray) -> None:
    """Tlale's s (T eq. 4) per wheel, then of the body along the wheels' claim: out (W + 1,)."""
    w = model.wheels
    clock, past = memory.clock, memory.past
    out[:] = math.nan
    if clock[PAST_FILL] < 2:
        return
    horizon = clock[LAST_FRAME] * 1e-9 - model.ratio_window
    oldest = clock[PAST_OLD]
    while oldest != clock[PAST_AT] and past[(oldest + 1) % PAST, 0] <= horizon:
        oldest = (oldest + 1) % PAST
    clock[PAST_OLD] = oldest
    slot = past[oldest]
    turned = memory.wheel[TRAVEL] - slot[1:1 + w]
    if np.abs(turned).max() < model.ratio_travel:
        return
    slid = memory.wheel[ANGLE] - slot[1 + w:1 + 2 * w]
    far = np.abs(turned) >= model.ratio_travel
    out[:w] = np.where(far, 1.0 - slid / np.where(far, turned, 1.0), math.nan)
    claim = model.inverse @ turned
    lost = model.inverse @ slid
    size = claim[0] * claim[0] + claim[1] * claim[1]
    if size >= model.ratio_travel ** 2:
        out[w] = 1.0 - (claim[0] * lost[0] + claim[1] * lost[1]) / size


@kernel
def slipping(slip: FloatArray, sigma: FloatArray) -> FloatArray:
    """Probability (W,) that each wheel slides faster than THRESHOLD, from its speed and sigma.

    Distribution function of Student's t with three degrees of freedom at
    t = (|s| - THRESHOLD)/sigma: its tails forgive a sigma that is too small, and two wheels that
    certainly slip still differ.
    """
    t = (np.abs(slip) - THRESHOLD) / sigma
    chance: FloatArray = 0.5 + (t * ROOT3 / (3.0 + t * t) + np.arctan(t / ROOT3)) / math.pi
    return chance


@kernel
def describe(model: Model, memory: Memory, row: FloatArray) -> None:
    """Fill ``row`` (row_size(W),) with the estimate of this moment."""
    w = model.wheels
    x, P, m, wheel = memory.x, memory.P, memory.m, memory.wheel
    wz = float(m[WZ])
    if m[CARRIED] > 0.0:  # nothing but the motion is new
        row[:] = memory.row
        row[POSE:POSE_COV] = x[PX:YAW + 1] + m[GAP_X:GAP_YAW + 1]
        row[TWIST] = x[VX]
        row[TWIST + 1] = x[VY]
        row[TWIST + 2] = wz
        return
    gap = m[GAP_X:GAP_YAW + 1]
    row[POSE:POSE_COV] = x[PX:YAW + 1] + gap
    row[POSE_COV:TWIST] = (P[PX:YAW + 1, PX:YAW + 1] + np.outer(gap, gap)).reshape(9)
    row[TWIST:WHEELS] = 0.0
    if m[STILL] == 0.0:
        row[TWIST] = x[VX]
        row[TWIST + 1] = x[VY]
        row[TWIST + 2] = wz
    turn = model.blind_turn ** 2 * 0.01
    if m[HAVE_GYRO] > 0.0:
        turn = P[BG, BG] + wz * wz * P[KG, KG] + 100.0 * model.gyro_noise ** 2
    row[TWIST_COV] = P[VX, VX]
    row[TWIST_COV + 1] = P[VX, VY]
    row[TWIST_COV + 3] = P[VY, VX]
    row[TWIST_COV + 4] = P[VY, VY]
    row[TWIST_COV + 8] = turn
    row[SLIP_TWIST:SLIP_COV] = model.inverse @ wheel[SLIP]
    row[SLIP_COV:BODY] = row[TWIST_COV:SLIP_TWIST]
    row[SLIP_COV:BODY:4] += 25e-6
    chance = slipping(wheel[SLIP], wheel[SIGMA])
    row[BODY] = chance.max()
    row[WHEELS:WHEELS + w] = wheel[SLIP] / model.travel
    row[WHEELS + w:WHEELS + 2 * w] = wheel[ANGLE] / model.travel
    row[WHEELS + 2 * w:WHEELS + 3 * w] = chance
    ratios(model, memory, row[WHEELS + 3 * w:])
    memory.row[:] = row


def estimate_of_row(row: FloatArray, wheels: int, stamp_ns: int, source: str) -> Estimate:
    """The record of one output row; its arrays are views of ``row``."""
    a = WHEELS
    slip = SlipEstimate(row[a:a + wheels], row[a + wheels:a + 2 * wheels],
                        row[a + 2 * wheels:a + 3 * wheels], float(row[BODY]),
                        row[a + 3 * wheels:], row[SLIP_TWIST:SLIP_COV],
                        row[SLIP_COV:BODY].reshape(3, 3))
    return Estimate(stamp_ns, source, row[POSE:POSE_COV], row[POSE_COV:TWIST].reshape(3, 3),
                    row[TWIST:TWIST_COV], row[TWIST_COV:SLIP_TWIST].reshape(3, 3), slip)
