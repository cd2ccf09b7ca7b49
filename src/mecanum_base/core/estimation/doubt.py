"""Doubt of the velocity beyond its covariance: what may have gone wrong, and is used if it has.

While wheels slide the velocity is the IMU's. Its covariance P_v carries what is known of that:
noise and vibration as learnt, offset, scale, tilt. More may happen that no model has, such as a
knock that no sample shows, or a tilting floor. To put that into P as well would make every slip
as uncertain as the worst. So it is kept beside it, as a covariance D (2, 2), (m/s)^2, of the
velocity in the axes of the base:

    judging a wheel     P_v + D     S of the hypotheses, sigma of the slip speeds
    everything else     P_v         the update, the covariance that is published

A wheel that would slide by s if P_v alone were true may so be believed to grip. If it is, the
velocity was wrong by more than P_v explains; the difference moves from D to P before the update:

    u = d / |d|,  d = A+ s        more = min(u'D u, |d|^2 - u'P_v u)
    c = P_v u / (u'P_v u)         P += more c c',   D <- 0

c is what has gone wrong with each m/s along u: that error is as old as the slip, and what it has
done to the pose grows with it, to be undone once the wheels are believed again. (Adaptive
estimation by innovations, Mehra 1972, asked only where a slip ends.)
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.layout import (
    DOUBT_XX,
    DOUBT_XY,
    DOUBT_YY,
    PROBABILITY,
    SLIP,
    VX,
    VY,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.parameter import FloatArray

LEAST = 1e-3  # m/s of velocity lost: below it the wheels contradict each other
ENDS = 0.8  # probability of slip below which a wheel that has slipped perhaps grips


@part
def doubt_velocity(memory: Memory, xx: float, xy: float, yy: float) -> None:
    """Add a covariance (m/s)^2 to the doubt of the velocity."""
    m = memory.m
    m[DOUBT_XX] += xx
    m[DOUBT_XY] += xy
    m[DOUBT_YY] += yy


@part
def forget_doubt(memory: Memory) -> None:
    """The wheels hold the velocity again."""
    m = memory.m
    m[DOUBT_XX] = 0.0
    m[DOUBT_XY] = 0.0
    m[DOUBT_YY] = 0.0


@part
def velocity_covariance(memory: Memory) -> tuple[float, float, float]:
    """P_v + D, (m/s)^2: xx, xy, yy in the axes of the base."""
    m, P = memory.m, memory.P
    return (float(P[VX, VX]) + m[DOUBT_XX], float(P[VX, VY]) + m[DOUBT_XY],
            float(P[VY, VY]) + m[DOUBT_YY])


@kernel
def doubted_travel(memory: Memory, T: float) -> FloatArray:
    """Covariance (W, W) m^2 of the wheels' travel over ``T`` s that comes from the doubt."""
    m = memory.m
    x, y = memory.rows[:, 0], memory.rows[:, 1]
    cross: FloatArray = np.outer(x, y)
    found: FloatArray = (T * T) * (m[DOUBT_XX] * np.outer(x, x) + m[DOUBT_YY] * np.outer(y, y)
                                   + m[DOUBT_XY] * (cross + cross.T))
    return found


@kernel
def lost_velocity(model: Model, memory: Memory) -> tuple[float, float, float]:
    """d = A+ s as size [m/s] and direction (x, y); size 0: the wheels contradict each other."""
    lost = model.inverse @ memory.wheel[SLIP]
    size = math.hypot(lost[0], lost[1])
    if size < LEAST:
        return 0.0, 1.0, 0.0
    return size, float(lost[0]) / size, float(lost[1]) / size


@kernel
def grow_along(memory: Memory, ux: float, uy: float, variance: float) -> None:
    """Let the velocity along u be wrong by ``variance`` (m/s)^2 more: P += variance c c'."""
    P = memory.P
    column = ux * P[:, VX] + uy * P[:, VY]
    column /= ux * column[VX] + uy * column[VY]
    P[:, :] += variance * np.outer(column, column)


@kernel
def wrong_along_slip(model: Model, memory: Memory, share: float) -> None:
    """Let the velocity be wrong by a share of what the wheels say it has lost."""
    size, ux, uy = lost_velocity(model, memory)
    if size > 0.0:
        grow_along(memory, ux, uy, share * size * size)


@kernel
def doubt_held(model: Model, memory: Memory, variance: float) -> None:
    """Doubt of a base that something holds: across its slip as ever; along it, where the obstacle
    tells its velocity over and over, as noise that is in P at once and nowhere in the pose."""
    _, ux, uy = lost_velocity(model, memory)
    P = memory.P
    P[VX, VX] += variance * ux * ux
    P[VX, VY] += variance * ux * uy
    P[VY, VX] += variance * ux * uy
    P[VY, VY] += variance * uy * uy
    doubt_velocity(memory, variance * uy * uy, -variance * ux * uy, variance * ux * ux)


@kernel
def admit(model: Model, memory: Memory, chance: FloatArray) -> bool:
    """Move from D to P what the velocity must have been wrong by if a wheel now grips again.

    ``chance`` (W,) are the new probabilities of slip. True where P has changed.
    """
    m, P = memory.m, memory.P
    if m[DOUBT_XX] + m[DOUBT_YY] == 0.0:
        return False
    ends = False
    for i in range(len(chance)):
        ends = ends or (memory.each[PROBABILITY, i] > 0.5 and chance[i] < ENDS)
    size, ux, uy = lost_velocity(model, memory)
    if not ends or size == 0.0:
        return False
    held = ux * ux * P[VX, VX] + 2.0 * ux * uy * P[VX, VY] + uy * uy * P[VY, VY]
    may = ux * ux * m[DOUBT_XX] + 2.0 * ux * uy * m[DOUBT_XY] + uy * uy * m[DOUBT_YY]
    more = min(may, size * size - held)
    forget_doubt(memory)
    if more > 0.0:
        grow_along(memory, ux, uy, more)
    return bool(more > 0.0)
