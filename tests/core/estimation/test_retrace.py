"""The compiled pass backwards, run as plain Python, against the one for all frames at once."""

import numpy as np

from mecanum_base.core.estimation import smoothing, trail
from mecanum_base.core.estimation.retrace import retrace
from mecanum_base.core.estimation.trail import S

COUNT = 14  # rows, every second one judged


def random_rows():
    """Rows of a base that drives a curve: covariances carried by F, with noise, then reduced."""
    random = np.random.default_rng(5)
    stamp = np.cumsum(random.integers(8, 12, COUNT)) * 1_000_000
    rows = np.zeros((COUNT, trail.row_width(4)))
    rows[:, :S] = random.normal(size=(COUNT, S))
    rows[:, trail.X_BEFORE:trail.P_BEFORE] = rows[:, :S] + 0.01 * random.normal(size=(COUNT, S))
    rows[:, [trail.WITH_GYRO, trail.WITH_ACCEL]] = 1.0
    rows[9, trail.WITH_ACCEL] = 0.0
    rows[1::2, trail.WAS_JUDGED] = 1.0
    size = 10.0 ** random.uniform(-6, 0, S)  # standard deviations of very different units
    P = np.diag(size ** 2)
    for k in range(1, COUNT, 2):
        T = np.array([(stamp[k] - stamp[k - 2]) * 1e-9 if k > 1 else 0.01])
        F = smoothing.transition(rows[[max(k - 2, 0)]], rows[[k]], T)[0]
        P = F @ P @ F.T + np.diag((0.1 * size) ** 2)
        P = 0.5 * (P + P.T)
        rows[k, trail.P_BEFORE:trail.FLAGS] = P.reshape(-1)
        h = random.normal(size=S) / size
        gain = P @ h / (h @ P @ h + 1.0)
        P = P - np.outer(gain, h @ P)
        P = 0.5 * (P + P.T)
        rows[k, trail.P_AFTER:trail.X_BEFORE] = P.reshape(-1)
    return stamp, rows, size


def test_both_ways_agree_to_rounding():
    stamp, rows, size = random_rows()
    judged = np.flatnonzero(rows[:, trail.WAS_JUDGED])
    T = np.diff(stamp[judged]) * 1e-9
    share = np.exp(-T / smoothing.FORGET)
    share[2] = 0.0  # a standstill
    change = rows[judged, :S] - rows[judged, trail.X_BEFORE:trail.P_BEFORE]
    shift, smooth = np.empty(change.shape), np.empty((len(judged), S, S))
    retrace(rows, judged, T, share, smoothing.LEAST, smoothing.RIDGE, shift, smooth)
    wanted_shift, wanted = smoothing.traced(rows[judged], T, share, change)
    assert np.abs(wanted_shift).max() > 1e-3
    # correlations of condition 1e6 lose six of sixteen digits
    np.testing.assert_allclose(shift, wanted_shift, atol=1e-9 * np.abs(wanted_shift).max())
    np.testing.assert_allclose(smooth / np.outer(size, size), wanted / np.outer(size, size),
                               atol=1e-9)


def test_the_pass_is_taken_where_kernels_are_compiled(monkeypatch):
    stamp, rows, _ = random_rows()
    plain = smoothing.look_back(stamp, rows)
    monkeypatch.setattr(smoothing, 'COMPILED', True)
    monkeypatch.setattr(smoothing, 'traced', None)
    found = smoothing.look_back(stamp, rows)
    assert not np.array_equal(plain, rows[:, :plain.shape[1]])
    np.testing.assert_allclose(found, plain, rtol=1e-7, atol=1e-9)
