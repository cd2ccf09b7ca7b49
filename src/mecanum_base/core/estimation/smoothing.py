"""A pass backwards over rows of the trail: every frame as later frames show it.

    F  = d x-(k) / d x(j)          k: the judged frame after j, T [s] later
    G  = P(j) F' P-(k)^-1          Rauch, Tung, Striebel 1965 for the first S = 10 states
    d(j)   = e^(-T/2s) G (x(k) - x-(k) + d(k))           x_s(j) = x(j) + d(j)
    P_s(j) = P(j) + e^(-T/1s) G (P_s(k) - P-(k)) G'

x-, P- are what was expected of frame k before it was judged. What the other states (travel, creep,
radii) know is left to the filter: G is the best linear guess from these 11. The exponential
forgets: the longer ago, the less a velocity found to be wrong tells, since knocks and floors that
no model knows come suddenly. Frames that were not judged (calm ones) take the corrections of their
neighbours in proportion. A standstill parts what lies before it from what comes after.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.estimation.acceleration import COMPILED
from mecanum_base.core.estimation.layout import BAX, BAY, BG, KG, PX, PY, VX, VY, YAW
from mecanum_base.core.estimation.retrace import retrace
from mecanum_base.core.estimation.trail import (
    FLAGS,
    P_AFTER,
    P_BEFORE,
    TURN,
    WAS_JUDGED,
    WAS_STILL,
    WITH_ACCEL,
    WITH_GYRO,
    X_BEFORE,
    S,
)
from mecanum_base.core.parameter import FloatArray, IntArray

FORGET = 2.0  # s
LEAST = 1e-30  # variance of what is known exactly
RIDGE = 1e-9  # of a correlation matrix, so that it can be inverted
TRACK = 12  # x y yaw vx vy wz, covariance xx xy yy xyaw yyaw yawyaw
MOVED = 5  # of the states: pose and velocity
# covariance of the pose as above, then xx xy yy of the velocity
_ROW = np.array([PX, PX, PY, PX, PY, YAW, VX, VX, VY])
_COLUMN = np.array([PX, PY, PY, YAW, YAW, YAW, VX, VY, VY])
_CHOSEN = P_AFTER + S * _ROW + _COLUMN


def transition(row: FloatArray, later: FloatArray, T: FloatArray) -> FloatArray:
    """F (R, S, S): change of the expected state of the frames ``later`` (R, width) with the state
    after the frames ``row`` (R, width), T (R,) s apart."""
    F: FloatArray = np.tile(np.eye(S), (len(row), 1, 1))
    vx, vy, yaw = row[:, VX], row[:, VY], row[:, YAW]
    turn = later[:, X_BEFORE + YAW] - yaw
    c, s = np.cos(yaw + 0.5 * turn), np.sin(yaw + 0.5 * turn)
    F[:, PX, YAW] = row[:, PY] - later[:, X_BEFORE + PY]
    F[:, PY, YAW] = later[:, X_BEFORE + PX] - row[:, PX]
    F[:, PX, VX], F[:, PX, VY] = c * T, -s * T
    F[:, PY, VX], F[:, PY, VY] = s * T, c * T
    F[:, VX, VY], F[:, VY, VX] = turn, -turn
    gyro, accel = row[:, WITH_GYRO], row[:, WITH_ACCEL]
    for state, change in ((BG, gyro * T), (KG, gyro * turn)):
        F[:, YAW, state] = -change
        F[:, VX, state] = -vy * change
        F[:, VY, state] = vx * change
    F[:, VX, BAX] = F[:, VY, BAY] = -accel * T
    F[:, BAX, BAY], F[:, BAY, BAX] = accel * turn, -accel * turn
    return F


def gains(F: FloatArray, P: FloatArray, expected: FloatArray) -> FloatArray:
    """G (R, S, S) from F, the covariances P after a frame and those expected of the next one."""
    scale = 1.0 / np.sqrt(np.maximum(np.diagonal(expected, axis1=1, axis2=2), LEAST))[:, None, :]
    known = expected * scale * scale.swapaxes(1, 2) + RIDGE * np.eye(S)
    G: FloatArray = np.matmul(P @ F.swapaxes(1, 2) * scale, np.linalg.inv(known)) * scale
    return G


def sweep(G: FloatArray, shift: FloatArray, P: FloatArray) -> None:
    """From the last frame but one to the first: d(j) <- d(j) + G d(k), P(j) <- P(j) + G P(k) G'.

    G (R - 1, S, S) belongs to the steps between the frames; d (R, S) is ``shift``.
    """
    for i in range(len(G) - 1, -1, -1):
        g = G[i]
        shift[i] += g @ shift[i + 1]
        P[i] += g @ P[i + 1] @ g.T


def traced(rows: FloatArray, T: FloatArray, share: FloatArray,
           change: FloatArray) -> tuple[FloatArray, FloatArray]:
    """d (R, S) and P_s (R, S, S) of the judged frames ``rows`` (R, width), T (R - 1,) s apart.

    ``share`` (R - 1,) of what a frame learns is passed on; ``change`` (R, S) is x - x-.
    """
    P, expected = _after(rows), rows[1:, P_BEFORE:FLAGS].reshape(-1, S, S)
    G = gains(transition(rows[:-1], rows[1:], T), P[:-1], expected)
    G *= share[:, None, None]
    shift = np.zeros(change.shape)
    shift[:-1] = np.matmul(G, change[1:, :, None])[:, :, 0]
    smooth = P.copy()
    smooth[:-1] -= G @ expected @ G.swapaxes(1, 2)
    sweep(G, shift, smooth)
    return shift, smooth


def look_back(stamp: IntArray, rows: FloatArray) -> FloatArray:
    """Smooth rows (R, width) of the trail with stamps (R,) ns.

    Returns (R, 15): x y yaw vx vy wz, covariance xx xy yy xyaw yyaw yawyaw of the pose and xx xy
    yy of the velocity.
    """
    out = np.column_stack([rows[:, :MOVED], rows[:, TURN], rows[:, _CHOSEN]])
    still = rows[:, WAS_STILL] > 0.0
    out[still, VX:TRACK // 2] = 0.0
    judged = np.flatnonzero(~still & (rows[:, WAS_JUDGED] > 0.0))
    if len(judged) < 2:
        return out
    T = np.diff(stamp[judged]) * 1e-9
    stands = np.cumsum(still)[judged]
    linked = stands[1:] == stands[:-1]
    share = linked * np.exp(-T / FORGET)
    change = rows[judged, :S] - rows[judged, X_BEFORE:P_BEFORE]
    if COMPILED:
        shift, smooth = np.empty(change.shape), np.empty((len(judged), S, S))
        retrace(rows, judged, T, share, LEAST, RIDGE, shift, smooth)
    else:
        shift, smooth = traced(rows[judged], T, share, change)
    rounded = np.diagonal(smooth, axis1=1, axis2=2).min(axis=1) < 0.0
    smooth[rounded] = _after(rows[judged[rounded]])
    smooth = _chosen(smooth)
    out[judged, :MOVED] += shift[:, :MOVED]
    out[judged, TRACK // 2:] = smooth
    before = np.searchsorted(judged, np.arange(len(rows)), side='right') - 1
    calm = ~still & (rows[:, WAS_JUDGED] == 0.0) & (before >= 0) & (before < len(linked))
    calm[calm] = linked[before[calm]]
    a = before[calm]
    u = ((stamp[calm] - stamp[judged[a]]) / (stamp[judged[a + 1]] - stamp[judged[a]]))[:, None]
    reached = (change + shift)[a + 1, :MOVED]
    out[calm, :MOVED] += (1.0 - u) * shift[a, :MOVED] + u * reached
    out[calm, TRACK // 2:] = (1.0 - u) * smooth[a] + u * smooth[a + 1]
    return out


def _after(rows: FloatArray) -> FloatArray:
    """Covariances (R, S, S) after the frames."""
    P: FloatArray = rows[:, P_AFTER:X_BEFORE].reshape(-1, S, S)
    return P


def _chosen(P: FloatArray) -> FloatArray:
    """The nine columns of covariance of (R, S, S)."""
    found: FloatArray = P[:, _ROW, _COLUMN]
    return found
