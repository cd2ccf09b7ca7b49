"""Loads: force and moment balances, positivity, hyperstatics, acceleration (T14)."""

import numpy as np
import pytest
from hypothesis import given
from wheel_strategies import numbers

from mecanum_base.core.dynamics import loads
from mecanum_base.core.errors import ConfigError

FRONT, LEFT = np.array([1, 1, -1, -1.0]), np.array([1, -1, 1, -1.0])


def balances(contacts, load, mass, centre, height, acceleration, gravity):
    """Force and moments about x and y; inertia acts at the height of the mass centre."""
    x, y = contacts.T
    np.testing.assert_allclose(np.sum(load), mass * gravity, rtol=1e-9)
    np.testing.assert_allclose(
        load @ x, mass * (gravity * centre[0] - height * acceleration[0]), atol=1e-7)
    np.testing.assert_allclose(
        load @ y, mass * (gravity * centre[1] - height * acceleration[1]), atol=1e-7)


@given(numbers(0.1, 0.5), numbers(0.1, 0.5), numbers(-0.7, 0.7), numbers(-0.7, 0.7),
       numbers(-1, 1), numbers(-1, 1))
def test_both_solutions_balance_and_differ_by_a_diagonal_pattern(lx, ly, sx, sy, ax, ay):
    contacts = np.column_stack([lx * FRONT, ly * LEFT])
    centre, accel = np.array([sx * lx, sy * ly]), 0.2 * np.array([ax, ay])
    given_ = {'height': 0.2, 'acceleration': accel, 'gravity': 9.81}
    bilinear = loads.bilinear_loads(lx, ly, 12.0, centre, **given_)
    spring = loads.spring_loads(contacts, 12.0, centre, **given_)
    for load in (bilinear, spring):
        balances(contacts, load, 12.0, centre, 0.2, accel, 9.81)
    assert np.all(bilinear > 0)
    shifted = centre - 0.2 * accel / 9.81
    half = 12.0 * 9.81 / 4 * shifted[0] * shifted[1] / (lx * ly)
    np.testing.assert_allclose(bilinear - spring, half * FRONT * LEFT, atol=1e-9)
    lifted = abs(shifted[0]) / lx + abs(shifted[1]) / ly > 1.0
    assert bool(np.any(spring < 0)) == lifted
    pattern = loads.hyperstatic_patterns(contacts)
    assert pattern.shape == (1, 4)
    np.testing.assert_allclose(np.abs(pattern[0]), 0.5, atol=1e-9)
    np.testing.assert_allclose(np.outer(pattern[0], pattern[0]),
                               np.outer(FRONT * LEFT, FRONT * LEFT) / 4, atol=1e-9)


def test_the_print_of_t14_with_distances_is_the_same_as_the_signed_form():
    lx, ly, mass, centre = 0.3, 0.2, 10.0, np.array([0.1, -0.05])
    printed = []
    for front, left in zip(FRONT, LEFT):
        e, d = abs(centre[0] - front * lx), abs(centre[1] - left * ly)
        printed.append(mass * loads.GRAVITY * (1 - e / (2 * lx)) * (1 - d / (2 * ly)))
    np.testing.assert_allclose(loads.bilinear_loads(lx, ly, mass, centre), printed, rtol=1e-12)


def test_braking_loads_the_front_wheels():
    still = loads.bilinear_loads(0.3, 0.2, 10.0, np.zeros(2), height=0.2)
    braking = loads.bilinear_loads(0.3, 0.2, 10.0, np.zeros(2), height=0.2,
                                   acceleration=np.array([-2.0, 0.0]))
    assert np.all(braking[:2] > still[:2]) and np.all(braking[2:] < still[2:])


def test_a_mass_centre_outside_the_wheels_is_refused():
    with pytest.raises(ConfigError, match='between the wheels'):
        loads.bilinear_loads(0.3, 0.2, 10.0, np.array([0.31, 0.0]))


def test_contacts_on_a_line_are_refused():
    with pytest.raises(ConfigError, match='one line'):
        loads.spring_loads(np.array([[0, 0], [1, 1], [2, 2.0]]), 1.0, np.zeros(2))


def test_three_wheels_have_one_solution():
    contacts = np.array([[0.3, 0.0], [-0.2, 0.2], [-0.2, -0.25]])
    load = loads.spring_loads(contacts, 9.0, np.array([0.02, 0.01]))
    balances(contacts, load, 9.0, (0.02, 0.01), 0.0, (0, 0), loads.GRAVITY)
    assert loads.hyperstatic_patterns(contacts).shape == (0, 3)


def test_a_lifted_wheel_holds_nothing():
    np.testing.assert_allclose(loads.friction_limits(np.array([10.0, -2.0]), 0.6), [6.0, 0.0])
