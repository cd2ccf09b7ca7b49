"""Slip that stays the same whatever the wheels do is an error of the velocity.

    r = sum over T of (s_i - mean s_i)^2 / sum over T of (w_i - mean w_i)^2

s_i slip speed, w_i speed of wheel i along its roller axis, m/s, of the wheels believed to slide;
means fade in 0.5 s, sums in 1 s; a slip that has just changed at once is not asked. A wheel that
slides goes as fast as its motor wants it to: what it gains its slip gains, less what friction
makes of the base meanwhile; of simulated slip of nine kinds r is 0.08 or more, but for one run of
200, where a tilting floor happened to speed up the base as its wheels did (0.03). Where the base
follows all that the wheels do, r < 0.06, they grip: what looks like slip is the velocity, wrong by
that much, as after a slip that was over before it was seen. It is left alone where it cannot be
wrong by that much, beyond six standard deviations of it, as in that one run.
"""

from __future__ import annotations

from mecanum_base.core.estimation.acceleration import part
from mecanum_base.core.estimation.layout import (
    FLAT,
    LOCKED_FOR,
    MEAN_SLIP,
    MEAN_STEP,
    PROBABILITY,
    SIGMA,
    SLIP,
    SLIP_SUM,
    STEP,
    STEP_SUM,
    Memory,
)
from mecanum_base.core.estimation.model import Model

LEAST_SLIP = 0.1  # m/s
MEAN_TIME = 0.5  # s
SUM_TIME = 1.0  # s
FOLLOWS = 0.06  # r below which the base follows
SIGMAS = 6.0  # of the velocity, within which it may be wrong
SPEAKS = 0.002  # m^2/s, sum of the wheels' changes that says something: 0.05 m/s for a second


@part
def follows(model: Model, memory: Memory, T: float) -> bool:
    """Does the base follow, T s after the last frame, the wheels that are believed to slide?

    To be called in every frame in which a direction is held by no gripping wheel.
    """
    m, each = memory.m, memory.each
    anew = m[LOCKED_FOR] <= T
    for i in range(model.wheels):
        anew = anew or (each[PROBABILITY, i] > 0.5 and each[FLAT, i] < 1.0)
    fades = 0.0 if anew else max(0.0, 1.0 - T / SUM_TIME)
    steps, slips = fades * m[STEP_SUM], fades * m[SLIP_SUM]
    count, largest, doubted = 0, 0.0, True
    for i in range(model.wheels):
        if anew or each[PROBABILITY, i] <= 0.5:
            each[MEAN_STEP, i], each[MEAN_SLIP, i] = each[STEP, i], each[SLIP, i]
            continue
        gain = min(1.0, T / MEAN_TIME)
        each[MEAN_STEP, i] += gain * (each[STEP, i] - each[MEAN_STEP, i])
        each[MEAN_SLIP, i] += gain * (each[SLIP, i] - each[MEAN_SLIP, i])
        count += 1
        largest = max(largest, abs(each[SLIP, i]))
        doubted = doubted and abs(each[SLIP, i]) < SIGMAS * each[SIGMA, i]
        steps += T * (each[STEP, i] - each[MEAN_STEP, i]) ** 2
        slips += T * (each[SLIP, i] - each[MEAN_SLIP, i]) ** 2
    m[STEP_SUM], m[SLIP_SUM] = steps, slips
    return bool(doubted and largest > LEAST_SLIP
                and steps > count * SPEAKS and slips < FOLLOWS * steps)
