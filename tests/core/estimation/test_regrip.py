"""The end of a slip that was not seen is no other slip, and what else is not taken for one."""

import math

import numpy as np
import pytest
from staged_drive import (
    DIAGONAL,
    GRIP,
    MS,
    RECTANGLE,
    T0,
    Motion,
    estimator,
    frames,
    imu,
    merged,
    rectangle,
    run,
    summed,
    unloaded,
)

from mecanum_base.core.estimation.hindsight import (
    GAP_TIME,
    SLOTS,
    corrections,
    keep,
    kept_travel,
    usable,
    youngest,
)
from mecanum_base.core.estimation.layout import (
    ALL_SLID,
    BAX,
    BAY,
    CHANGE,
    FIX_VX,
    FORCED,
    JUDGED,
    KICK,
    LAST_FRAME,
    LOCKED_FOR,
    LOOSE_FOR,
    OVER_FOR,
    PROBABILITY,
    REEL_SLOT,
    SIGMA,
    SLIP,
    SLOPE,
    SLOPE_FILL,
    STEP,
    TRAVEL,
    VX,
    VY,
    YAW,
)
from mecanum_base.core.estimation.regrip import (
    ENOUGH,
    believe_wheels,
    doubt_slip,
    gripped_again,
    jumped,
    known_to_grip,
    made_by_base,
    watch_regrip,
)
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.records import PoseSample


