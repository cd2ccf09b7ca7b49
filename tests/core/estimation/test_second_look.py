"""Slip that begins slowly, on all wheels at once, and what the pose may do when it is found."""

import math

import numpy as np
import pytest
from staged_drive import (
    RECTANGLE,
    T0,
    at_start,
    estimator,
    frames,
    imu,
    is_sound,
    merged,
    miss,
    rectangle,
    run,
    staged,
    summed,
)

from mecanum_base.core.estimation.frame import arm, step_frame
from mecanum_base.core.estimation.hindsight import SLOTS, hidden, keep, suspect, usable, wait
from mecanum_base.core.estimation.layout import (
    BAX,
    BAY,
    CALM,
    FIX_BX,
    FIX_BY,
    FIX_PX,
    FIX_PY,
    FIX_VX,
    FIX_VY,
    FORCED,
    JUDGED,
    REEL_SLOT,
    SHAKE,
    VX,
    VY,
    K,
)
from mecanum_base.core.estimation.odometry import WheelOdometry
from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.estimation.standstill import settle
from mecanum_base.core.records import PoseSample

REST = (0.9, (0.0, 0.0, 0.0))
STOP = (0.7, (0.0, 0.0, 0.0))
AHEAD = staged(REST, (4.0, (0.5, 0.0, 0.0)), STOP)
BEGIN, GROWN, OVER = 2.0, 3.0, 3.2  # s


def claimed(direction, top):
    """Angles of wheels that claim ``direction`` beyond the motion, up to ``top`` m/s, slowly."""
    share = np.interp(AHEAD.t, [BEGIN, GROWN, OVER], [0.0, 1.0, 0.0])
    twist = AHEAD.twist + top * share[:, None] * np.array(direction)
    return summed(twist @ RECTANGLE.T)


@pytest.fixture(scope='module', params=[((1.0, 0.0, 0.0), 0.5), ((0.5, 0.5, 0.0), 0.7)],
                ids=['all wheels', 'one diagonal'])
def crept(request):
    """(angles, estimator, estimates); 0.5 m/s^2 of slip is 5 mm/s a frame: no frame shows it."""
    angles = claimed(*request.param)
    subject = estimator()
    return angles, subject, run(subject, merged(imu(AHEAD), frames(AHEAD, angles)))


def test_slip_that_no_single_frame_shows_costs_a_tenth_of_what_the_wheels_lose(crept):
    angles, _, found = crept
    alone = WheelOdometry(rectangle(), EncoderConfig(counts_per_revolution=4096.0))
    for frame in frames(AHEAD, angles):
        alone.handle(frame)
    lost = np.hypot(*(alone.pose[:2] - AHEAD.pose[-1, :2]))
    assert lost > 0.2  # by hand: 0.5 m/s over a triangle of 1.2 s is 0.3 m
    assert miss(found[-1], AHEAD)[0] < 0.1 * lost


def test_it_is_one_episode_that_is_noticed_before_it_has_grown(crept):
    _, subject, found = crept
    first = next(e for e in found if e.slip.body_probability > 0.5)
    assert BEGIN < (first.stamp_ns - T0) / 1e9 < BEGIN + 0.6
    assert len(subject.episodes) == 1


def test_the_pose_that_is_published_takes_no_step_when_the_slip_is_found(crept):
    """Between frames of 10 ms the base drives 5 mm; what is corrected comes in over 0.15 s."""
    _, _, found = crept
    place = np.array([e.pose[:2] for e in found])
    step = np.hypot(*np.diff(place, axis=0).T)
    assert step.max() < 0.5 * 0.01 + 0.004


def test_every_estimate_around_the_second_look_is_sound(crept):
    assert all(map(is_sound, crept[2]))


def test_the_same_readings_lead_to_the_same_bits_again(crept):
    angles, _, found = crept
    again = run(estimator(), merged(imu(AHEAD), frames(AHEAD, angles)))
    assert all(np.array_equal(a.pose, b.pose) for a, b in zip(found, again))


