"""Scaling wheel rates to their limits keeps the path."""

import math

import numpy as np
import pytest
from hypothesis import given
from wheel_strategies import mobile_sets, twists

from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.saturation import desaturate, fastest, scale_to_limits

BASE = layouts.rectangle(0.2, 0.15, 0.05)
MATRIX = wheels_from_body(BASE)
LIMITS = np.full(4, 20.0)


def test_rates_within_their_limits_are_left_alone():
    assert scale_to_limits(np.array([1.0, -20.0, 3.0, 0.0]), LIMITS) == 1.0


@given(mobile_sets(), twists)
def test_saturation_keeps_the_direction_of_the_twist(wheels, twist):
    matrix, limits = wheels_from_body(wheels), np.full(wheels.count, 2.0)
    served = desaturate(matrix, twist, limits)
    assert np.all(np.abs(matrix @ served) <= 2.0 * (1 + 1e-12))
    np.testing.assert_allclose(np.cross(served, twist), 0.0, atol=1e-9)
    assert served @ twist >= 0.0


def test_yaw_comes_first_where_it_is_to_be_kept():
    twist = np.array([2.0, 0.0, 2.0])
    served = desaturate(MATRIX, twist, LIMITS, keep_yaw=True)
    assert served[2] == 2.0 and 0.0 < served[0] < 2.0
    assert np.max(np.abs(MATRIX @ served)) == pytest.approx(20.0)


def test_the_fastest_forward_speed_is_rim_speed():
    assert fastest(MATRIX, np.array([1.0, 0.0, 0.0]), LIMITS) == pytest.approx(1.0)
    assert fastest(MATRIX, np.array([0.0, 0.0, 1.0]), LIMITS) == pytest.approx(1.0 / 0.35)
    assert math.isinf(fastest(MATRIX, np.zeros(3), LIMITS))
    assert math.isinf(fastest(MATRIX, np.ones(3), np.full(4, math.inf)))


@given(mobile_sets(), twists)
def test_with_yaw_first_as_much_translation_is_served_as_fits(wheels, twist):
    matrix, limits = wheels_from_body(wheels), np.full(wheels.count, 60.0)
    served = desaturate(matrix, twist, limits, keep_yaw=True)
    rates = np.abs(matrix @ served)
    assert np.all(rates <= 60.0 * (1 + 1e-9))
    assert abs(served[2]) <= abs(twist[2]) * (1 + 1e-12)
    if np.max(np.abs(matrix[:, 2] * twist[2])) <= 60.0:
        assert served[2] == pytest.approx(twist[2])
    np.testing.assert_allclose(served[0] * twist[1], served[1] * twist[0], atol=1e-9)
    whole = np.allclose(served, twist)
    assert whole or np.max(rates) == pytest.approx(60.0)  # all of it, or some wheel at its limit
