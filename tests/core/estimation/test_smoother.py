"""What later frames say of earlier ones: against the truth and a batch solution; bit identity."""

import dataclasses

import numpy as np
import pytest
from staged_drive import (
    RECTANGLE,
    T0,
    estimator,
    frames,
    imu,
    merged,
    run,
    staged,
    summed,
    wheel_angles,
)

from mecanum_base.core.estimation import smoother, smoothing
from mecanum_base.core.estimation.layout import PX
from mecanum_base.core.records import PoseSample

REST, STOP = (0.7, (0.0, 0.0, 0.0)), (0.6, (0.0, 0.0, 0.0))
AHEAD = staged(REST, (2.6, (0.5, 0.0, 0.0)), STOP)
BEGIN, GROWN, OVER = 1.5, 2.5, 2.7  # s of slip ahead that grows to 0.25 m/s and goes again
SEEN, ENDED = BEGIN + 0.283, OVER - 0.057  # where it is 0.05 m/s along the roller axes, by hand


def slipping_angles():
    share = np.interp(AHEAD.t, [BEGIN, GROWN, OVER], [0.0, 0.25, 0.0])
    return summed((AHEAD.twist + share[:, None] * np.array([1.0, 0.0, 0.0])) @ RECTANGLE.T)


def samples_of(motion, angles, more=()):
    return merged(imu(motion), frames(motion, angles), more)


def smoothed_run(samples, every=None):
    """(estimates, Smoothed); the past is asked for after ``every`` samples, and at the end."""
    subject, found, parts = estimator(smoothed=True), [], []
    for number, sample in enumerate(samples):
        found += subject.handle(sample)
        if every and number % every == 0:
            parts += subject.past()
    found += subject.flush()
    parts += subject.past(last=True)
    whole = (np.concatenate([getattr(p.smoothed(), f.name) for p in parts])
             for f in dataclasses.fields(smoother.Smoothed))
    return found, smoother.Smoothed(*whole)


@pytest.fixture(scope='module')
def slid():
    return smoothed_run(samples_of(AHEAD, slipping_angles()))


def truth_at(stamp_ns):
    return (np.asarray(stamp_ns) - T0) // 1_000_000


def rms(error):
    return float(np.sqrt(np.mean(np.sum(np.square(error), axis=1))))


def test_every_encoder_estimate_has_its_row_in_order(slid):
    found, past = slid
    assert past.stamp_ns.tolist() == [e.stamp_ns for e in found if e.source == 'encoder']
    assert past.track.shape == (len(past.stamp_ns), 12) and past.slip.shape[1] == 9
    assert np.isfinite(past.track).all() and np.isfinite(past.slip).all()
    assert (past.slip[:, 1::2] >= 0.0).all() and (past.slip[:, -1] <= 1.0).all()


def test_odometry_is_the_same_to_the_last_bit_whether_the_past_is_kept_or_not(slid):
    plain = run(estimator(), samples_of(AHEAD, slipping_angles()))
    assert len(plain) == len(slid[0])
    for a, b in zip(plain, slid[0]):
        assert np.array_equal(a.pose, b.pose) and np.array_equal(a.twist, b.twist)
        assert np.array_equal(a.pose_covariance, b.pose_covariance)
        assert np.array_equal(a.slip.probability, b.slip.probability)


def test_without_being_asked_for_nothing_is_kept():
    subject = estimator()
    run(subject, samples_of(AHEAD, slipping_angles())[:400])
    assert subject.past(last=True) == ()


def test_in_a_slip_velocity_and_slip_come_closer_to_the_truth(slid):
    found, past = slid
    at = truth_at(past.stamp_ns)
    slipping = (AHEAD.t[at] > BEGIN) & (AHEAD.t[at] < OVER)
    truth = AHEAD.twist[at][:, :2]
    causal = np.array([e.twist[:2] for e in found if e.source == 'encoder'])
    assert rms((past.track[:, 3:5] - truth)[slipping]) < 0.2 * rms((causal - truth)[slipping])
    really = (AHEAD.t[at] > SEEN) & (AHEAD.t[at] < ENDED)
    told = np.array([e.slip.body_probability for e in found if e.source == 'encoder']) > 0.5
    learnt = past.slip[:, -1] > 0.5
    assert np.sum(learnt != really) < 0.2 * np.sum(told != really)