def test_a_new_pose_given_during_a_slip_is_not_undone_by_a_second_look():
    angles = claimed((1.0, 0.0, 0.0), 0.5)
    given = PoseSample(T0 + 2_150_000_000, np.array([10.0, -3.0, 0.0]), 1e-6 * np.eye(3))
    found = run(estimator(), merged(imu(AHEAD), frames(AHEAD, angles), [given]))
    at = AHEAD.pose[2150, 0]
    wanted = np.array([10.0 + AHEAD.pose[-1, 0] - at, -3.0])
    # the slip of 0.15 s before the pose was given stays unseen: 0.08 m/s at most, for 1 s
    assert np.hypot(*(found[-1].pose[:2] - wanted)) < 0.1


def test_a_base_that_stands_does_not_move_in_odom_while_it_learns_its_biases():
    drive = staged((0.6, (0.0, 0.0, 0.0)), (8.0, (0.6, 0.0, 0.0)), (2.5, (0.0, 0.0, 0.0)))
    angles = summed(drive.twist @ RECTANGLE.T)
    found = run(estimator(), merged(imu(drive, gyro_bias=0.01), frames(drive, angles)))
    at_rest = [e for e in found if e.stamp_ns > T0 + 10_000_000_000]
    assert len(at_rest) > 50
    place = np.array([e.pose[:2] for e in at_rest])
    assert np.ptp(place, axis=0).max() < 1e-4  # the last corrections while driving run out


@pytest.mark.parametrize('forced, calm', [(0.0, 1.0), (1.0, 0.0)])
def test_frames_taken_once_more_are_all_judged_even_after_a_standstill(forced, calm):
    model, memory = at_start()
    memory.wheel[FORCED, 2] = forced  # as in a second look
    settle(memory, 4, np.zeros(4), model.resolution)
    assert memory.m[CALM] == calm


def test_the_snapshot_found_is_the_oldest_one_of_the_age_asked_for():
    _, memory = at_start()
    random = np.random.default_rng(5)
    now, kept = T0, []
    for _ in range(400):  # frames about every 20 ms, some lost; the ring comes round
        now += int(random.integers(1, 4)) * 10_000_000
        before = memory.reel[REEL_SLOT]
        keep(memory, now)
        if memory.reel[REEL_SLOT] != before:
            kept = [*kept[-(SLOTS - 1):], (now, memory.reel[REEL_SLOT])]
        for young, old in ((25, 150), (240, 320), (960, 1040), (240, 1920)):
            able = [slot for stamp, slot in kept
                    if young * 1_000_000 <= now - stamp <= old * 1_000_000]
            assert usable(memory, now, young * 1_000_000, old * 1_000_000) == (
                able[0] if able else -1)


def sure_at_start():
    """The same, its velocity known to 0.02 m/s and the offset of its accelerometer exactly."""
    model, memory = at_start()
    memory.P[VX, VX] = memory.P[VY, VY] = 0.02 ** 2
    memory.P[BAX, BAX] = memory.P[BAY, BAY] = 1e-8
    memory.clock[JUDGED] = T0
    return model, memory


def snapshot(memory, stamp):
    """Take one and give its place."""
    keep(memory, stamp)
    return int(memory.reel[REEL_SLOT])


def test_time_that_passes_at_rest_is_no_slip_when_the_base_starts():
    model, memory = sure_at_start()
    memory.m[FIX_VX], memory.m[FIX_BX] = 0.001, -9.0  # m/s, m/s^2: corrected on the way here
    memory.clock[JUDGED] = T0 - 30_000_000  # calm frames since: the snapshot is younger
    slot = snapshot(memory, T0)
    for _ in range(53):
        wait(memory, 0.01)
    slips = np.zeros(4)
    hidden(model, memory, T0 + 500_000_000, slot, slips)
    # by hand: nothing has been corrected since, so that d = 0; one frame of 30 ms more or less
    # would be 0.27 m/s, no wait at all 4.8 m/s
    assert not slips.any()


@pytest.mark.parametrize(('turned', 'found'), [(0.0, False), (0.1, True)])
def test_on_wheels_that_stand_a_wrong_offset_is_likelier_than_a_glide(turned, found):
    model, memory = sure_at_start()
    slot = snapshot(memory, T0)
    memory.m[FIX_VX] = 0.1 * math.sqrt(2.0)  # 0.1 m/s along each roller axis
    memory.x[K + 4:K + 8] += turned
    slips = np.zeros(4)
    hidden(model, memory, T0 + 300_000_000, slot, slips)
    # sigma is 0.02 m/s and a little: 0.1 m/s is between 4 and 6 of it
    assert slips.all() == slips.any() == found


