"""The 81 combinations: counts by named criterion, Table I, symmetries, any geometry."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wheel_strategies import mobile_sets, numbers

from mecanum_base.core.combinations import table
from mecanum_base.core.combinations.verdict import judge
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels

BASE = layouts.rectangle(0.2, 0.15, 0.05)
FOUND = table.survey(BASE)
BY_PATTERN = {item.pattern: item for item in FOUND}
N = np.array([1, 1, -1, -1])  # parity of wheels 1 FR, 2 FL, 3 RL, 4 RR


def signs(pattern):
    return np.array([{'+': 1, '0': 0, '-': -1}[sign] for sign in pattern])


def test_the_counts_under_their_named_criteria():
    counts = table.count(FOUND)
    assert (counts.total, counts.no_slip, counts.parity_within_one) == (81, 19, 51)
    assert (counts.stalled, counts.not_stalled, counts.no_twist, counts.stop) == (30, 51, 3, 1)
    assert (counts.free_unique, counts.free_open, counts.free_slip) == (38, 32, 10)
    assert '51/30' in table.CAVEAT and 'stop' in table.CAVEAT


def test_every_row_of_table_i_has_its_direction_and_no_yaw():
    labelled = [item for item in FOUND if item.label]
    assert len(labelled) == 16
    for item in labelled:
        off = (item.compass - table.COMPASS[item.label] + 180) % 360 - 180
        assert off == pytest.approx(0.0, abs=1e-6)
        assert item.verdict.twist[2] == 0.0


def test_table_i_runs_the_same_way_with_free_idle_wheels_where_they_leave_no_choice():
    from mecanum_base.core.turning.two_wheel import free_motion
    for item in FOUND:
        if item.label and 0 < item.verdict.driven < 4:
            driven = np.flatnonzero(item.verdict.rates)
            motion = free_motion(BASE, driven, item.verdict.rates[driven])
            compass = math.degrees(math.atan2(motion.twist[0], -motion.twist[1]))
            off = (compass - table.COMPASS[item.label] + 180) % 360 - 180
            assert off == pytest.approx(0.0, abs=1e-6)
            assert motion.twist[2] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize('pattern', BY_PATTERN)
def test_verdicts_follow_from_parity_and_signs(pattern):
    verdict, s = BY_PATTERN[pattern].verdict, signs(pattern)
    assert verdict.parity == pytest.approx(N @ s)
    assert verdict.no_slip == (N @ s == 0)
    agree = (s * N)[s != 0]
    assert verdict.stalls == (np.all(agree > 0) or np.all(agree < 0))
    assert verdict.driven == np.count_nonzero(s)


@pytest.mark.parametrize('pattern', BY_PATTERN)
def test_reversing_all_wheels_reverses_the_motion(pattern):
    mirror = pattern.translate(str.maketrans('+-', '-+'))
    one, other = BY_PATTERN[pattern].verdict, BY_PATTERN[mirror].verdict
    np.testing.assert_allclose(one.twist, -other.twist, atol=1e-15)
    assert one.parity == -other.parity and one.stalls == other.stalls
    assert (one.free_idle, one.no_slip) == (other.free_idle, other.no_slip)


def test_stalling_combinations_really_balance_in_coulomb_friction():
    """Some roller forces within the friction limit balance the driven wheels at their limit."""
    from scipy.optimize import linprog
    directions = -np.sign(np.sin(BASE.roller))  # push of a positive rate along b
    lines = np.column_stack([np.cos(BASE.axle + BASE.roller), np.sin(BASE.axle + BASE.roller)])
    levers = BASE.x * lines[:, 1] - BASE.y * lines[:, 0]
    push = np.vstack([lines.T, levers]) * directions  # (3, 4): wrench of unit pushes
    for item in FOUND:
        rates = item.verdict.rates
        bounds = [(r, r) if r else (-1.0, 1.0) for r in rates]
        balanced = linprog(np.zeros(4), A_eq=push, b_eq=np.zeros(3), bounds=bounds).status == 0
        assert balanced == item.verdict.stalls


def test_no_criterion_that_treats_reversal_alike_can_give_51_motions():
    # stop is alone with itself: the class that holds it has an odd number of members
    for accept in (lambda v: v.no_slip, lambda v: v.stalls, lambda v: not v.moves):
        assert sum(accept(item.verdict) for item in FOUND) % 2 == 1


@given(mobile_sets(low=4, high=4), st.lists(numbers(-3, 3), min_size=4, max_size=4).map(np.array))
def test_the_parity_of_any_base_is_zero_exactly_for_rates_without_residual(wheels, rates):
    verdict = judge(wheels, rates)
    matrix = wheels_from_body(wheels)
    left = rates - matrix @ np.linalg.lstsq(matrix, rates, rcond=None)[0]
    if np.max(np.abs(left)) > 1e-6:
        assert verdict.parity != 0.0 and not verdict.no_slip
    rolling = matrix @ np.array([0.3, -0.2, 0.5])
    assert judge(wheels, rolling).no_slip


def test_unequal_speeds_get_a_verdict_but_no_label():
    item = table.combine(BASE, np.array([2.0, 1.0, 2.0, 1.0]))
    assert item.label == '' and item.pattern == '++++' and item.verdict.no_slip
    np.testing.assert_allclose(item.verdict.twist, [0.075, 0.025, 0.0], atol=1e-12)
    assert table.combine(BASE, np.full(4, 3.0)).label == 'N'


def test_the_file_may_list_its_wheels_in_any_order_and_turn_its_axles_round():
    order = [3, 0, 2, 1]
    other = Wheels(tuple(BASE.joint[i] for i in order), BASE.x[order], BASE.y[order],
                   BASE.axle[order] - [0, math.pi, 0, math.pi], BASE.roller[order],
                   BASE.radius[order])
    numbering = table.number_wheels(other)
    assert [other.joint[i] for i in numbering.order] == ['FR', 'FL', 'RL', 'RR']
    for one, two in zip(FOUND, table.survey(other)):
        assert one.pattern == two.pattern and one.label == two.label
        np.testing.assert_allclose(one.verdict.twist, two.verdict.twist, atol=1e-12)
        assert one.verdict.stalls == two.verdict.stalls
        assert one.verdict.free_idle == two.verdict.free_idle


def test_quadrants_are_counted_from_the_middle_of_the_wheels_and_not_from_base_link():
    moved = Wheels(BASE.joint, BASE.x + 0.5, BASE.y - 0.7, BASE.axle, BASE.roller, BASE.radius)
    numbering = table.number_wheels(moved)
    assert numbering.tlale and numbering.order == layouts.TLALE


def test_drive_rates_and_file_rates_are_inverse_to_each_other():
    turned = Wheels(BASE.joint, BASE.x, BASE.y, -BASE.axle, BASE.roller, BASE.radius)
    numbering, drive = table.number_wheels(turned), np.array([1.0, 2.0, -3.0, 4.0])
    rates = table.rates_of(numbering, drive)
    np.testing.assert_array_equal(rates, [-2.0, -1.0, 3.0, -4.0])
    np.testing.assert_array_equal(table.drive_of(numbering, rates), drive)


def test_wheels_that_do_not_stand_in_the_quadrants_keep_the_order_of_the_file():
    cross = layouts.swedish_ring(0.2, 0.05, np.radians([0.0, 90.0, 180.0, 270.0]))
    numbering = table.number_wheels(cross)
    assert not numbering.tlale and numbering.order == (0, 1, 2, 3)
    # wheels at 0 and 180 degrees drive sideways only: their own sign is kept
    assert numbering.forward.tolist() == [1.0, -1.0, 1.0, 1.0]
    assert all(item.label == '' for item in table.survey(cross))


def test_three_wheels_have_no_combinations():
    with pytest.raises(ValueError, match='4 wheels'):
        judge(layouts.swedish_ring(0.2, 0.05, [0.0, 2.0, 4.0]), np.ones(3))
