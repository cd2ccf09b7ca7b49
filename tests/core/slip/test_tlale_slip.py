"""Slip in the terms of source T (T1-T4)."""

import math

import numpy as np
import pytest
from hypothesis import given
from wheel_strategies import mobile_sets, twists

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.slip import drive, encoder, ratio


@given(mobile_sets(counted=True), twists)
def test_rolling_wheels_have_ratio_one_and_no_slip_speed(wheels, twist):
    rates = wheels_from_body(wheels) @ twist
    turning = np.abs(rates) > 1e-6
    np.testing.assert_allclose(ratio.slip_ratio(wheels, rates, twist)[turning], 1.0, rtol=1e-9)
    np.testing.assert_allclose(ratio.slip_speed(wheels, rates, twist), 0.0, atol=1e-12)


@given(mobile_sets(), twists)
def test_the_real_travel_is_the_wheel_centre_along_the_pushing_roller_axis(wheels, twist):
    velocity = np.column_stack([twist[0] - twist[2] * wheels.y, twist[1] + twist[2] * wheels.x])
    along = np.sum(velocity * ratio.push_directions(wheels), axis=1)
    np.testing.assert_allclose(ratio.real_travel(wheels, twist, 0.1), 0.1 * along, atol=1e-9)


def test_a_positive_rate_of_the_usual_base_pushes_forward_on_every_wheel():
    push = ratio.push_directions(layouts.rectangle(0.2, 0.15, 0.05))
    assert np.all(push[:, 0] > 0)  # FL and RR forward-right, FR and RL forward-left
    assert (np.sign(push[:, 1]) == [-1, 1, 1, -1]).all()


def test_a_spinning_wheel_has_a_ratio_below_one_and_a_dragged_one_above():
    base, twist = layouts.rectangle(0.2, 0.15, 0.05), np.array([0.5, 0.0, 0.0])
    rates = np.array([20.0, 5.0, 10.0, 0.0])  # rolling would be 10
    s = ratio.slip_ratio(base, rates, twist)
    np.testing.assert_allclose(s[:3], [0.5, 2.0, 1.0])
    assert math.isnan(s[3])
    speed = ratio.slip_speed(base, rates, twist)
    np.testing.assert_allclose(speed, 0.05 * math.sin(math.pi / 4) * (rates - 10.0))


def test_perfect_forward_rolling_is_ratio_one_and_not_1_41():
    base = layouts.rectangle(0.2, 0.15, 0.05)
    s = ratio.slip_ratio(base, np.full(4, 10.0), np.array([0.5, 0.0, 0.0]))
    np.testing.assert_allclose(s, 1.0)


def test_the_encoder_constant_counts_pulses_quadrature_and_gear_but_no_radius():
    constant = encoder.encoder_constant(500, 4, 20.0)
    assert constant * 40000 == pytest.approx(2 * math.pi)
    assert encoder.rate_from_counts(-40000, 0.5, constant) == pytest.approx(-4 * math.pi)
    for wrong in ((0, 4, 20), (500, -1, 20), (500, 4, 0)):
        with pytest.raises(ConfigError, match='> 0'):
            encoder.encoder_constant(*wrong)


def test_effectiveness_is_one_for_swedish_wheels_and_none_for_parallel_rollers():
    assert drive.effectiveness(math.pi / 2) == 1.0 and drive.effectiveness(0.0) == 0.0
    assert drive.wheel_rate(100.0, 0.05) == pytest.approx(5.0)
    assert drive.effective_rate(100.0, 0.05, math.pi / 6) == pytest.approx(2.5)
