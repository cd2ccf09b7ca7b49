"""Source T's velocities: full lengths, its numbering, world axes, printed sums (T17-T23)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wheel_strategies import numbers

from mecanum_base.core.kinematics import layouts, tlale
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels

four_rates = st.lists(numbers(-20, 20), min_size=4, max_size=4).map(np.array)


@given(four_rates, numbers(0.3, 1.2), numbers(0.2, 0.9), numbers(0.2, 0.9))
def test_tlale_with_full_lengths_equals_the_general_model_with_half_lengths(
        rates, angle, track, wheelbase):
    base = layouts.rectangle(wheelbase / 2, track / 2, 0.06, angle)
    in_file_order = np.zeros(4)
    in_file_order[list(layouts.TLALE)] = rates
    general = body_from_wheels(wheels_from_body(base)) @ in_file_order
    np.testing.assert_allclose(
        tlale.twist_from_rates(track, wheelbase, 0.06, angle, rates), general, atol=1e-9)


@given(four_rates, numbers(0.3, 1.2))
def test_the_printed_sums_are_4_sin2_and_4_cos2_times_the_velocity(rates, angle):
    right, forward = tlale.printed_sums(0.06, angle, rates)
    twist = tlale.twist_from_rates(0.5, 0.6, 0.06, angle, rates)
    assert forward == pytest.approx(4 * math.sin(angle) ** 2 * twist[0], abs=1e-9)
    assert right == pytest.approx(4 * math.cos(angle) ** 2 * -twist[1], abs=1e-9)


@given(numbers(-7, 7), numbers(-2, 2), numbers(-2, 2))
def test_the_world_speed_is_the_body_speed_for_every_heading(heading, forward, right):
    world = tlale.world_velocity(heading, forward, right)
    assert math.hypot(*world) == pytest.approx(math.hypot(forward, right), abs=1e-12)
    # facing along X, forward is X and right is -Y; facing along Y, right is X
    assert tlale.world_velocity(0.0, forward, right) == pytest.approx([forward, -right])
    assert tlale.world_velocity(math.pi / 2, forward, right) == pytest.approx([right, forward])


def test_the_bearing_knows_all_four_quadrants():
    for bearing in (0.3, 2.8, -0.3, -2.8):
        assert tlale.travel_bearing(np.array([math.cos(bearing), math.sin(bearing)])) == \
            pytest.approx(bearing)


def test_straight_ahead_the_base_runs_at_rim_speed_for_every_roller_angle():
    for angle in (0.4, 0.8, 1.3):
        twist = tlale.twist_from_rates(0.4, 0.6, 0.05, angle, np.full(4, 10.0))
        np.testing.assert_allclose(twist, [0.5, 0.0, 0.0], atol=1e-12)


def test_rates_plus_minus_minus_plus_turn_counter_clockwise():
    twist = tlale.twist_from_rates(0.4, 0.6, 0.05, math.pi / 4, np.array([1.0, -1, -1, 1]))
    np.testing.assert_allclose(twist, [0.0, 0.0, 0.05 / 0.5], atol=1e-12)