def test_the_onset_of_a_slip_is_found_before_it_could_be_told(slid):
    found, past = slid
    told = min(e.stamp_ns for e in found if e.slip.body_probability > 0.5)
    learnt = past.stamp_ns[np.argmax(past.slip[:, -1] > 0.5)]
    assert told - learnt > 100_000_000  # ns
    assert abs((learnt - T0) / 1e9 - SEEN) < 0.05


def test_where_all_wheels_grip_the_track_is_the_same_within_its_covariance():
    motion = staged(REST, (1.5, (0.4, 0.2, 0.5)))
    found, past = smoothed_run(samples_of(motion, wheel_angles(motion)))
    causal = np.array([e.pose for e in found if e.source == 'encoder'])
    covariance = np.array([e.pose_covariance for e in found if e.source == 'encoder'])
    sigma = np.sqrt(np.stack([covariance[:, i, i] for i in range(3)], axis=1))
    assert (np.abs(past.track[:, :3] - causal) < 3.0 * sigma + 1e-4).all()
    truth = motion.twist[truth_at(past.stamp_ns)][:, :2]
    told = np.array([e.twist[:2] for e in found if e.source == 'encoder'])
    assert rms(past.track[:, 3:5] - truth) < rms(told - truth)
    # with more to go by, no position is less sure; calm frames repeat the covariance of the last
    # judged one in odom (25 ms of its growth, under a twentieth of it here)
    assert (past.track[:, 6] <= 1.05 * covariance[:, 0, 0]).all()
    assert (past.track[:, 8] <= 1.05 * covariance[:, 1, 1]).all()


def test_however_often_the_past_is_asked_for_it_is_the_same_to_the_last_bit(monkeypatch):
    monkeypatch.setattr(smoother, 'PIECE', 700_000_000)
    monkeypatch.setattr(smoother, 'AHEAD', 400_000_000)
    samples = samples_of(AHEAD, slipping_angles())
    _, once = smoothed_run(samples)
    _, often = smoothed_run(samples, every=7)
    for field in dataclasses.fields(smoother.Smoothed):
        assert np.array_equal(getattr(once, field.name), getattr(often, field.name))


def test_pieces_join_without_a_seam(monkeypatch):
    """Forgetting in 50 ms leaves e^-20 of what lies a second ahead."""
    monkeypatch.setattr(smoothing, 'FORGET', 0.05)
    samples = samples_of(AHEAD, slipping_angles())
    _, whole = smoothed_run(samples)
    monkeypatch.setattr(smoother, 'PIECE', 310_000_000)
    monkeypatch.setattr(smoother, 'AHEAD', 1_000_000_000)
    _, parts = smoothed_run(samples)
    np.testing.assert_array_equal(parts.stamp_ns, whole.stamp_ns)
    np.testing.assert_allclose(parts.track, whole.track, atol=1e-8)


def test_a_pose_given_from_outside_does_not_move_what_lies_before():
    at = 2000  # ms, in the middle of the slip
    given = PoseSample(T0 + at * 1_000_000, np.array([10.0, -3.0, 1.0]), 1e-6 * np.eye(3))
    found, past = smoothed_run(samples_of(AHEAD, slipping_angles(), [given]))
    assert past.stamp_ns.tolist() == [e.stamp_ns for e in found if e.source == 'encoder']
    before = past.stamp_ns < given.stamp_ns
    error = past.track[before, :2] - AHEAD.pose[truth_at(past.stamp_ns[before]), :2]
    assert np.hypot(*error.T).max() < 0.05
    after = past.track[~before, :2] - given.pose[:2]
    assert np.hypot(*after.T).max() < 1.5  # 0.5 m/s for 2.3 s, and what is left of the slip


def test_a_frame_that_breaks_the_numbers_leaves_the_rows_before_it():
    subject, found = estimator(smoothed=True), []
    samples = samples_of(AHEAD, slipping_angles())
    for number, sample in enumerate(samples):
        if number == len(samples) // 2:
            subject._filter.memory.x[PX] = np.nan
        found += subject.handle(sample)
    found += subject.flush()
    past = [piece.smoothed() for piece in subject.past(last=True)]
    assert all(np.isfinite(part.track).all() for part in past)
    told = [e.stamp_ns for e in found if e.source == 'encoder']
    assert [s for part in past for s in part.stamp_ns.tolist()] == told
    assert len(told) < len(frames(AHEAD, slipping_angles()))
