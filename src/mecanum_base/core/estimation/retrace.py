"""The pass backwards of :mod:`.smoothing` as one compiled loop over the judged frames.

    G' = P-(k)^-1 F P(j)                     by L D L' of the correlations, F entry by entry
    d(j)   = share G (x(k) - x-(k) + d(k))
    P_s(j) = P(j) + share^2 G (P_s(k) - P-(k)) G'

Symbols, units and sources are those of :mod:`.smoothing`, which does the same for all frames of
a piece at once where nothing is compiled (share is e^(-T/2s), 0 across a standstill). The two
agree to rounding.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel
from mecanum_base.core.estimation.layout import BAX, BAY, BG, KG, PX, PY, VX, VY, YAW
from mecanum_base.core.estimation.trail import (
    P_AFTER,
    P_BEFORE,
    WITH_ACCEL,
    WITH_GYRO,
    X_BEFORE,
    S,
)
from mecanum_base.core.parameter import FloatArray, IntArray


@kernel
def carry(row: FloatArray, later: FloatArray, T: float, out: FloatArray) -> None:
    """F P (S, S) into ``out``: the covariance after the frame ``row``, carried T s on."""
    for i in range(S):
        for j in range(S):
            out[i, j] = row[P_AFTER + S * i + j]
    turn = later[X_BEFORE + YAW] - row[YAW]
    c, s = T * math.cos(row[YAW] + 0.5 * turn), T * math.sin(row[YAW] + 0.5 * turn)
    east, north = later[X_BEFORE + PX] - row[PX], later[X_BEFORE + PY] - row[PY]
    vx, vy = row[VX], row[VY]
    gyro, accel = row[WITH_GYRO], row[WITH_ACCEL]
    for j in range(S):
        yaw = row[P_AFTER + S * YAW + j]
        x, y = row[P_AFTER + S * VX + j], row[P_AFTER + S * VY + j]
        bias = gyro * (T * row[P_AFTER + S * BG + j] + turn * row[P_AFTER + S * KG + j])
        ax, ay = accel * row[P_AFTER + S * BAX + j], accel * row[P_AFTER + S * BAY + j]
        out[PX, j] += c * x - s * y - north * yaw
        out[PY, j] += s * x + c * y + east * yaw
        out[YAW, j] -= bias
        out[VX, j] += turn * y - vy * bias - T * ax
        out[VY, j] += vx * bias - turn * x - T * ay
        out[BAX, j] += turn * ay
        out[BAY, j] -= turn * ax


@kernel
def divide(later: FloatArray, least: float, ridge: float, out: FloatArray, work: FloatArray,
           scale: FloatArray) -> None:
    """G' (S, S) in the place of F P in ``out``; ``work`` (S, S), ``scale`` (S,) are overwritten.

    The correlations of what was expected of ``later`` are parted into L D L': L below the
    diagonal of ``work``, 1 / D on it.
    """
    for i in range(S):
        scale[i] = 1.0 / math.sqrt(max(later[P_BEFORE + S * i + i], least))
    for i in range(S):
        for j in range(i):
            work[i, j] = later[P_BEFORE + S * i + j] * scale[i] * scale[j]
        work[i, i] = later[P_BEFORE + S * i + i] * scale[i] * scale[i] + ridge
        for j in range(S):
            out[i, j] *= scale[i]
    for k in range(S):
        whole = 1.0 / work[k, k]
        for i in range(k + 1, S):
            share = work[i, k] * whole
            for j in range(k + 1, i + 1):
                work[i, j] -= share * work[j, k]
            for j in range(S):
                out[i, j] -= share * out[k, j]
        for i in range(k + 1, S):
            work[i, k] *= whole
        work[k, k] = whole
    for k in range(S - 1, -1, -1):
        for j in range(S):
            out[k, j] *= work[k, k]
        for i in range(k + 1, S):
            for j in range(S):
                out[k, j] -= work[i, k] * out[i, j]
    for i in range(S):
        for j in range(S):
            out[i, j] *= scale[i]


@kernel
def retrace(rows: FloatArray, judged: IntArray, T: FloatArray, share: FloatArray, least: float,
            ridge: float, shift: FloatArray, variance: FloatArray) -> None:
    """From the last judged frame to the first: corrections into ``shift`` (J, S), smoothed
    covariances into ``variance`` (J, S, S).

    ``judged`` (J,) are places in ``rows`` (R, width); T (J - 1,) s lie between them, of the
    correction ``share`` (J - 1,) is passed on; ``least`` and ``ridge`` see :func:`.gains`.
    """
    G, work, change = np.empty((S, S)), np.empty((S, S)), np.empty((S, S))
    scale = np.empty(S)
    last = len(judged) - 1
    variance[last] = rows[judged[last], P_AFTER:X_BEFORE].copy().reshape((S, S))
    shift[last] = 0.0
    for k in range(last - 1, -1, -1):
        row, later, before = rows[judged[k]], rows[judged[k + 1]], variance[k]
        known = variance[k + 1]
        shift[k] = 0.0
        for i in range(S):
            for j in range(S):
                before[i, j] = row[P_AFTER + S * i + j]
        if share[k] == 0.0:
            continue
        carry(row, later, T[k], G)
        divide(later, least, ridge, G, work, scale)
        for i in range(S):
            d = share[k] * (later[i] - later[X_BEFORE + i] + shift[k + 1, i])
            for j in range(S):
                shift[k, j] += G[i, j] * d
                work[i, j] = 0.0
                change[i, j] = share[k] * share[k] * (known[i, j] - later[P_BEFORE + S * i + j])
        for i in range(S):
            for m in range(S):
                d = change[i, m]
                for j in range(S):
                    work[i, j] += d * G[m, j]
        for m in range(S):
            for i in range(S):
                d = G[m, i]
                for j in range(S):
                    before[i, j] += d * work[m, j]
