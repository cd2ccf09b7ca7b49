"""Slip that is known by construction: who slips, how far, and what it may do to the pose."""

import math

import numpy as np
import pytest
from staged_drive import (
    MS,
    RADIUS,
    T0,
    drive,
    estimator,
    frames,
    imu,
    is_sound,
    merged,
    miss,
    rectangle,
    run,
    staged,
    wheel_angles,
)

from mecanum_base.core.estimation.odometry import WheelOdometry
from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.records import WheelSample

REST = (0.9, (0.0, 0.0, 0.0))
STOP = (0.7, (0.0, 0.0, 0.0))
AHEAD = staged(REST, (2.2, (0.5, 0.0, 0.0)), STOP)
BEGIN, END, ADDED = 2.0, 2.5, 8.0  # s, s, rad/s
ROLLER = math.sin(math.pi / 4)  # travel along a roller axis at 45 degrees, of travel of the rim


def between(found, begin, end):
    return [e for e in found if T0 + begin * 1e9 <= e.stamp_ns <= T0 + end * 1e9]


@pytest.fixture(scope='module', params=[0, 2], ids=['FL', 'RL'])  # one a diagonal
def spun(request):
    """(wheel, estimator, estimates) of a drive in which one wheel spins free for half a second."""
    return (request.param, *drive(AHEAD, slip={request.param: (BEGIN, END, ADDED)}))


def test_a_wheel_that_spins_free_moves_the_pose_by_millimetres_where_wheels_alone_lose_many(spun):
    wheel, _, found = spun
    alone = WheelOdometry(rectangle(), EncoderConfig(counts_per_revolution=4096.0))
    for frame in frames(AHEAD, wheel_angles(AHEAD, slip={wheel: (BEGIN, END, ADDED)})):
        alone.handle(frame)
    lost = math.hypot(*(alone.pose[:2] - AHEAD.pose[-1, :2]))
    assert lost > 0.05  # 0.2 m of rim, a quarter of it in x and y, and the turn
    assert miss(found[-1], AHEAD)[0] < 0.008
    assert miss(found[-1], AHEAD)[1] < math.radians(0.4)


def test_the_wheel_that_spins_free_is_named_and_the_others_are_cleared(spun):
    wheel, _, found = spun
    probability = np.mean([e.slip.probability for e in between(found, 2.1, 2.48)], axis=0)
    assert probability[wheel] > 0.9
    assert np.delete(probability, wheel).max() < 0.5
    assert min(e.slip.body_probability for e in between(found, 2.1, 2.48)) > 0.5


def test_the_slip_rate_is_the_added_rate_and_its_sum_the_slip_angle(spun):
    wheel, _, found = spun
    inside = between(found, 2.2, 2.48)
    # 0.4 rad/s = 2 cm/s of rim: what velocity is known to beside a creeping wheel
    assert np.mean([e.slip.rate[wheel] for e in inside]) == pytest.approx(ADDED, abs=0.4)
    gained = between(found, 2.9, 3.0)[0].slip.angle - between(found, 1.8, 1.9)[0].slip.angle
    assert gained[wheel] == pytest.approx(ADDED * (END - BEGIN), abs=0.3)
    assert np.abs(np.delete(gained, wheel)).max() < 0.3


def test_one_episode_tells_when_which_how_and_how_far(spun):
    wheel, subject, _ = spun
    (episode,) = subject.episodes
    assert episode.wheels == (wheel,)
    assert episode.kind == 'single'
    assert (episode.start_ns - T0) / 1e9 == pytest.approx(BEGIN, abs=0.05)
    # the smoothed slip speed falls below 4 cm/s some 40 ms after the end
    assert (episode.end_ns - T0) / 1e9 == pytest.approx(END, abs=0.1)
    assert episode.probability > 0.99
    way = ADDED * (END - BEGIN) * RADIUS * ROLLER
    assert episode.distance == pytest.approx(way, rel=0.1)
    assert episode.peak == pytest.approx(ADDED * RADIUS * ROLLER, rel=0.15)


def test_the_slip_twist_is_what_the_wheels_claim_beyond_the_body(spun):
    wheel, _, found = spun
    mean = np.mean([e.slip.twist for e in between(found, 2.2, 2.48)], axis=0)
    # least squares of four rows (hand): a quarter of the rim speed, signs of that wheel
    sideways, turning = [(-1, -1), (1, 1), (1, -1), (-1, 1)][wheel]
    quarter = ADDED * RADIUS / 4
    assert mean == pytest.approx([quarter, sideways * quarter, turning * quarter / 0.35],
                                 abs=0.02)


