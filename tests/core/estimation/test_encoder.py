"""Counters and joint angles to unwrapped wheel angles: wraps, gaps, jumps and bad readings."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.estimation.encoder import Reading, WheelAngles
from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.records import TickSample, WheelSample

MS = 1_000_000
TURN = 2.0 * math.pi


def angles(count=2, top=20.0, counts=1000.0, **more):
    return WheelAngles(EncoderConfig(counts_per_revolution=counts, **more), count,
                       np.full(count, top))


def ticks(stamp_ms, *counts):
    return TickSample(stamp_ms * MS, np.array(counts, dtype=np.int64))


def positions(stamp_ms, *radians, velocity=None):
    blank = [math.nan] * len(radians)
    return WheelSample(stamp_ms * MS, np.array(radians, dtype=float),
                       np.array(blank if velocity is None else velocity, dtype=float))


def last_angle(subject, *samples):
    for sample in samples:
        reading = subject.read(sample)
        assert isinstance(reading, Reading), reading
    return reading.angle


def test_the_first_reading_only_arms_whatever_the_counter_shows():
    reading = angles().read(ticks(0, 123456, -98765))
    assert reading.angle.tolist() == [0.0, 0.0]
    assert reading.jumped == ()


def test_counts_become_radians_by_the_resolution_of_each_wheel():
    subject = angles(counts=np.array([1000.0, 250.5]))
    found = last_angle(subject, ticks(0, 7, 7), ticks(10, 32, 32))
    assert found == pytest.approx([25 / 1000 * TURN, 25 / 250.5 * TURN], abs=1e-15)


# an int64 message cannot carry an unsigned 64-bit counter
@pytest.mark.parametrize(('bits', 'signed'), [(16, True), (16, False), (32, True), (32, False),
                                              (64, True)])
@pytest.mark.parametrize('forward', [True, False])
def test_a_counter_that_wraps_goes_on_counting(bits, signed, forward):
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
    before, after = (high - 4, low + 5) if forward else (low + 5, high - 4)
    subject = angles(count=1, counter_bits=bits)
    found = last_angle(subject, ticks(0, before), ticks(10, after))
    # from high - 4 over high to low + 5 are ten counts
    assert found == pytest.approx([math.copysign(10, 1 if forward else -1) / 1000 * TURN])


@given(st.sampled_from([16, 32, 64]), st.lists(st.integers(-60, 60), min_size=1, max_size=30),
       st.integers(-(1 << 63), (1 << 63) - 1))
def test_any_walk_of_a_wrapping_counter_adds_up_to_its_steps(bits, steps, start):
    half = 1 << bits - 1
    subject = angles(count=1, counter_bits=bits)
    counter, total = start, 0
    subject.read(ticks(0, (counter + half) % (2 * half) - half))
    for k, step in enumerate(steps):
        counter, total = counter + step, total + step
        reading = subject.read(ticks(10 * (k + 1), (counter + half) % (2 * half) - half))
    # 1e-12: thirty roundings of a number below 12
    assert reading.angle[0] == pytest.approx(total / 1000 * TURN, abs=1e-12)


def test_the_sign_is_applied_to_counts_positions_and_speeds():
    config = {'sign': np.array([1, -1])}
    assert last_angle(angles(**config), ticks(0, 0, 0), ticks(10, 9, 9)) == pytest.approx(
        [0.009 * TURN, -0.009 * TURN])
    assert last_angle(angles(**config), positions(0, 1, 1), positions(10, 1.1, 1.1)) == (
        pytest.approx([0.1, -0.1]))
    blank = (math.nan, math.nan)
    assert last_angle(angles(**config), positions(0, *blank, velocity=(2, 2)),
                      positions(10, *blank, velocity=(2, 2))) == pytest.approx([0.02, -0.02])


def test_sign_and_resolution_must_fit_the_number_of_wheels():
    with pytest.raises(ConfigError, match='sign'):
        angles(sign=np.array([1, 1, 1]))
    with pytest.raises(ConfigError, match='counts_per_revolution'):
        angles(counts=np.array([100.0, 100.0, 100.0]))


def test_a_repeated_stamp_is_refused_and_changes_nothing():
    subject = angles()
    subject.read(positions(0, 0, 0))
    assert subject.read(positions(0, 0.5, 0.5)) == 'duplicate stamp'
    assert last_angle(subject, positions(10, 0.1, 0.2)) == pytest.approx([0.1, 0.2])


def test_a_stamp_that_goes_back_is_refused_and_changes_nothing():
    subject = angles()
    subject.read(ticks(10, 0, 0))
    assert subject.read(ticks(9, 500, 500)) == 'stamp before the last'
    assert subject.stamp_ns == 10 * MS
    assert last_angle(subject, ticks(20, 10, 20)) == pytest.approx([0.01 * TURN, 0.02 * TURN])


def test_a_jump_no_wheel_could_make_re_anchors_that_wheel_alone():
    subject = angles()
    subject.read(ticks(0, 0, 0))
    jump = subject.read(ticks(10, 30_000, 10))
    assert jump.jumped == (0,)
    assert jump.angle == pytest.approx([0.0, 0.01 * TURN])
    after = subject.read(ticks(20, 30_010, 20))
    assert after.jumped == ()
    assert after.angle == pytest.approx([0.01 * TURN, 0.02 * TURN])


def test_a_wheel_somewhat_faster_than_its_top_speed_is_believed():
    # 1.5 times the top speed of 20 rad/s: pushed, downhill or a cautious robot file
    subject = angles()
    assert last_angle(subject, positions(0, 0, 0), positions(10, 0.3, -0.3)) == pytest.approx(
        [0.3, -0.3])


def test_after_a_long_gap_a_long_way_is_no_jump():
    subject = angles()
    subject.read(positions(0, 0, 0))
    reading = subject.read(positions(3000, 55.0, -55.0))
    assert reading.jumped == ()
    assert reading.angle == pytest.approx([55.0, -55.0])


@pytest.mark.parametrize('direction', [1.0, -1.0])
def test_positions_that_wrap_at_two_pi_go_on_turning(direction):
    subject = angles(position_wrap='two_pi')
    rolled = [direction * 0.15 * k for k in range(100)]
    shown = [math.fmod(angle, TURN) % TURN for angle in rolled]
    found = last_angle(subject, *(positions(10 * k, a, a) for k, a in enumerate(shown)))
    assert found == pytest.approx([rolled[-1]] * 2, abs=1e-12)


def test_positions_between_minus_pi_and_pi_are_unwrapped_as_well():
    subject = angles(position_wrap='two_pi')
    shown = [math.remainder(0.15 * k, TURN) for k in range(100)]
    found = last_angle(subject, *(positions(10 * k, a, -a) for k, a in enumerate(shown)))
    assert found == pytest.approx([0.15 * 99, -0.15 * 99], abs=1e-12)


def test_without_a_wrap_in_the_robot_file_a_fall_by_two_pi_is_a_jump():
    subject = angles()
    subject.read(positions(0, TURN - 0.05, 0.0))
    assert subject.read(positions(10, 0.05, 0.0)).jumped == (0,)


def test_speeds_are_integrated_where_no_position_is_given_and_it_is_said():
    subject, blank = angles(), (math.nan, math.nan)
    subject.read(positions(0, *blank, velocity=(3.0, -1.0)))
    reading = subject.read(positions(20, *blank, velocity=(3.0, -1.0)))
    assert reading.integrated
    assert reading.angle == pytest.approx([0.06, -0.02])


def test_positions_win_over_speeds_where_both_are_given():
    subject = angles()
    subject.read(positions(0, 0, 0, velocity=(9, 9)))
    reading = subject.read(positions(10, 0.01, 0.02, velocity=(9, 9)))
    assert not reading.integrated
    assert reading.angle == pytest.approx([0.01, 0.02])


def test_a_message_of_some_wheels_moves_those_and_catches_up_with_the_rest_later():
    subject = angles()
    subject.read(positions(0, 0, 0))
    partial = subject.read(positions(10, 0.1, math.nan))
    assert partial.valid.tolist() == [1.0, 0.0]
    assert partial.angle == pytest.approx([0.1, 0.0])
    whole = subject.read(positions(20, 0.2, 0.2))
    assert whole.valid.tolist() == [1.0, 1.0]
    assert whole.angle == pytest.approx([0.2, 0.2])


def test_a_wheel_missing_for_long_may_have_gone_far():
    subject = angles()
    subject.read(positions(5000, 0, 0))
    for k in range(1, 100):
        subject.read(positions(5000 + 10 * k, 0.1 * k, math.nan))
    back = subject.read(positions(6000, 10.0, 10.0))
    assert back.jumped == ()
    assert back.angle == pytest.approx([10.0, 10.0])


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_one_wheel_that_is_no_number_leaves_the_others_in_use(bad):
    subject = angles()
    subject.read(positions(0, 0, 0))
    reading = subject.read(positions(10, bad, 0.1))
    assert reading.valid.tolist() == [0.0, 1.0]
    assert reading.angle == pytest.approx([0.0, 0.1])
    assert last_angle(subject, positions(20, 0.2, 0.2)) == pytest.approx([0.2, 0.2])


def test_a_message_without_any_number_is_refused():
    subject = angles()
    subject.read(positions(0, 0, 0))
    assert subject.read(positions(10, math.nan, math.inf)) == 'no finite wheel reading'
    assert last_angle(subject, positions(20, 0.2, 0.2)) == pytest.approx([0.2, 0.2])


@pytest.mark.parametrize('sample', [ticks(10, 1, 2, 3), positions(10, 0.1)])
def test_a_message_for_another_number_of_wheels_is_refused(sample):
    subject = angles()
    subject.read(positions(0, 0, 0))
    assert subject.read(sample) == 'wrong number of wheels'


def test_after_a_restart_the_next_reading_arms_anew():
    subject = angles()
    last_angle(subject, ticks(0, 0, 0), ticks(10, 10, 10))
    subject.restart()
    assert subject.stamp_ns is None
    assert last_angle(subject, ticks(5, 9999, -9999)) == pytest.approx([0.0, 0.0])
    assert last_angle(subject, ticks(15, 10_009, -9999)) == pytest.approx([0.01 * TURN, 0.0])


def test_readings_are_not_changed_by_later_ones():
    subject = angles()
    subject.read(positions(0, 0, 0))
    first = subject.read(positions(10, 0.1, 0.1))
    kept = first.angle.copy()
    subject.read(positions(20, 0.3, 0.3))
    assert first.angle.tolist() == kept.tolist()


@given(st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)), min_size=2, max_size=40))
def test_angles_are_the_way_from_the_first_position_whatever_the_path(path):
    subject = angles(top=40.0)
    for k, (a, b) in enumerate(path):
        reading = subject.read(positions(10 * k, a, b))
    # 1e-14 a step: sums of differences round
    assert reading.angle == pytest.approx(np.subtract(path[-1], path[0]), abs=1e-12)


def test_a_wheel_that_never_sends_is_named_once_others_have():
    subject = angles(3)
    assert subject.absent() == ()
    subject.read(positions(0, 0.0, math.nan, 0.0))
    subject.read(positions(10, 0.1, math.nan, 0.1))
    assert subject.absent() == (1,)
    subject.read(positions(20, 0.2, 0.0, 0.2))
    assert subject.absent() == ()
