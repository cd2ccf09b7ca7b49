"""The stopping rules of the interface contract, section 3, one by one."""

import numpy as np
import pytest

from mecanum_base.core.command.stopping import (
    DISABLED,
    DRIVING,
    IDLE,
    NOT_FINITE,
    NOT_PLANAR,
    STOPPED,
    TIMED_OUT,
    WHILE_DISABLED,
    Stopping,
)

SECOND = 1_000_000_000
FORWARD = np.array([0.4, 0.1, 0.0])
TURN = np.array([0.0, 0.0, 0.3])
WANTED = [0.4, 0.1, 0.3]


def moving(now_ns=0):
    rules = Stopping(0.5)
    assert rules.accept(FORWARD, TURN, now_ns)
    return rules


def modes(rules):
    return [change.mode for change in rules.take_transitions()]


def test_without_a_command_the_base_stands():
    rules = Stopping(0.5)
    assert rules.mode == IDLE and rules.at_once
    assert not rules.wanted(100 * SECOND).any()
    assert rules.take_transitions() == ()


def test_a_command_is_followed_until_its_time_out_counted_from_arrival():
    rules = moving(now_ns=10 * SECOND)
    assert rules.wanted(10 * SECOND) == pytest.approx(WANTED)
    assert rules.wanted(10 * SECOND + SECOND // 2) == pytest.approx(WANTED)
    assert not rules.wanted(10 * SECOND + SECOND // 2 + 1).any()
    assert rules.mode == TIMED_OUT and not rules.at_once  # a ramp, not zeros at once
    assert modes(rules) == [DRIVING, TIMED_OUT]


def test_each_transition_is_told_once_with_its_reason():
    rules = moving()
    for now in range(0, 3 * SECOND, SECOND // 50):
        rules.wanted(now)
    told = rules.take_transitions()
    assert [change.mode for change in told] == [DRIVING, TIMED_OUT]
    assert '0.5 s' in told[1].reason
    rules.stop('fault')
    rules.stop('fault')
    assert modes(rules) == [STOPPED]


def test_a_new_command_drives_again_after_a_time_out():
    rules = moving()
    rules.wanted(SECOND)
    rules.accept(FORWARD, TURN, 2 * SECOND)
    assert rules.wanted(2 * SECOND) == pytest.approx(WANTED)


@pytest.mark.parametrize('bad', [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize('place', range(6))
def test_a_command_that_is_not_finite_is_rejected_and_the_last_valid_one_runs_out(bad, place):
    rules = moving()
    parts = np.zeros(6)
    parts[place] = bad
    assert not rules.accept(parts[:3], parts[3:], SECOND // 4)
    assert rules.rejected == {NOT_FINITE: 1}
    assert rules.wanted(SECOND // 4) == pytest.approx(WANTED)
    assert not rules.wanted(SECOND * 6 // 10).any()  # the rejected one did not renew the time


@pytest.mark.parametrize('place', [2, 3, 4])
def test_parts_that_a_planar_base_cannot_serve_are_ignored_and_counted(place):
    rules = Stopping(0.5)
    parts = np.array([0.4, 0.1, 0.0, 0.0, 0.0, 0.3])
    parts[place] = 0.7
    assert rules.accept(parts[:3], parts[3:], 0)
    assert rules.rejected == {NOT_PLANAR: 1}
    assert rules.wanted(0) == pytest.approx(WANTED)


def test_disabling_means_zeros_at_once_and_enabling_needs_a_new_command():
    rules = moving()
    rules.enable(False, 'test')
    assert rules.mode == DISABLED and rules.at_once and not rules.wanted(1).any()
    assert not rules.accept(FORWARD, TURN, 2)
    assert rules.rejected == {WHILE_DISABLED: 1}
    rules.enable(True, 'test')
    assert rules.mode == IDLE and not rules.wanted(3).any()
    assert rules.accept(FORWARD, TURN, 4)
    assert rules.wanted(4) == pytest.approx(WANTED)
    assert modes(rules) == [DRIVING, DISABLED, IDLE, DRIVING]


def test_a_stop_forgets_the_old_command_and_a_new_one_ends_it():
    rules = moving()
    rules.stop('the clock jumped')
    assert rules.mode == STOPPED and rules.at_once and not rules.wanted(1).any()
    assert rules.accept(FORWARD, TURN, 2)
    assert rules.wanted(2) == pytest.approx(WANTED)


def test_a_stop_does_not_end_disabled():
    rules = Stopping(0.5, enabled=False)
    rules.stop('fault')
    assert rules.mode == DISABLED
    rules.enable(True, 'test')
    assert rules.mode == IDLE


def test_switching_to_the_present_state_is_no_transition():
    rules = moving()
    rules.take_transitions()
    rules.enable(True, 'again')
    assert rules.mode == DRIVING and rules.take_transitions() == ()
