"""Forces: power duality, Tlale's split, world axes, yaw torque (T6-T16)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wheel_strategies import mobile_sets, numbers, twists

from mecanum_base.core.dynamics import forces
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.matrix import effective_roller, wheels_from_body

torque_lists = st.lists(numbers(-5, 5), min_size=6, max_size=6).map(np.array)
four = st.lists(numbers(-30, 30), min_size=4, max_size=4).map(np.array)


@given(mobile_sets(counted=True), twists, torque_lists)
def test_the_wheels_put_in_the_power_the_base_gets(wheels, twist, torques):
    torques = torques[:wheels.count]
    put_in = torques @ (wheels_from_body(wheels) @ twist)
    assert forces.wrench_from_torques(wheels, torques) @ twist == pytest.approx(put_in, abs=1e-7)


@given(mobile_sets(), torque_lists)
def test_the_wrench_is_the_sum_of_forces_along_the_rollers(wheels, torques):
    torques = torques[:wheels.count]
    push = forces.roller_forces(wheels, torques)
    heading = wheels.axle + effective_roller(wheels)
    x, y = push * np.cos(heading), push * np.sin(heading)
    want = [np.sum(x), np.sum(y), np.sum(wheels.x * y - wheels.y * x)]
    np.testing.assert_allclose(forces.wrench_from_torques(wheels, torques), want, atol=1e-7)


@given(mobile_sets(), torque_lists)
def test_an_ideal_roller_gives_the_shaft_its_torque_back(wheels, torques):
    """Moment of the ground force about the wheel axle: r times its part along the rim."""
    torques = torques[:wheels.count]
    push = forces.roller_forces(wheels, torques)
    rim = np.column_stack([-np.sin(wheels.axle), np.cos(wheels.axle)])  # a turned by +90 deg
    heading = wheels.axle + wheels.roller
    along_rim = push * (rim[:, 0] * np.cos(heading) + rim[:, 1] * np.sin(heading))
    np.testing.assert_allclose(along_rim * wheels.radius, -torques, atol=1e-9)


@given(four, numbers(0.3, 1.3))
def test_tlales_force_is_sin2_of_the_ideal_one_in_every_direction(force, angle):
    right, forward = forces.tlale_forces(force, angle)
    ideal_right, ideal_forward = forces.ideal_forces(force, angle)
    assert right == pytest.approx(math.sin(angle) ** 2 * ideal_right, abs=1e-9)
    assert forward == pytest.approx(math.sin(angle) ** 2 * ideal_forward, abs=1e-9)


@given(four, numbers(0.3, 1.3))
def test_the_ideal_force_is_the_general_wrench(force, angle):
    base = layouts.rectangle(0.2, 0.15, 0.05, angle)
    torques = np.zeros(4)
    torques[list(layouts.TLALE)] = 0.05 * force
    right, forward = forces.ideal_forces(force, angle)
    np.testing.assert_allclose(forces.wrench_from_torques(base, torques)[:2], [forward, -right],
                               atol=1e-9)


def test_the_split_keeps_the_size_of_the_force_and_sign_and_tightness_scale_it():
    effective, lost = forces.split(np.array([3.0]), 0.6)
    assert math.hypot(effective[0], lost[0]) == pytest.approx(3.0)
    assert effective[0] == pytest.approx(3.0 * math.sin(0.6))
    plain = forces.tlale_forces(np.array([1.0, 2, 3, 4]), 0.7, np.array([1.0, -1, 1, -1]),
                                np.full(4, 0.5))
    direct = forces.tlale_forces(np.array([0.5, -1, 1.5, -2]), 0.7)
    assert plain == pytest.approx(direct)


@given(numbers(-7, 7), numbers(-9, 9), numbers(-9, 9))
def test_the_world_force_is_the_body_force_turned(heading, right, forward):
    assert math.hypot(*forces.world_force(heading, right, forward)) == pytest.approx(
        math.hypot(right, forward), abs=1e-9)
    assert forces.world_force(0.0, right, forward) == pytest.approx([forward, -right])
    assert forces.world_force(math.pi / 2, right, forward) == pytest.approx([right, forward])


@given(four, numbers(0.3, 1.3), numbers(0.2, 0.9), numbers(0.2, 0.9))
def test_the_yaw_torque_is_the_moment_of_the_roller_forces(force, angle, track, wheelbase):
    places = {'FR': (1, -1), 'FL': (1, 1), 'RL': (-1, 1), 'RR': (-1, -1)}
    moment = 0.0
    for f, name in zip(force, ('FR', 'FL', 'RL', 'RR')):
        front, left = places[name]
        side = 1 if name in ('FR', 'RL') else -1  # FR and RL push forward-left
        push = f * np.array([math.sin(angle), side * math.cos(angle)])
        place = np.array([front * wheelbase / 2, left * track / 2])
        moment += place[0] * push[1] - place[1] * push[0]
    torque, lever = forces.yaw_torque(track, wheelbase, angle, force)
    assert torque == pytest.approx(moment, abs=1e-9)
    distance, xi = forces.roller_bearing(track, wheelbase, angle)
    assert lever == pytest.approx(distance * math.sin(xi), abs=1e-9)
    assert distance == pytest.approx(math.hypot(track, wheelbase) / 2)


def test_a_square_base_at_45_degrees_has_its_rollers_across_the_lever():
    assert forces.roller_bearing(0.5, 0.5, math.pi / 4)[1] == pytest.approx(math.pi / 2)
    assert forces.roller_bearing(0.4, 0.6, math.pi / 4)[1] > math.pi / 2


def test_dry_friction_opposes_motion_and_only_holds_at_rest():
    drive, still = np.array([3.0, 4.0]), np.zeros(2)
    np.testing.assert_allclose(forces.dry_friction(drive, still, 10.0), -drive)  # held
    np.testing.assert_allclose(forces.dry_friction(drive, still, 2.5), [-1.5, -2.0])
    np.testing.assert_allclose(forces.dry_friction(drive, np.array([0.0, -2.0]), 2.5), [0.0, 2.5])
    np.testing.assert_array_equal(forces.dry_friction(still, still, 2.5), still)
