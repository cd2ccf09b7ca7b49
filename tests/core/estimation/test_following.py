"""Wheels against their commands."""

import math

import numpy as np

from mecanum_base.core.estimation.following import Following

MS = 1_000_000


def drive(following, rate, command, steps=60):
    """Commands every 20 ms while the wheels turn at ``rate``."""
    for k in range(steps):
        assert following.take(k * 20 * MS, np.array(command), np.array(rate) * k * 0.02)


def test_wheels_that_follow_are_not_named():
    following = Following(2)
    drive(following, [5.1, -4.9], [5.0, -5.0])
    assert following.strays == ()


def test_a_wheel_that_stands_while_commanded_is_named_after_half_a_second():
    following = Following(2)
    drive(following, [0.0, 5.0], [5.0, 5.0], steps=20)
    assert following.strays == ()
    drive(following, [0.0, 5.0], [5.0, 5.0], steps=60)
    assert following.strays == (0,)


def test_a_wheel_that_follows_again_is_forgiven():
    following = Following(1)
    drive(following, [0.0], [5.0])
    assert following.strays == (0,)
    drive(following, [5.0], [5.0])
    assert following.strays == ()


def test_commands_of_another_robot_or_without_numbers_are_refused():
    following = Following(2)
    assert not following.take(0, np.array([1.0]), np.zeros(2))
    assert not following.take(0, np.array([math.nan, math.nan]), np.zeros(2))
