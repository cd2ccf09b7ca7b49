"""Drift figures against cases worked by hand."""

import math

import numpy as np
import pytest

from mecanum_base.accuracy.drift import SEGMENT, at_stamps, drift_of, path_of
from mecanum_base.accuracy.track import Track


def straight(length, step=0.05):
    """Truth along x."""
    x = np.linspace(0.0, length, round(length / step) + 1)
    return np.column_stack([x, np.zeros_like(x), np.zeros_like(x)])


def test_a_scale_error_of_one_percent_is_a_drift_of_one_percent_in_every_segment():
    truth = straight(12.0)
    drift = drift_of(truth * 1.01, truth)
    assert drift.segments == 28  # starts 0, 0.25, ... 6.75 m: (12 - 5)/0.25
    # exact up to rounding, segment ends fall on samples 5 cm apart
    assert math.sqrt(drift.segment_squares / drift.segments) == pytest.approx(0.01, rel=0.02)
    assert drift.final_share == pytest.approx(0.01)
    assert drift.final_yaw == 0.0


def test_a_wrong_heading_before_a_segment_does_not_count_in_it():
    truth = straight(10.0)
    c, s = math.cos(0.3), math.sin(0.3)
    turned = truth @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + [0.5, -0.2, 0.3]
    drift = drift_of(turned, truth)
    assert drift.segments > 0
    assert drift.segment_squares == pytest.approx(0.0, abs=1e-20)
    assert drift.final_yaw == pytest.approx(0.3)


def test_a_wrong_heading_within_a_segment_throws_its_end_off_by_the_chord():
    truth = straight(SEGMENT + 0.25)
    bent = truth.copy()
    c, s = math.cos(0.1), math.sin(0.1)
    bent[1:, :2] = np.column_stack([truth[1:, 0] * c, truth[1:, 0] * s])
    bent[1:, 2] = 0.1  # the heading errs after the first pose only
    drift = drift_of(bent, truth)
    assert drift.segments == 1
    assert math.sqrt(drift.segment_squares) == pytest.approx(2.0 * math.sin(0.05), rel=1e-6)


def test_position_errors_are_summed_as_squares():
    truth = straight(1.0, 0.5)
    pose = truth + np.array([[0.0, 0.0, 0.0], [0.3, 0.4, 0.0], [0.0, 1.0, 0.0]])
    drift = drift_of(pose, truth)
    assert drift.squares == pytest.approx(0.25 + 1.0)
    assert (drift.samples, drift.segments) == (3, 0)  # too short for a segment
    assert drift.final_share == pytest.approx(1.0)


def test_poses_between_stamps_are_interpolated_over_the_turn_of_yaw():
    track = Track(np.array([0, 10]), np.array([[0.0, 0.0, 3.1], [1.0, 2.0, -3.1]]))
    middle = at_stamps(track, np.array([5]))[0]
    assert middle[:2] == pytest.approx([0.5, 1.0])
    assert middle[2] == pytest.approx(math.pi)  # not 0


def test_the_path_counts_every_way_back():
    pose = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [0.0, 0.0, 1.0]])
    assert path_of(pose).tolist() == [0.0, 5.0, 10.0]