@pytest.mark.parametrize(('corrected', 'crept', 'slips'), [
    (0.08, 0.0, [0, 0, 0, 0]),  # below 4.5 sigma of 0.02 m/s
    (0.0, 0.08, [0, 0, 0, 0]),
    (0.08, 0.08, [0, 1, 1, 0]),  # both show the same slip, on the diagonal that creeps
    (-0.08, 0.08, [0, 0, 0, 0]),  # one makes up for the other
])
def test_what_the_filter_has_taken_for_creep_is_part_of_a_hidden_slip(corrected, crept, slips):
    model, memory = sure_at_start()
    slot = snapshot(memory, T0)
    # m/s along the rollers of FR and RL, whose axes are (1, 1)/sqrt(2)
    memory.m[FIX_VX] = memory.m[FIX_VY] = corrected * math.sqrt(0.5)
    memory.x[[K + 9, K + 10]] = crept
    memory.x[K + 4:K + 8] += 0.1  # the wheels turn
    found = np.zeros(4)
    hidden(model, memory, T0 + 300_000_000, slot, found)
    assert found.tolist() == slips


@pytest.mark.parametrize(('corrected', 'found'), [(0.185, False), (0.24, True)])
def test_vibration_counts_for_more_than_is_learnt_of_it(corrected, found):
    """Floor and contacts add half to the noise that second differences show."""
    model, memory = sure_at_start()
    slot = snapshot(memory, T0)
    memory.m[SHAKE] = 0.06 ** 2  # (m/s^2)^2/Hz: 0.033 m/s in 0.3 s, 0.040 with that half
    memory.m[FIX_VX] = corrected * math.sqrt(2.0)  # along each roller axis
    memory.x[K + 4:K + 8] += 0.1  # the wheels turn
    slips = np.zeros(4)
    hidden(model, memory, T0 + 300_000_000, slot, slips)
    # with the 0.02 m/s of the snapshot 4.5 sigma are 0.203 m/s; without that half 0.173
    assert slips.all() == slips.any() == found


@pytest.mark.parametrize(('grown', 'oldest', 'youngest'), [
    ([0.1, 0.11, 0.13], 240, 600),  # 1 and 3 cm/s more are what a wrong offset may make
    ([0.1, 0.2, 0.22], 960, 1050),  # since 0.48 s ago it is twice as much
])
def test_it_goes_back_about_as_far_as_the_sums_show_slip(grown, oldest, youngest):
    model, memory = sure_at_start()
    for i, sigma in ((VX, 0.005), (VY, 0.005), (BAX, 0.02), (BAY, 0.02)):
        memory.P[i, i] = sigma ** 2  # the offset alone: 1 and 2 cm/s in 0.48 and 0.96 s
    now = T0 + 1200_000_000
    for k in range(30):  # slip that older snapshots show more of, m/s along the rollers
        stamp = T0 + 40_000_000 * k
        memory.m[FIX_VX] = -math.sqrt(2.0) * np.interp((now - stamp) * 1e-9, [0.28, 0.52, 1.0],
                                                       grown)
        memory.clock[JUDGED] = stamp
        keep(memory, stamp)
    memory.m[FIX_VX] = 0.0
    memory.m[FIX_VY] = 1e-9  # something has been corrected
    slips = np.zeros(4)
    slot = suspect(model, memory, now, slips)
    assert slips.all()
    assert oldest <= (now - memory.kept_ns[slot, 0]) / 1_000_000 <= youngest


def test_a_frame_of_a_standstill_lets_time_pass():
    model, memory = at_start()
    settle(memory, 4, np.zeros(4), model.resolution)
    arm(model, memory, T0, np.zeros(4))
    memory.m[FIX_BX], memory.m[FIX_BY] = -0.9, 0.3
    step_frame(model, memory, T0 + 10_000_000, np.zeros(4), np.ones(4))
    assert memory.m[FIX_PX] == pytest.approx(-0.009)
    assert memory.m[FIX_PY] == pytest.approx(0.003)
