import numpy as np
import pytest

from mecanum_base.demo.comparison import Track, episodes, slip_score, track_error


def stamps(count, step_ms=10):
    return np.arange(count, dtype=np.int64) * step_ms * 1_000_000


def test_a_track_that_is_the_truth_has_no_error():
    pose = np.column_stack([np.linspace(0, 1, 50), np.linspace(0, 2, 50), np.linspace(0, 7, 50)])
    track = Track(stamps(50), pose)
    error = track_error(track, track)
    assert error.rms_distance == 0.0
    assert error.final_yaw == pytest.approx(0.0, abs=1e-12)


def test_errors_are_taken_at_the_odometry_stamps_with_the_truth_interpolated():
    truth = Track(stamps(2, 1000), np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.5]]))
    odometry = Track(np.array([500_000_000]), np.array([[0.5, 0.3, 0.35]]))
    error = track_error(odometry, truth)
    assert error.final_distance == pytest.approx(0.3)  # truth is (0.5, 0, 0.25) half way
    assert error.final_yaw == pytest.approx(0.1)


def test_a_whole_turn_between_two_odometries_is_no_yaw_error():
    truth = Track(stamps(3), np.array([[0, 0, 3.1], [0, 0, 3.2], [0, 0, 3.3]], float))
    wrapped = Track(stamps(3), truth.pose - [0, 0, 2 * np.pi])
    assert track_error(wrapped, truth).final_yaw == pytest.approx(0.0, abs=1e-12)


def test_episodes_are_the_spans_of_true_flags():
    flags = np.array([0, 1, 1, 0, 0, 1], bool)
    spans = [(e.start_ns, e.end_ns) for e in episodes(flags, stamps(6))]
    assert spans == [(10_000_000, 20_000_000), (50_000_000, 50_000_000)]


def test_slip_score_finds_misses_delays_and_false_claims():
    speed = np.zeros((300, 4))
    speed[50:80, 1] = 0.2  # claimed 30 ms late
    speed[150:170, 2] = -0.1  # missed
    speed[200:202, 0] = 0.3  # too short to be asked for
    probability = np.zeros(300)
    probability[53:81] = 0.9
    probability[260:265] = 0.8  # nothing near: false
    score = slip_score(speed, stamps(300), probability, stamps(300))
    assert len(score.true) == 2
    assert score.found == 1
    assert score.delays == pytest.approx([0.03])
    assert [e.start_ns for e in score.false] == [2_600_000_000]