@pytest.mark.parametrize(('rate', 'top', 'gain', 'left'), [
    (0.05, 0.1, 0.0, 0.3),  # begun 2.2 s before it ends, all of it is taken again
    (0.05, 0.1, 0.08, 0.3), (0.05, 0.1, -0.08, 0.3),  # the wheels do not just keep their speed
    (0.05, 0.15, 0.0, 0.7), (0.05, 0.2, 0.0, 1.3),  # begun 3.2 and 4.2 s before, too early
])
def test_of_a_slip_not_seen_until_its_end_the_distance_of_the_last_seconds_comes_back(
        rate, top, gain, left):
    motion, angles, end, lost = unloaded(rate, top, gain)
    found = run(estimator(), merged(imu(motion), frames(motion, angles)))
    place = [(e.stamp_ns - T0) // MS for e in found]
    error = np.hypot(*(np.array([e.pose[:2] for e in found]) - motion.pose[place, :2]).T)
    seconds = np.array(place) * 1e-3
    before = np.searchsorted(seconds, end - GRIP)
    assert error[before] > 0.8 * (lost - 0.5 * top * GRIP)  # it is not seen while it lasts
    # believed to be another slip it would cost top * 3 s more: 1.4 to 2.7 times what was lost
    assert error[-1] < left * lost
    assert max(e.slip.body_probability for e in found
               if e.stamp_ns > T0 + round(1e9 * (end + 0.5))) < 0.2  # 0.5 is a claim
    step = np.hypot(*np.diff([e.pose[:2] for e in found], axis=0).T)
    speed = np.abs(motion.twist[:, :2]).max() * math.sqrt(2.0)
    assert step.max() < speed * 0.01 + lost * 0.01 / GAP_TIME  # the pose runs, it does not jump


def test_wheels_that_have_changed_their_speed_are_believed_to_slip_for_as_long_as_they_do():
    # the same slip, constant for 2 s, but of the wheels: they speed up within 0.2 s
    t = np.arange(5501) * 1e-3
    body = np.interp(t, [0.9, 1.4], [0.0, 0.5])[:, None] * np.array([1.0, 0.0, 0.0])
    claim = body + np.interp(t, [2.5, 2.7, 4.5, 4.7], [0.0, 0.15, 0.15, 0.0])[:, None] * DIAGONAL
    motion = Motion(t, body, np.gradient(body, 1e-3, axis=0), summed(body))
    found = run(estimator(), merged(imu(motion), frames(motion, summed(claim @ RECTANGLE.T))))
    # by hand: 0.15 m/s for 2 s are 0.3 m; 0.02 m/s^2 of offset alone would make 0.04 m
    assert np.hypot(*(found[-1].pose[:2] - motion.pose[-1, :2])) < 0.25 * 0.3
    while_it_slips = [e.slip.body_probability for e in found
                      if T0 + 2_900_000_000 < e.stamp_ns < T0 + 4_400_000_000]
    assert min(while_it_slips) > 0.5


def test_a_slip_that_the_base_makes_slowly_is_no_end_of_another_where_it_becomes_constant():
    # gravity: the base gains 0.25 m/s^2 along the rollers of a diagonal, up to 0.2 m/s
    t = np.arange(5501) * 1e-3
    wheels = np.interp(t, [0.9, 1.4], [0.0, 0.5])[:, None] * np.array([1.0, 0.0, 0.0])
    glide = np.interp(t, [2.5, 3.3, 4.1, 4.3], [0.0, 0.2, 0.2, 0.0])
    body = wheels + glide[:, None] * DIAGONAL
    motion = Motion(t, body, np.gradient(body, 1e-3, axis=0), summed(body))
    found = run(estimator(), merged(imu(motion), frames(motion, summed(wheels @ RECTANGLE.T))))
    at = np.array([(e.stamp_ns - T0) // MS for e in found])
    slips = np.array([e.slip.body_probability for e in found]) > 0.5
    assert slips[(at > 3200) & (at < 4100)].all()
    assert not slips[at > 4600].any()
    # by hand: it gets 0.5 0.2 0.8 + 0.2 0.8 + 0.5 0.2 0.2 = 0.26 m to where the wheels do not
    error = np.hypot(*(found[-1].pose[:2] - motion.pose[-1, :2]))
    assert error < 0.25 * 0.26


def test_where_no_snapshot_is_left_the_wheels_are_believed_from_here_on():
    motion, angles, end, _ = unloaded(0.05, 0.15)
    # a pose given while the wheels grip again: no snapshot from before it serves any more
    given = PoseSample(T0 + round((end - 0.12) * 1e3) * MS, np.zeros(3), 1e-6 * np.eye(3))
    found = run(estimator(), merged(imu(motion), frames(motion, angles), [given]))
    at = np.array([(e.stamp_ns - T0) * 1e-9 for e in found])
    slips = np.array([e.slip.body_probability for e in found]) > 0.5
    assert slips[at > end - 0.12].any()  # it is taken for another slip
    assert not slips[at > end + 0.8].any()


def test_the_slip_doubted_is_what_velocity_and_offset_may_be_wrong_by():
    _, memory = believed()
    memory.wheel[SLIP, 0] = 0.5  # of a wheel that grips: nobody believes in it
    memory.m[OVER_FOR] = 1.1 * ENOUGH
    before = memory.P.diagonal().copy()
    doubt_slip(memory)
    grown = memory.P.diagonal() - before
    # by hand: 0.2 m/s, and what makes 0.2 m/s in 2.5 s
    assert grown[[VX, VY]] == pytest.approx(0.2 ** 2)
    assert grown[[BAX, BAY]] == pytest.approx(0.08 ** 2)
    assert np.count_nonzero(grown) == 4
    assert memory.m[OVER_FOR] == 0.0
    assert memory.mode[0] == 1.0
    assert not memory.wheel[[SLIP, PROBABILITY]].any()


SLID = -0.2  # m/s of FR and RL


def believed(made=1.0):
    """(model, memory): FR and RL are believed to slip by SLID since 0.1 s.

    The base has made that slip, or the share ``made`` of it, since the snapshot 0.3 s ago.
    """
    body = estimator()._filter
    model, memory = body.model, body.memory
    memory.x[VX], memory.x[VY] = 0.5, 0.1
    memory.clock[JUDGED] = memory.clock[LAST_FRAME] = T0
    keep(memory, T0)
    memory.clock[JUDGED] = memory.clock[LAST_FRAME] = T0 + 300 * MS
    memory.x[VX] -= made * SLID * math.sqrt(0.5)
    memory.x[VY] -= made * SLID * math.sqrt(0.5)
    memory.wheel[STEP] = 0.3
    memory.wheel[[SLIP, PROBABILITY]] = np.array([[0.0, SLID, SLID, 0.0], [0.0, 1.0, 1.0, 0.0]])
    memory.wheel[CHANGE] = 0.005
    memory.clock[SLOPE_FILL] = 2 * SLOPE
    memory.m[LOCKED_FOR] = 0.1
    memory.m[KICK] = 0.1  # half of it has come within 0.1 s
    return model, memory


@pytest.mark.parametrize(('made', 'by_base'), [
    (1.0, True), (0.5, True), (1.9, True),  # all of it, half, and some of the drive besides
    (0.0, False), (0.3, False),  # the wheels have
    (2.5, False), (-1.0, False),  # base and wheels have both changed their speed
])
def test_who_has_made_the_slip_follows_from_the_speed_of_the_base(made, by_base):
    _, memory = believed(made)
    assert made_by_base(memory) is by_base


def test_what_the_wheels_have_corrected_is_no_speed_that_the_base_has_made():
    _, memory = believed(0.0)
    memory.x[VX] -= SLID * math.sqrt(0.5)
    memory.x[VY] -= SLID * math.sqrt(0.5)
    memory.m[FIX_VX] = memory.m[FIX_VX + 1] = -SLID * math.sqrt(0.5)
    assert not made_by_base(memory)


def test_just_after_another_slip_nobody_can_tell():
    _, memory = believed()
    n = memory.P.shape[0]
    memory.kept[memory.reel[REEL_SLOT], n + n * n + LOOSE_FOR] = 0.1
    assert not made_by_base(memory)


def test_corrections_are_told_in_the_axes_of_the_base():
    _, memory = believed(0.0)
    memory.m[FIX_VX] = 0.3
    memory.x[YAW] = math.pi / 2.0
    # by hand: along odom's x, which is to the right of a base that looks along y
    assert corrections(memory, T0 + 300 * MS, memory.reel[REEL_SLOT]) == pytest.approx((0.0, -0.3))


def test_the_youngest_snapshot_is_the_last_that_is_old_enough():
    memory = estimator()._filter.memory
    random = np.random.default_rng(6)
    now, kept = T0, []
    for _ in range(300):
        now += int(random.integers(1, 4)) * 10 * MS
        before = memory.reel[REEL_SLOT]
        keep(memory, now)
        if memory.reel[REEL_SLOT] != before:
            kept = [*kept[-(SLOTS - 1):], (now, int(memory.reel[REEL_SLOT]))]
        for age in (0, 100, 500, 1000):
            able = [slot for stamp, slot in kept if now - stamp >= age * MS]
            assert youngest(memory, now, age * MS) == (able[-1] if able else -1)


def count(model, memory):
    """What :data:`OVER_FOR` [s] gains in one frame of 10 ms."""
    before = memory.m[OVER_FOR]
    watch_regrip(model, memory, 0.01)
    return memory.m[OVER_FOR] - before


def test_constant_slip_that_the_base_has_made_counts():
    assert count(*believed()) == pytest.approx(0.01)


@pytest.mark.parametrize('spoil', [
    lambda m: m.wheel[CHANGE].__setitem__(slice(1, 3), 0.02),  # it changes
    lambda m: m.wheel[FORCED].__setitem__(1, 1.0),  # taken once more: not begun yet
    lambda m: m.wheel[PROBABILITY].__setitem__(slice(None), 1.0),  # all slide: ice, a wall
    lambda m: m.wheel[STEP].__setitem__(slice(None), 0.0),  # a hand pushes a base that stands
    lambda m: m.wheel[SLIP].__setitem__(slice(1, 3), -0.03),  # too little to tell
    lambda m: m.clock.__setitem__(SLOPE_FILL, 2 * SLOPE - 1),  # not seen for long enough
    lambda m: m.m.__setitem__(ALL_SLID, 1.0),  # so it may have been when the slip began
])
def test_what_may_well_be_slip_does_not_count(spoil):
    model, memory = believed()
    spoil(memory)
    assert count(model, memory) == 0.0


def test_slip_that_the_base_has_made_may_change_a_little():
    model, memory = believed()
    for change, counts in ((0.016, 0.01), (0.017, 0.0)):  # 12.5 mm/s and 2 % of 0.2 m/s
        memory.wheel[CHANGE, 1:3] = change
        assert count(model, memory) == pytest.approx(counts)


@pytest.mark.parametrize(('kick', 'counts'), [(0.055, False), (0.057, True)])
def test_slip_that_has_come_slowly_does_not_count(kick, counts):
    model, memory = believed()
    memory.m[KICK] = kick  # 28 % of 0.2 m/s are 0.056
    assert count(model, memory) == pytest.approx(0.01 if counts else 0.0)


def test_how_quickly_it_has_come_is_remembered_until_all_wheels_grip():
    model, memory = believed()
    memory.wheel[FORCED, 1] = 1.0  # also while it is taken once more
    for change, kick in ((0.15, 0.15), (0.02, 0.15)):
        memory.wheel[CHANGE, 1:3] = change
        count(model, memory)
        assert memory.m[KICK] == kick
    memory.m[LOCKED_FOR] = 0.0
    count(model, memory)
    assert memory.m[KICK] == 0.0


def test_that_all_wheels_have_slid_is_remembered_until_all_grip():
    # a base that meets a wall askew: at first all wheels slide, then one diagonal for as long as
    # it rubs along the wall; the base has been stopped by the wall, not by wheels that grip
    model, memory = believed()
    memory.clock[SLOPE_FILL] = 0  # also before a change of slip can be told
    memory.wheel[PROBABILITY] = 1.0
    count(model, memory)
    memory.clock[SLOPE_FILL] = 2 * SLOPE
    memory.wheel[PROBABILITY, ::3] = 0.0
    assert count(model, memory) == 0.0
    memory.m[LOCKED_FOR] = 0.0
    count(model, memory)
    memory.m[LOCKED_FOR], memory.m[KICK] = 0.1, 0.1
    assert count(model, memory) == pytest.approx(0.01)


def test_it_counts_anew_for_the_next_slip():
    model, memory = believed()
    memory.m[OVER_FOR] = 0.05
    memory.m[LOCKED_FOR] = 0.0
    watch_regrip(model, memory, 0.01)
    assert memory.m[OVER_FOR] == 0.0


def test_it_goes_back_to_before_the_slip_once_it_has_counted_for_long_enough():
    _, memory = believed()
    memory.m[OVER_FOR] = 0.5 * ENOUGH
    memory.m[LOCKED_FOR] = 0.28
    assert gripped_again(memory, T0 + 300 * MS) == -1
    memory.m[OVER_FOR] = 1.01 * ENOUGH
    assert gripped_again(memory, T0 + 300 * MS) == memory.reel[REEL_SLOT]
    memory.m[LOCKED_FOR] = 0.35  # the slip is older than the snapshot
    assert gripped_again(memory, T0 + 300 * MS) == -1


@pytest.mark.parametrize(('surely', 'sigma', 'believed_against'), [
    (True, 0.05, True), (True, 0.1, False), (False, 0.05, False),
])
def test_wheels_known_to_grip_are_believed_against_an_imu_that_is_wrong_from_before(
        surely, sigma, believed_against):
    model, memory = believed()
    memory.wheel[FORCED, 1:3] = 1.0
    memory.wheel[SIGMA] = sigma
    before = memory.P.copy()
    believe_wheels(model, memory, surely)
    # by hand: 0.2 m/s are more than three times 0.05 m/s; 0.08 m/s^2 make them in 2.5 s
    more = np.zeros(len(before))
    if believed_against:
        more[[VX, VY]] = 0.2 ** 2
        more[[BAX, BAY]] = 0.08 ** 2
    assert memory.P == pytest.approx(before + np.diag(more))
    assert memory.mode[0] == 1.0 and np.sum(memory.mode) == 1.0
    assert not np.any(memory.wheel[[FORCED, SLIP, PROBABILITY]])


@pytest.mark.parametrize(('lasted', 'made', 'known'), [
    (0.1, 1.0, True), (0.1, 0.0, False), (2.3, 1.0, False),
])
def test_what_the_base_makes_quickly_is_known_to_be_an_end(lasted, made, known):
    _, memory = believed(made)
    memory.clock[LAST_FRAME] += round((lasted - 0.1) * 1e9)
    memory.m[LOCKED_FOR] = lasted
    assert known_to_grip(memory) is known


def turned(speed, lasted=0.8):
    """(model, memory): the same, with FR and RL believed to slip for ``lasted`` s.

    FR and RL turn for ``speed`` (T,) m/s, 10 ms each, up to now; the base has not made the slip.
    """
    model, memory = believed(0.0)
    travel = np.concatenate([[0.0], np.cumsum(speed) * 0.01])
    for step, reached in enumerate(travel):
        memory.clock[LAST_FRAME] = T0 + 310 * MS + step * 10 * MS
        memory.clock[JUDGED] = memory.clock[LAST_FRAME]
        memory.wheel[TRAVEL, 1:3] = reached
        keep(memory, memory.clock[LAST_FRAME])
    memory.m[LOCKED_FOR] = lasted
    return model, memory


STEPS = np.arange(150)


@pytest.mark.parametrize(('speed', 'jumps'), [
    (np.full(150, 0.3), False),
    (0.3 - 0.005 * STEPS, False),  # -0.5 m/s^2 all the time
    (np.interp(STEPS, [90, 110], [0.3, 0.1]), True),  # by the slip, in 0.2 s
    (np.interp(STEPS, [90, 110], [0.3, 0.22]), False),  # by 0.4 of it
    (np.interp(STEPS, [90, 110], [0.3, 0.5]), False),  # to the other side
    (np.interp(STEPS, [20, 40], [0.3, 0.1]), False),  # long before
    (0.3 - 0.001 * STEPS - np.interp(STEPS, [90, 110], [0.0, 0.2]), True),
])
def test_a_wheel_jumps_where_its_speed_changes_at_once_by_about_the_slip(speed, jumps):
    _, memory = turned(speed)
    assert jumped(memory) is jumps


def test_whether_a_wheel_has_jumped_cannot_be_told_from_a_few_snapshots():
    _, memory = turned(np.full(20, 0.3))
    assert jumped(memory)


@pytest.mark.parametrize(('speed', 'lasted', 'change', 'counts'), [
    (np.full(150, 0.3), 0.8, 0.005, True),
    (np.full(150, 0.3), 0.8, 0.0095, True),  # 6 mm/s and 2 % of 0.2 m/s
    (np.full(150, 0.3), 0.8, 0.0105, False),
    (np.full(150, 0.3), 2.25, 0.005, False),  # slip that is real may have become constant
    (np.interp(STEPS, [90, 110], [0.3, 0.1]), 0.8, 0.005, False),  # the wheels have made it
])
def test_slip_that_is_constant_so_soon_counts_whoever_has_changed_speed_steadily(
        speed, lasted, change, counts):
    model, memory = turned(speed, lasted)
    memory.wheel[CHANGE] = change
    assert count(model, memory) == pytest.approx(0.01 if counts else 0.0)


def test_slip_too_large_to_have_gone_unseen_does_not_count():
    model, memory = turned(np.full(150, 0.3))
    memory.m[KICK] = 0.3
    memory.wheel[SLIP, 1:3] = -0.51
    assert count(model, memory) == 0.0
    memory.wheel[SLIP, 1:3] = -0.49
    assert count(model, memory) == pytest.approx(0.01)


@pytest.mark.parametrize('base', [rectangle(), rectangle(6), Carriers(
    name=('front', 'rear'), x=[0.3, -0.3], y=[0.0, 0.0], axle_offset=[-0.1, -0.1],
    half_track=[0.12, 0.12], wheel_radius=[0.05, 0.05], left_joint=('a', 'c'),
    right_joint=('b', 'd'), max_speed=[40.0, 40.0])], ids=['four', 'six', 'carriers'])
def test_a_snapshot_knows_the_travel_of_every_wheel(base):
    memory = estimator(base)._filter.memory
    travel = [float(i) for i in range(1, base.count + 1)]
    memory.wheel[TRAVEL] = travel
    keep(memory, T0)
    slot = memory.reel[REEL_SLOT]
    memory.wheel[TRAVEL] = 0.0
    assert [kept_travel(memory, slot, i) for i in range(base.count)] == travel


def test_sums_that_hold_the_slip_not_seen_are_no_sign_of_another():
    motion, angles, end, _ = unloaded(0.05, 0.15)
    subject = estimator()
    memory = subject._filter.memory
    slips = taken_back = False
    for sample in merged(imu(motion), frames(motion, angles)):
        subject.handle(sample)
        now = memory.clock[LAST_FRAME]
        if slips and memory.m[LOCKED_FOR] == 0.0:
            taken_back = True
            assert usable(memory, now, 0, 2600 * MS) == -1
            break
        slips = now > T0 + round(1e9 * end) and memory.m[LOCKED_FOR] > 0.0
    assert taken_back


def test_the_offset_that_was_dragged_along_is_learnt_anew():
    motion, angles, end, _ = unloaded(0.05, 0.15)
    subject = estimator()
    found = run(subject, merged(imu(motion), frames(motion, angles)))
    x = subject._filter.memory.x
    # 3 s at 0.05 m/s^2 have drawn it there; 2.5 s of wheels that are known to 5 mm/s follow
    assert np.abs(x[[BAX, BAY]]).max() < 0.02
    assert found[-1].stamp_ns > T0 + round(1e9 * (end + 2.5))
