"""Limits on the twist as one vector: never exceeded, direction kept, no overshoot from rest."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanum_base.core.command.drive import DriveConfig
from mecanum_base.core.command.limiter import TwistLimiter, TwistLimits

DT = 0.02
ACCELERATION, DECELERATION, JERK = (1.0, 0.8, 2.0), (2.0, 1.6, 4.0), (10.0, 10.0, 20.0)


def limiter(shape='ellipse', jerk=JERK, velocity=()):
    drive = DriveConfig(max_velocity=velocity, max_acceleration=ACCELERATION,
                        max_deceleration=DECELERATION, max_jerk=jerk, limit_shape=shape)
    return TwistLimiter(TwistLimits.from_config(drive))


def size(vector, maxima, shape):
    """The norm of the module docstring, written out a second time."""
    x, y, w = (abs(v) / m for v, m in zip(vector, maxima))
    return math.sqrt(x * x + y * y + w * w) if shape == 'ellipse' else max(x, y, w)


def ride(unit, wanted, steps):
    twists = [np.array(unit.twist)]
    for _ in range(steps):
        twists.append(np.array(unit.step(np.array(wanted, dtype=float), DT)))
    return np.array(twists)


twist = st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-4, 4))


@pytest.mark.parametrize('shape', ['ellipse', 'box'])
@settings(max_examples=30, deadline=None, derandomize=True)
@given(targets=st.lists(twist, min_size=1, max_size=5), hold=st.integers(1, 40))
def test_acceleration_and_jerk_stay_within_their_limits_for_any_commands(shape, targets, hold):
    unit = limiter(shape)
    twists = np.concatenate([ride(unit, target, hold)[:-1] for target in targets])
    accelerations = np.diff(twists, axis=0) / DT
    jerks = np.diff(np.vstack([np.zeros(3), accelerations]), axis=0) / DT
    larger = np.maximum(ACCELERATION, DECELERATION)
    # 1e-6: rounding of differences of numbers around 1, divided by 0.02 s twice
    assert all(size(a, larger, shape) <= 1 + 1e-6 for a in accelerations)
    assert all(size(j, JERK, shape) <= 1 + 1e-6 for j in jerks)


@pytest.mark.parametrize('shape', ['ellipse', 'box'])
@settings(max_examples=30, deadline=None, derandomize=True)
@given(targets=st.lists(twist, min_size=1, max_size=4))
def test_without_jerk_limit_the_acceleration_limit_of_each_phase_is_exact(shape, targets):
    unit = limiter(shape, jerk=())
    for target in targets:
        before = np.array(unit.twist)
        for row in ride(unit, target, 30)[1:]:
            change = (row - before) / DT
            slower = (before / DECELERATION) @ ((row - before) / DECELERATION) < 0.0
            allowed = np.maximum(ACCELERATION, DECELERATION) if slower else ACCELERATION
            assert size(change, allowed, shape) <= 1 + 1e-9
            before = row


@settings(max_examples=30, deadline=None, derandomize=True)
@given(target=twist)
def test_from_rest_and_back_to_rest_the_direction_is_kept_without_overshoot(target):
    unit = limiter()
    up = ride(unit, target, 400)
    down = ride(unit, (0, 0, 0), 400)
    length = np.linalg.norm(target)
    for path in (up, down):
        along = path @ target / length if length else np.zeros(len(path))
        across = path - np.outer(along, np.array(target) / length) if length else path
        assert np.abs(across).max() < 1e-9  # a straight line in the space of twists
        assert along.min() > -1e-9 and along.max() < length + 1e-9
    assert np.array_equal(up[-1], target) and np.array_equal(down[-1], np.zeros(3))
    speed = np.linalg.norm(up, axis=1)
    assert (np.diff(speed) > -1e-12).all()


def test_a_straight_start_takes_the_time_that_the_limits_say():
    unit = limiter(jerk=())
    path = ride(unit, (1.0, 0.0, 0.0), 100)[:, 0]
    assert path[25] == pytest.approx(0.5)  # 1 m/s^2 for 0.5 s
    assert np.argmax(path == 1.0) == 50
    path = ride(unit, (0.0, 0.0, 0.0), 100)[:, 0]
    assert np.argmax(path == 0.0) == 25  # 2 m/s^2


def test_a_reversal_brakes_with_the_deceleration_and_starts_with_the_acceleration():
    unit = limiter(jerk=())
    ride(unit, (0.99, 0.0, 0.0), 100)
    path = ride(unit, (-0.99, 0.0, 0.0), 200)[:, 0]
    # 0.495 s down at 2 m/s^2, then 0.99 s up at 1 m/s^2; the step across zero holds both phases
    assert path[24] == pytest.approx(0.99 - 24 * DT * 2.0)
    assert path[25] == pytest.approx(-(0.5 - 0.495) * 1.0)
    assert np.argmax(path == -0.99) == math.ceil((0.495 + 0.99) / DT - 1e-9)


def test_the_ellipse_slows_a_diagonal_start_and_the_box_does_not():
    wanted = (1.0, 0.8, 2.0)  # proportional to the acceleration limits
    times = {shape: np.argmax(np.all(ride(limiter(shape, jerk=()), wanted, 200) == wanted, axis=1))
             for shape in ('ellipse', 'box')}
    assert times['box'] == 50
    assert times['ellipse'] == math.ceil(50 * math.sqrt(3.0))


def test_a_velocity_beyond_its_limit_is_scaled_as_a_whole():
    limits = limiter(velocity=(1.0, 0.5, 2.0)).limits
    assert limits.within_velocity(np.array([0.5, 0.0, 0.1])) == pytest.approx([0.5, 0.0, 0.1])
    assert limits.within_velocity(np.array([3.0, 0.0, 0.0])) == pytest.approx([1.0, 0.0, 0.0])
    scaled = limits.within_velocity(np.array([1.0, 0.5, 2.0]))
    assert scaled == pytest.approx(np.array([1.0, 0.5, 2.0]) / math.sqrt(3.0))


def test_no_limits_mean_that_the_wanted_twist_is_told_at_once():
    free = DriveConfig(max_acceleration=(), max_deceleration=(), max_jerk=())
    unit = TwistLimiter(TwistLimits.from_config(free))
    assert unit.step(np.array([3.0, -2.0, 5.0]), DT) == pytest.approx([3.0, -2.0, 5.0])
    assert unit.step(np.array([-3.0, 0.0, 0.0]), DT) == pytest.approx([-3.0, 0.0, 0.0])


def test_an_axis_without_limit_does_not_loosen_the_others():
    drive = DriveConfig(max_acceleration=(1.0, 1.0, 1.0), max_deceleration=(), max_jerk=())
    unit = TwistLimiter(TwistLimits.from_config(drive))
    path = ride(unit, (1.0, 0.0, 0.0), 10)
    assert path[10, 0] == pytest.approx(0.2)
    assert ride(unit, (0.0, 0.0, 0.0), 1)[1] == pytest.approx([0.0, 0.0, 0.0])


def test_a_reset_forgets_the_speed_and_the_acceleration():
    unit = limiter()
    ride(unit, (1.0, 0.0, 0.0), 10)
    unit.reset()
    assert not unit.twist.any() and not unit.acceleration.any()
    first = unit.step(np.array([1.0, 0.0, 0.0]), DT)
    assert first[0] == pytest.approx(10.0 * DT * DT)  # jerk for one step


def test_a_step_of_no_duration_changes_nothing():
    unit = limiter()
    ride(unit, (1.0, 0.0, 0.0), 10)
    before = np.array(unit.twist)
    assert np.array_equal(unit.step(np.array([-1.0, 0.0, 0.0]), 0.0), before)
