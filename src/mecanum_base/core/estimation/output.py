"""From the filter's memory to the numbers that are published, one flat row an estimate.

    slip rate_i  = s_i / c_i                           rad/s, c_i travel a radian
    Tlale's s    = d_real / d_wheel over a window      T eq. 4: 1 rolling, 0 spinning on the spot
    slip twist   = A^+ s                               wheels' claim minus body motion

The ratio is NaN where a wheel has turned less than 5 cm in the window: never 0, never infinite.
"""

from __future__ import annotations

import math

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.layout import (
    ANGLE,
    BG,
    CARRIED,
    GAP_X,
    GAP_Y,
    GAP_YAW,
    HAVE_GYRO,
    KG,
    LAST_FRAME,
    LOOSE_FOR,
    PAST,
    PAST_AT,
    PAST_FILL,
    PAST_OLD,
    PAST_STAMP,
    PX,
    PY,
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
GRIPS = 0.7  # probability that all wheels grip
LEFT_OVER = 0.015  # m/s, error of the velocity that a slip just over has left behind
ROOT3 = math.sqrt(3.0)
POSE, POSE_COV, TWIST, TWIST_COV, SLIP_TWIST, SLIP_COV, BODY, WHEELS = 0, 3, 12, 15, 24, 27, 36, 37
# from WHEELS on: rate W, angle W, probability W, ratio W + 1


def row_size(wheels: int) -> int:
    """Length of one output row."""
    return WHEELS + 4 * wheels + 1


@part
def remember(model: Model, memory: Memory) -> None:
    """Keep travel and slid travel of this frame for the ratio window."""
    clock = memory.clock
    now = clock[LAST_FRAME]
    if (now - clock[PAST_STAMP]) * 1e-9 < model.ratio_window / (PAST - 8):
        return
    clock[PAST_STAMP] = now
    at = (clock[PAST_AT] + 1) % PAST
    clock[PAST_AT] = at
    clock[PAST_FILL] = min(clock[PAST_FILL] + 1, PAST)
    if clock[PAST_OLD] == at:  # the ring has caught up with its oldest slot
        clock[PAST_OLD] = (at + 1) % PAST
    past, each, w = memory.past, memory.each, model.wheels
    past[at, 0] = now * 1e-9
    for i in range(w):
        past[at, 1 + i] = each[TRAVEL, i]
        past[at, 1 + w + i] = each[ANGLE, i]


@part
def ratios(model: Model, memory: Memory, first: int) -> None:
    """Tlale's s (T eq. 4) per wheel, then of the body along the wheels' claim: W + 1 entries."""
    w = model.wheels
    clock, past, each, entry = memory.clock, memory.past, memory.each, memory.entry
    for i in range(w + 1):
        entry[first + i] = math.nan
    if clock[PAST_FILL] < 2:
        return
    horizon = clock[LAST_FRAME] * 1e-9 - model.ratio_window
    oldest, newest = clock[PAST_OLD], clock[PAST_AT]
    while oldest != newest and past[(oldest + 1) % PAST, 0] <= horizon:
        oldest = (oldest + 1) % PAST
    clock[PAST_OLD] = oldest
    least, far = model.ratio_travel, False
    claim_x = claim_y = lost_x = lost_y = 0.0
    for i in range(w):
        turned = each[TRAVEL, i] - past[oldest, 1 + i]
        slid = each[ANGLE, i] - past[oldest, 1 + w + i]
        if abs(turned) >= least:
            far = True
            entry[first + i] = 1.0 - slid / turned
        x, y = model.inverse[0, i], model.inverse[1, i]
        claim_x += x * turned
        claim_y += y * turned
        lost_x += x * slid
        lost_y += y * slid
    size = claim_x * claim_x + claim_y * claim_y
    if far and size >= least * least:
        entry[first + w] = 1.0 - (claim_x * lost_x + claim_y * lost_y) / size


@part
def slipping(slip: float, sigma: float) -> float:
    """Probability that a wheel slides faster than THRESHOLD, from its slip speed and sigma.

    Distribution function of Student's t with three degrees of freedom at
    t = (|s| - THRESHOLD)/sigma: its tails forgive a sigma that is too small, and two wheels that
    certainly slip still differ.
    """
    t = (abs(slip) - THRESHOLD) / sigma
    return 0.5 + (t * ROOT3 / (3.0 + t * t) + math.atan(t / ROOT3)) / math.pi


@kernel
def describe(model: Model, memory: Memory, row: FloatArray) -> None:
    """Fill ``row`` (row_size(W),) with the estimate of this moment."""
    s, m = memory.s, memory.m
    if m[CARRIED] == 0.0:  # else nothing but the motion is new
        judged(model, memory)
    row[:] = memory.row
    row[POSE] = s[PX] + m[GAP_X]
    row[POSE + 1] = s[PY] + m[GAP_Y]
    row[POSE + 2] = s[YAW] + m[GAP_YAW]
    if m[STILL] == 0.0 or m[CARRIED] > 0.0:
        row[TWIST] = s[VX]
        row[TWIST + 1] = s[VY]
        row[TWIST + 2] = m[WZ]


@part
def judged(model: Model, memory: Memory) -> None:
    """Fill memory.row with all but the motion: covariances and slip, and a twist of 0."""
    w = model.wheels
    P, m, each, entry = memory.P, memory.m, memory.each, memory.entry
    wz = m[WZ]
    for i in range(3):
        gap = m[GAP_X + i]
        for j in range(i, 3):
            value = P[PX + i, PX + j] + gap * m[GAP_X + j]
            entry[POSE_COV + 3 * i + j] = value
            entry[POSE_COV + 3 * j + i] = value
    turn = model.blind_turn ** 2 * 0.01
    if m[HAVE_GYRO] > 0.0:
        turn = float(P[BG, BG]) + wz * wz * float(P[KG, KG]) + 100.0 * model.gyro_noise ** 2
    xx, xy, yy = float(P[VX, VX]), float(P[VX, VY]), float(P[VY, VY])
    for first, floor in ((TWIST_COV, 0.0), (SLIP_COV, 25e-6)):
        entry[first] = xx + floor
        entry[first + 1] = xy
        entry[first + 3] = xy
        entry[first + 4] = yy + floor
        entry[first + 8] = turn + floor
    settles = m[LOOSE_FOR] > 0.0 and memory.mode[0] > GRIPS
    most = x = y = yaw = 0.0
    for i in range(w):
        speed, travel = each[SLIP, i], float(model.travel[i])
        x += model.inverse[0, i] * speed
        y += model.inverse[1, i] * speed
        yaw += model.inverse[2, i] * speed
        size = abs(speed)
        if settles:
            size -= LEFT_OVER
        chance = slipping(size, each[SIGMA, i])
        most = max(most, chance)
        entry[WHEELS + i] = speed / travel
        entry[WHEELS + w + i] = each[ANGLE, i] / travel
        entry[WHEELS + 2 * w + i] = chance
    entry[SLIP_TWIST], entry[SLIP_TWIST + 1], entry[SLIP_TWIST + 2] = x, y, yaw
    entry[BODY] = most
    ratios(model, memory, WHEELS + 3 * w)


def estimate_of_row(row: FloatArray, wheels: int, stamp_ns: int, source: str) -> Estimate:
    """The record of one output row; its arrays are views of ``row``."""
    pose, twist, lost = row[:BODY].reshape(3, 4, 3)  # each a vector and its covariance below it
    rest = WHEELS + 3 * wheels
    rate, angle, chance = row[WHEELS:rest].reshape(3, wheels)
    slip = SlipEstimate(rate, angle, chance, float(row[BODY]), row[rest:], lost[0], lost[1:])
    return Estimate(stamp_ns, source, pose[0], pose[1:], twist[0], twist[1:], slip)
