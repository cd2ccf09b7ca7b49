"""Turns: centres, pivots, two driven wheels with locked and with free idle wheels (T24-T33)."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from wheel_strategies import mobile_sets, numbers, twists

from mecanum_base.core import se2
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.turning import centre, pivot, two_wheel

TRACK, WHEELBASE, RADIUS = 0.4, 0.6, 0.05
FR, FL, RL, RR = layouts.TLALE
angles = numbers(0.35, 1.2)


def base(angle=math.pi / 4):
    return layouts.rectangle(WHEELBASE / 2, TRACK / 2, RADIUS, angle)


@given(twists)
def test_the_centre_of_rotation_stays_where_it_is(twist):
    assume(abs(twist[2]) > 0.01)
    place = np.append(centre.centre_of(twist), 0.0)
    after = se2.compose(se2.exp(0.7 * twist), place)
    np.testing.assert_allclose(after[:2], place[:2], atol=1e-9 * (1 + np.hypot(*place[:2])))
    np.testing.assert_allclose(centre.twist_about(place[:2], twist[2]), twist, atol=1e-9)


def test_a_translation_has_no_centre():
    assert centre.centre_of(np.array([0.3, -0.2, 0.0])) is None
    assert centre.centre_of(np.zeros(3)) is None
    turn = centre.turn_of_twist(base(), np.array([0.3, -0.2, 0.0]))
    assert turn.centre is None and math.isinf(turn.radius)


@given(mobile_sets(), twists)
def test_rates_of_a_turn_give_the_turn_back(wheels, twist):
    assume(abs(twist[2]) > 0.05)
    there = centre.turn_of_twist(wheels, twist)
    back = centre.turn_of_rates(wheels, there.rates)
    np.testing.assert_allclose(back.centre, there.centre, rtol=1e-5, atol=1e-6)
    assert np.max(np.abs(back.residual)) < 1e-8 * (1 + np.max(np.abs(there.rates)))


@pytest.mark.parametrize('index', range(4))
@given(angle=angles, yaw_rate=numbers(0.2, 2.0))
def test_the_pivot_wheel_stands_and_the_others_agree(index, angle, yaw_rate):
    turn = pivot.pivot_turn(base(angle), index, yaw_rate)
    assert turn.rates[index] == pytest.approx(0.0, abs=1e-12)
    assert turn.radius == pytest.approx(math.hypot(TRACK, WHEELBASE) / 2)
    assert math.hypot(*turn.twist[:2]) == pytest.approx(yaw_rate * turn.radius)


@given(angles, numbers(0.2, 2.0))
def test_the_rates_about_rl_are_in_the_ratio_of_t25_corrected(angle, yaw_rate):
    turn = pivot.pivot_turn(base(angle), RL, yaw_rate)
    q = turn.rates
    cot = 1 / math.tan(angle)
    assert pivot.pivot_yaw_rate(TRACK, WHEELBASE, angle, RADIUS, q[FR]) == pytest.approx(yaw_rate)
    assert -RADIUS * q[FL] / (WHEELBASE * cot) == pytest.approx(yaw_rate)
    assert RADIUS * q[RR] / TRACK == pytest.approx(yaw_rate)


def test_equal_rates_plus_minus_0_plus_do_not_pivot_without_slip():
    rates = np.zeros(4)
    rates[[FR, FL, RR]] = (1.0, -1.0, 1.0)
    assert np.max(np.abs(centre.turn_of_rates(base(), rates).residual)) == pytest.approx(0.25)


@given(angles, st.lists(numbers(-9, 9), min_size=4, max_size=4).map(np.array))
def test_the_spin_rate_from_all_four_wheels_is_the_general_one(angle, rates):
    general = np.zeros(4)
    general[list(layouts.TLALE)] = rates
    turn = centre.turn_of_rates(base(angle), general)
    assert pivot.spin_yaw_rate(TRACK, WHEELBASE, angle, RADIUS, rates) == pytest.approx(
        turn.twist[2], abs=1e-9)


def test_the_numbers_of_the_worked_example():
    front, side = two_wheel.tlale_radii(0.4, 0.6, math.pi / 4)
    assert front == pytest.approx(0.5) and side == pytest.approx(0.5)
    front, side = two_wheel.tlale_radii(0.4, 0.6, math.radians(30))
    assert front == pytest.approx(0.4155, abs=5e-5) and side == pytest.approx(0.7196, abs=5e-5)


@given(angles, numbers(0.2, 2.0))
def test_locked_wheels_turn_about_the_crossing_of_their_roller_axes(angle, yaw_rate):
    wheels = base(angle)
    radii = two_wheel.tlale_radii(TRACK, WHEELBASE, angle)
    driven_radii = two_wheel.tlale_driven_radii(TRACK, WHEELBASE, angle)
    for radius, driven_radius, locked, driven, sign in (
            (radii[0], driven_radii[0], (RL, RR), (FR, FL), -1),
            (radii[1], driven_radii[1], (FL, RL), (FR, RR), 1)):
        turn = two_wheel.locked_turn(wheels, locked, yaw_rate)
        np.testing.assert_allclose(turn.rates[list(locked)], 0.0, atol=1e-9)
        assert turn.radius == pytest.approx(radius)
        assert turn.rates[driven[0]] == pytest.approx(sign * turn.rates[driven[1]])
        for wheel in driven:
            reach = math.hypot(wheels.x[wheel] - turn.centre[0], wheels.y[wheel] - turn.centre[1])
            assert reach == pytest.approx(driven_radius)
        held = two_wheel.locked_motion(wheels, turn.rates)
        assert np.max(np.abs(held.residual)) < 1e-9
    assert two_wheel.locked_turn(wheels, (RL, RR), 1.0).centre[0] < 0  # behind the base


def test_locked_wheels_with_parallel_rollers_allow_no_turn():
    assert two_wheel.locked_turn(base(), (FL, RR), 1.0) is None
    assert two_wheel.crossing(base(), FL, RR) is None


@pytest.mark.parametrize(('driven', 'rates', 'turns'), [
    ((FR, FL), (1.0, -1.0), True), ((FR, FL), (1.0, 1.0), False),
    ((FR, RR), (1.0, 1.0), True), ((FR, RR), (1.0, -1.0), False)])
def test_free_idle_wheels_turn_or_translate_by_the_sign_rule(driven, rates, turns):
    wheels = base(0.9)
    motion = two_wheel.free_motion(wheels, driven, rates)
    idle = [i for i in range(4) if i not in driven]
    np.testing.assert_allclose(motion.rates[list(driven)], rates, atol=1e-9)
    assert np.max(np.abs(motion.residual)) < 1e-9
    if turns:
        np.testing.assert_allclose(motion.rates[idle], 0.0, atol=1e-9)
        locked = two_wheel.locked_turn(wheels, idle, motion.twist[2])
        assert motion.centre == pytest.approx(locked.centre)
    else:
        assert motion.centre is None and np.all(np.abs(motion.rates[idle]) > 0.5)


def test_free_motion_is_the_least_drag_among_all_that_fit():
    wheels, driven, rates = base(0.9), (FR, RL), (1.0, 0.4)
    motion = two_wheel.free_motion(wheels, driven, rates)
    matrix = wheels_from_body(wheels)
    idle = [i for i in range(4) if i not in driven]
    free = np.linalg.svd(matrix[list(driven)])[2][2]
    least = np.sum(motion.rates[idle] ** 2)
    for step in (-0.1, 0.1):
        other = matrix @ (motion.twist + step * free)
        np.testing.assert_allclose(other[list(driven)], rates, atol=1e-9)
        assert np.sum(other[idle] ** 2) > least


def test_two_wheels_leave_the_twist_open_and_three_fix_it():
    assert not two_wheel.is_determined(base(), (FR, FL))
    assert two_wheel.is_determined(base(), (FR, FL, RL))


def test_four_driven_wheels_that_disagree_leave_a_residual():
    motion = two_wheel.free_motion(base(), range(4), (1.0, 1.0, -1.0, -1.0))
    assert np.max(np.abs(motion.residual)) == pytest.approx(1.0)


def test_the_bearing_of_a_pivot_is_not_the_heading():
    turn = pivot.pivot_turn(base(), RL, 1.0)
    bearing = centre.velocity_bearing(turn.twist, 0.3)
    # about RL the centre moves across the line to the wheel: gamma = atan2(y, x) of source T
    assert bearing == pytest.approx(0.3 + math.atan2(WHEELBASE, TRACK))