def test_the_ratio_falls_for_the_spinning_wheel_and_is_one_for_the_rest(spun):
    wheel, _, found = spun
    ratio = between(found, 2.44, 2.48)[0].slip.ratio
    assert ratio.shape == (5,)
    # window 0.5 s: 5 m/s of rim for 0.5/(0.5 + 0.4) of what it turned, once it covers the slip
    assert ratio[wheel] < 0.75
    assert np.delete(ratio[:4], wheel) == pytest.approx(np.ones(3), abs=0.06)


def test_every_estimate_of_a_slipping_drive_is_sound(spun):
    assert all(map(is_sound, spun[2]))


def test_the_ratio_is_nan_at_rest_never_zero_or_infinite():
    _, found = drive(staged(REST, (1.0, (0.5, 0, 0))))
    assert np.isnan(between(found, 0.5, 0.8)[0].slip.ratio).all()
    moving = found[-1].slip.ratio
    assert np.isfinite(moving).all()
    assert moving == pytest.approx(np.ones(5), abs=0.03)


def test_wheels_that_a_strafe_leaves_slow_have_no_ratio_while_the_fast_ones_do():
    # forward and left at once: FL and RR stand, FR and RL turn at twice the rate
    _, found = drive(staged(REST, (1.5, (0.3, 0.3, 0))))
    ratio = found[-1].slip.ratio
    assert np.isnan(ratio[[0, 3]]).all()
    assert ratio[[1, 2]] == pytest.approx(np.ones(2), abs=0.03)


def test_the_shapes_of_a_slip_estimate_follow_the_number_of_wheels():
    _, found = drive(staged((0.2, (0, 0, 0))))
    slip = found[-1].slip
    assert slip.rate.shape == slip.angle.shape == slip.probability.shape == (4,)
    assert slip.ratio.shape == (5,)
    assert slip.twist.shape == (3,)
    assert slip.twist_covariance.shape == (3, 3)


def test_both_wheels_of_a_diagonal_that_spin_together_are_told_by_the_accelerometer():
    slip = {0: (BEGIN, END, ADDED), 3: (BEGIN, END, ADDED)}
    subject, found = drive(AHEAD, slip=slip)
    assert miss(found[-1], AHEAD)[0] < 0.03  # gyro and parity see nothing of it: 0.28 m alone
    (episode,) = subject.episodes
    assert (episode.kind, episode.wheels) == ('diagonal', (0, 3))


def test_a_short_shove_with_locked_wheels_is_followed_by_the_accelerometer():
    shove = staged(REST, (0.5, (0.6, 0, 0)), (1.2, (0, 0, 0)))
    subject = estimator()
    found = run(subject, merged(imu(shove), frames(shove, 0.0 * wheel_angles(shove))))
    assert shove.pose[-1, 0] == pytest.approx(0.3, abs=1e-3)  # wheels alone: not moved at all
    assert miss(found[-1], shove)[0] < 0.05
    assert {episode.kind for episode in subject.episodes} == {'pushed'}


def test_an_encoder_that_freezes_is_called_dead_and_costs_millimetres():
    motion = staged(REST, (2.5, (0.5, 0.1, 0.3)), STOP)
    angles = wheel_angles(motion)
    angles[1800:, 1] = angles[1800, 1]
    subject = estimator()
    found = run(subject, merged(imu(motion), frames(motion, angles)))
    assert miss(found[-1], motion)[0] < 0.012
    (episode,) = subject.episodes
    assert (episode.kind, episode.wheels) == ('encoder dead', (1,))


def test_a_wheel_that_is_silent_for_a_second_is_made_up_for_when_it_speaks_again():
    angles = wheel_angles(AHEAD)
    shown = angles.copy()
    shown[1800:2800, 2] = math.nan
    samples = [WheelSample(T0 + k * MS, shown[k], np.full(4, math.nan))
               for k in range(0, len(shown), 10)]
    subject = estimator()
    found = run(subject, merged(imu(AHEAD), samples))
    assert miss(found[-1], AHEAD)[0] < 0.006
    assert subject.episodes == ()
    assert all(map(is_sound, found))
