"""The pass backwards over made-up rows: against a batch solution and by differences."""

import numpy as np
import pytest

from mecanum_base.core.estimation import smoothing, trail
from mecanum_base.core.estimation.layout import BAX, BAY, PX, VX

PERIOD, COUNT = 0.1, 30  # s, frames
PUSH, READ = 0.3, 0.02  # m/s a step, m/s: noise of velocity and of its measurement


def straight():
    """Rows of a Kalman filter for x' = v along x, and the normal equations of the same problem."""
    random = np.random.default_rng(3)
    truth = np.cumsum(PUSH * random.standard_normal(COUNT))
    read = truth + READ * random.standard_normal(COUNT)
    read[10:20] = np.nan  # nothing is known of the velocity: a slip of all wheels
    rows = np.zeros((COUNT, trail.row_width(0)))
    x, P = np.zeros(2), np.diag([1e-6, 1.0])
    step = np.array([[1.0, PERIOD], [0.0, 1.0]])
    information, known = np.zeros((2 * COUNT, 2 * COUNT)), np.zeros(2 * COUNT)
    cells = np.ix_([PX, VX], [PX, VX])
    for k in range(COUNT):
        if k:
            x, P = step @ x, step @ P @ step.T + np.diag([1e-6, PUSH ** 2])
            part = np.hstack([-step, np.eye(2)])
            both = slice(2 * k - 2, 2 * k + 2)
            information[both, both] += part.T @ np.diag([1e6, PUSH ** -2]) @ part
        else:
            information[:2, :2] += np.linalg.inv(P)
        rows[k, trail.X_BEFORE + PX], rows[k, trail.X_BEFORE + VX] = x
        rows[k, trail.P_BEFORE:trail.FLAGS].reshape(trail.S, trail.S)[cells] = P
        if np.isfinite(read[k]):
            gain = P[:, 1] / (P[1, 1] + READ ** 2)
            x, P = x + gain * (read[k] - x[1]), P - np.outer(gain, P[1])
            information[2 * k + 1, 2 * k + 1] += READ ** -2
            known[2 * k + 1] += read[k] * READ ** -2
        rows[k, PX], rows[k, VX] = x
        rows[k, trail.P_AFTER:trail.X_BEFORE].reshape(trail.S, trail.S)[cells] = P
        rows[k, trail.WAS_JUDGED] = 1.0
    stamp = np.arange(COUNT) * round(PERIOD * 1e9)
    return stamp, rows, np.linalg.solve(information, known), np.linalg.inv(information)


def test_the_pass_backwards_is_the_least_squares_solution_of_all_frames_at_once(monkeypatch):
    """Without forgetting; the ridge of 1e-9 on the correlations allows 1e-6."""
    monkeypatch.setattr(smoothing, 'FORGET', 1e12)
    stamp, rows, best, covariance = straight()
    out = smoothing.look_back(stamp, rows)
    np.testing.assert_allclose(out[:, PX], best[0::2], atol=1e-6)
    np.testing.assert_allclose(out[:, VX], best[1::2], atol=1e-6)
    np.testing.assert_allclose(out[:, 6], covariance.diagonal()[0::2], rtol=1e-5)
    np.testing.assert_allclose(out[:, 12], covariance.diagonal()[1::2], rtol=1e-5)


def test_a_standstill_parts_what_lies_before_from_what_comes_after():
    stamp, rows, _, _ = straight()
    rows[15, trail.WAS_STILL] = 1.0
    out = smoothing.look_back(stamp, rows)
    np.testing.assert_array_equal(out[:15], smoothing.look_back(stamp[:15], rows[:15]))
    np.testing.assert_array_equal(out[16:], smoothing.look_back(stamp[16:], rows[16:]))
    assert out[15, 3] == 0.0 and out[15, PX] == rows[15, PX]


def test_calm_frames_take_the_corrections_of_their_neighbours_in_proportion():
    stamp, rows, _, _ = straight()
    kept = np.ones(COUNT, dtype=bool)
    kept[[14, 15]] = False
    rows[~kept, trail.WAS_JUDGED] = 0.0
    shift = smoothing.look_back(stamp, rows)[:, VX] - rows[:, VX]
    without = smoothing.look_back(stamp[kept], rows[kept])[:, VX] - rows[kept, VX]
    assert shift[13] == without[13]
    later = rows[16, VX] - rows[16, trail.X_BEFORE + VX] + shift[16]
    assert shift[[14, 15]] == pytest.approx([shift[13] + u * (later - shift[13])
                                             for u in (1 / 3, 2 / 3)], rel=1e-12)


def test_the_transition_is_the_derivative_of_the_motion():
    """Central differences of an arc: velocity turns against the body, offset and bias enter it."""
    T, spin, push = 0.01, 0.8, 0.6
    row = np.zeros(trail.row_width(4))
    row[:trail.S] = [1.0, 2.0, 0.3, 0.5, -0.2, 0.01, 0.0, 0.0, 0.05, -0.02]
    row[[trail.WITH_GYRO, trail.WITH_ACCEL]] = 1.0

    def moved(x):
        for _ in range(100):
            h = T / 100
            turn, c, s = (spin - x[5]) / (1.0 + x[6]), np.cos(x[2]), np.sin(x[2])
            x = x + h * np.array([c * x[3] - s * x[4], s * x[3] + c * x[4], turn,
                                  push - x[BAX] + turn * x[4], -x[BAY] - turn * x[3],
                                  0.0, 0.0, 0.0, turn * x[BAY], -turn * x[BAX]])
        return x

    later = np.zeros_like(row)
    later[trail.X_BEFORE:trail.P_BEFORE] = moved(row[:trail.S])
    F = smoothing.transition(row[None], later[None], np.array([T]))[0]
    step = 1e-5
    for column in range(trail.S):
        d = np.zeros(trail.S)
        d[column] = step
        wanted = (moved(row[:trail.S] + d) - moved(row[:trail.S] - d)) / (2 * step)
        # first order over 10 ms: terms of T^2 (1e-4) times speeds and rates below 1 are left out,
        # and how the turn of the offset (0.05 m/s^2) depends on the gyro: 0.05 * T
        np.testing.assert_allclose(F[:, column], wanted, atol=5e-4)
