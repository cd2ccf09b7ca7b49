"""Slip figures against cases worked by hand."""

import numpy as np
import pytest

from mecanum_base.accuracy.slip_score import score_of, spans

DIAGONALS = ((0, 3), (1, 2))


def timeline(seconds=4.0):
    return np.arange(0.0, seconds, 0.01)


def test_a_claim_30_ms_late_is_counted_sample_by_sample():
    t = timeline()
    speed = np.zeros((len(t), 4))
    speed[100:150, 1] = -0.2  # 50 samples of true slip, either sign
    body = np.zeros(len(t))
    body[103:152] = 0.9  # 3 late, 2 too long
    wheel = np.zeros((len(t), 4))
    wheel[:, 2] = 0.9  # the other wheel of the same diagonal
    score = score_of(t, speed, body, wheel, DIAGONALS)
    assert (score.hits, score.false_alarms, score.misses) == (47, 2, 3)
    assert score.delays == pytest.approx((0.03,))
    assert (score.missed_episodes, score.false_episodes) == (0, 0)  # it touches true slip
    assert (score.diagonal_right, score.diagonal_all) == (47, 47)
    assert (score.true_samples, score.samples) == (50, 400)
    assert score.hours == pytest.approx(3.99 / 3600.0)


def test_a_claim_far_from_any_slip_is_a_false_episode_and_a_silent_one_is_missed():
    t = timeline()
    speed = np.zeros((len(t), 4))
    speed[50:80, 0] = 0.1
    body = np.zeros(len(t))
    body[300:310] = 1.0
    score = score_of(t, speed, body, np.zeros((len(t), 4)), DIAGONALS)
    assert (score.hits, score.false_alarms, score.misses) == (0, 10, 30)
    assert (score.missed_episodes, score.false_episodes, score.delays) == (1, 1, ())
    assert score.diagonal_all == 0


def test_slip_between_two_and_five_cm_a_second_is_not_counted():
    t = timeline()
    speed = np.full((len(t), 4), 0.03)
    score = score_of(t, speed, np.ones(len(t)), np.zeros((len(t), 4)), DIAGONALS)
    assert (score.hits, score.false_alarms, score.misses, score.false_episodes) == (0, 0, 0, 0)


def test_the_wrong_diagonal_is_wrong():
    t = timeline()
    speed = np.zeros((len(t), 4))
    speed[10:30, 3] = 0.5
    wheel = np.zeros((len(t), 4))
    wheel[:20, 0], wheel[20:, 1] = 1.0, 1.0
    score = score_of(t, speed, np.ones(len(t)), wheel, DIAGONALS)
    assert (score.diagonal_right, score.diagonal_all) == (10, 20)
    assert score_of(t, speed, np.ones(len(t)), wheel, ()).diagonal_all == 0


def test_spans_reach_from_the_first_to_the_last_true_sample():
    flag = np.array([True, True, False, True])
    assert spans(flag, np.array([0.0, 1.0, 2.0, 3.0])) == [(0.0, 1.0), (3.0, 3.0)]
