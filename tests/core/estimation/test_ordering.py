"""The merge by stamp: any arrival order within the wait gives one sequence."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mecanum_base.core.estimation.ordering import FAR_NS, StampOrder

MS = 1_000_000
WAIT = 20 * MS


def pushed(arrivals, wait=WAIT):
    """(items in order of leaving with the flush, refused ones) of (stamp, kind) arrivals."""
    order, left, refused = StampOrder(wait), [], []
    for stamp, kind in arrivals:
        why, ready = order.push(stamp, kind, (stamp, kind))
        left.extend(ready)
        if why:
            refused.append((stamp, kind, why))
    return left + order.flush(), refused


def stream():
    """200 Hz of kind 2 and 100 Hz of kind 4, half of them with equal stamps."""
    return [(k * 5 * MS, 2) for k in range(200)] + [(k * 10 * MS, 4) for k in range(100)]


@pytest.mark.parametrize('seed', range(50))
def test_every_arrival_order_within_the_wait_gives_the_same_sequence(seed):
    random = np.random.default_rng(seed)
    samples = stream()
    # each arrives up to 19 ms after its stamp: nobody is overtaken by more than the wait
    arrival = [stamp + random.uniform(0.0, 19.0 * MS) for stamp, _ in samples]
    shuffled = [samples[k] for k in np.argsort(arrival)]
    assert shuffled != sorted(samples)
    left, refused = pushed(shuffled)
    assert left == sorted(samples)
    assert refused == []


def test_a_sample_later_than_the_wait_is_dropped_and_said_to_be_late():
    left, refused = pushed([(0, 0), (100 * MS, 0), (79 * MS, 0), (110 * MS, 0)])
    assert refused == [(79 * MS, 0, 'late')]
    assert (79 * MS, 0) not in left


def test_a_sample_exactly_as_late_as_the_wait_is_still_taken():
    left, refused = pushed([(0, 0), (100 * MS, 0), (80 * MS, 0)])
    assert refused == []
    assert left == [(0, 0), (80 * MS, 0), (100 * MS, 0)]


def test_samples_leave_as_soon_as_a_stamp_newer_by_more_than_the_wait_is_seen():
    order = StampOrder(WAIT)
    assert order.push(0, 0, 'a') == ('', [])
    assert order.push(20 * MS, 0, 'b') == ('', [])
    assert order.push(20 * MS + 1, 0, 'c') == ('', ['a'])


def test_one_stream_alone_is_never_held_longer_than_the_wait():
    order, age = StampOrder(WAIT), []
    for k in range(500):
        _, ready = order.push(k * 5 * MS, 2, k * 5 * MS)
        age.extend(k * 5 * MS - stamp for stamp in ready)
    assert len(age) >= 490
    assert max(age) <= WAIT + 5 * MS


def test_no_wait_at_all_still_keeps_the_stamps_in_order():
    left, refused = pushed([(0, 0), (10, 0), (5, 0), (20, 0)], wait=0)
    assert left == [(0, 0), (10, 0), (20, 0)]
    assert refused == [(5, 0, 'late')]


def test_equal_stamps_leave_in_the_order_of_their_kinds_then_of_arrival():
    order = StampOrder(WAIT)
    for kind, name in ((4, 'wheels'), (2, 'first imu'), (0, 'reset'), (2, 'second imu')):
        order.push(7, kind, name)
    assert order.flush() == ['reset', 'first imu', 'second imu', 'wheels']


def test_the_flush_gives_what_waits_and_leaves_nothing():
    order = StampOrder(WAIT)
    order.push(10, 0, 'b')
    order.push(5, 0, 'a')
    assert order.flush() == ['a', 'b']
    assert order.flush() == []


def test_one_wrong_stamp_far_ahead_does_not_make_the_others_late():
    far = 3600 * 1000 * MS
    left, refused = pushed([(0, 0), (5 * MS, 0), (far, 0), (10 * MS, 0), (15 * MS, 0)])
    assert [stamp for stamp, _ in left] == [0, 5 * MS, 10 * MS, 15 * MS]
    assert [why for *_, why in refused] in ([], ['stamp far ahead'])


def test_a_second_stamp_far_ahead_shows_that_the_clock_has_really_moved():
    far = 3600 * 1000 * MS
    left, refused = pushed([(0, 0), (far, 0), (far + 5 * MS, 0), (far + 60 * MS, 0)])
    assert left == [(0, 0), (far, 0), (far + 5 * MS, 0), (far + 60 * MS, 0)]
    assert refused == []


def test_two_wrong_stamps_far_from_each_other_are_no_witnesses_of_one_another():
    hour = 3600 * 1000 * MS
    left, refused = pushed([(0, 0), (hour, 0), (2 * hour, 0), (5 * MS, 0)])
    assert left == [(0, 0), (5 * MS, 0)]
    assert refused[0][2] == 'stamp far ahead'


def test_many_stamps_far_behind_in_a_row_tell_that_the_clock_went_back():
    order = StampOrder(WAIT)
    order.push(100_000 * MS, 0, None)
    for k in range(7):
        order.push(k * 5 * MS, 0, None)
        assert not order.went_back()
    order.push(35 * MS, 0, None)
    assert order.went_back()


def test_a_few_old_stamps_among_good_ones_are_only_late():
    order = StampOrder(WAIT)
    for k in range(30):
        order.push(100_000 * MS + k * 5 * MS, 0, None)
        assert order.push(k, 0, None)[0] == 'late'
        assert not order.went_back()


def test_after_clearing_any_stamp_is_welcome():
    order = StampOrder(WAIT)
    order.push(FAR_NS, 0, 'old')
    order.clear()
    assert order.newest is None
    assert order.push(0, 0, 'new') == ('', [])
    assert order.flush() == ['new']


@given(st.lists(st.tuples(st.integers(0, 300), st.integers(0, 5)), max_size=60))
def test_what_leaves_is_sorted_and_nothing_is_lost_without_being_named(arrivals):
    arrivals = [(stamp * MS, kind) for stamp, kind in arrivals]
    left, refused = pushed(arrivals)
    assert left == sorted(left)
    assert sorted(left + [(stamp, kind) for stamp, kind, _ in refused]) == sorted(arrivals)
