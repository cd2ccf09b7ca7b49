"""Equations of motion: inverse of each other, energy, momentum, traction."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wheel_strategies import mobile_sets, numbers, twists

from mecanum_base.core.dynamics import motion
from mecanum_base.core.dynamics.body import (
    Body,
    DriveTrain,
    coriolis,
    mass_centre_acceleration,
    mass_matrix,
)
from mecanum_base.core.dynamics.traction import judge, judge_torques
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.matrix import wheels_from_body

bodies = st.builds(lambda m, i, x, y: Body(m, i, np.array([x, y]), 0.1), numbers(5, 40),
                   numbers(0.1, 3), numbers(-0.1, 0.1), numbers(-0.1, 0.1))
trains = st.builds(DriveTrain, numbers(0, 0.02), numbers(0, 0.1))


def runge_kutta(slope, state, time, steps):
    h = time / steps
    for _ in range(steps):
        k1 = slope(state)
        k2 = slope(state + h / 2 * k1)
        k3 = slope(state + h / 2 * k2)
        k4 = slope(state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state


@given(mobile_sets(), bodies, trains, twists, twists)
def test_forward_undoes_inverse_and_the_torques_are_the_smallest(wheels, body, train, twist, rate):
    torques = motion.inverse_dynamics(wheels, body, train, twist, rate)
    np.testing.assert_allclose(
        motion.forward_dynamics(wheels, body, train, twist, torques), rate, atol=1e-7)
    matrix = wheels_from_body(wheels)
    smallest = matrix @ np.linalg.lstsq(matrix, torques, rcond=None)[0]
    np.testing.assert_allclose(torques, smallest, atol=1e-6)  # no part along a parity


def test_preload_along_the_null_vector_moves_nothing():
    base, body = layouts.rectangle(0.2, 0.15, 0.05), Body(10.0, 0.5, np.array([0.03, -0.02]))
    twist, torques = np.array([0.3, -0.2, 0.5]), np.array([0.4, -0.1, 0.2, 0.7])
    rates = [motion.forward_dynamics(base, body, DriveTrain(), twist,
                                     torques + c * np.array([1, 1, -1, -1])) for c in (0, 3)]
    np.testing.assert_allclose(rates[0], rates[1], atol=1e-10)


@given(bodies, twists, twists)
def test_the_wrench_is_the_rate_of_momentum_in_the_world(body, twist, rate):
    """Newton and Euler for the mass centre, by finite differences in world axes."""
    def momentum(h):
        now, yaw = twist + h * rate, h * twist[2] + h * h / 2 * rate[2]
        c, s = math.cos(yaw), math.sin(yaw)
        cx, cy = body.mass_centre
        v = np.array([now[0] - now[2] * cy, now[1] + now[2] * cx])
        return body.mass * np.array([c * v[0] - s * v[1], s * v[0] + c * v[1]]), \
            body.inertia * now[2]

    h = 1e-5
    (before, spin_before), (after, spin_after) = momentum(-h), momentum(h)
    force = (after - before) / (2 * h)
    about_centre = (spin_after - spin_before) / (2 * h)
    cx, cy = body.mass_centre
    want = [force[0], force[1], about_centre + cx * force[1] - cy * force[0]]
    np.testing.assert_allclose(motion.body_wrench(body, twist, rate), want, rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(mass_centre_acceleration(body, twist, rate), force / body.mass,
                               rtol=1e-5, atol=1e-5)


def test_free_motion_keeps_momentum_angular_momentum_and_energy():
    body = Body(8.0, 0.4, np.array([0.07, -0.05]))

    def slope(state):
        c, s = math.cos(state[2]), math.sin(state[2])
        v = state[3:]
        return np.concatenate([[c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]],
                               np.linalg.solve(mass_matrix(body), -coriolis(body, v))])

    def kept(state):
        c, s = math.cos(state[2]), math.sin(state[2])
        turn = np.array([[c, -s], [s, c]])
        place = state[:2] + turn @ body.mass_centre
        v = turn @ (state[3:5] + state[5] * np.array([-body.mass_centre[1], body.mass_centre[0]]))
        spin = body.inertia * state[5] + body.mass * (place[0] * v[1] - place[1] * v[0])
        return np.array([*(body.mass * v), spin, 0.5 * state[3:] @ mass_matrix(body) @ state[3:]])

    start = np.array([0.2, -0.1, 0.3, 0.5, -0.4, 1.5])
    end = runge_kutta(slope, start, 3.0, 600)
    np.testing.assert_allclose(kept(end), kept(start), rtol=1e-8)


def test_motor_work_becomes_kinetic_energy_and_viscous_heat():
    base, body = layouts.rectangle(0.2, 0.15, 0.05), Body(10.0, 0.5, np.array([0.04, 0.02]))
    train, torques = DriveTrain(0.003, 0.04), np.array([0.6, -0.2, 0.5, 0.3])
    matrix = wheels_from_body(base)

    def slope(state):
        rates = matrix @ state[:3]
        return np.concatenate([motion.forward_dynamics(base, body, train, state[:3], torques),
                               [torques @ rates, train.viscous * rates @ rates]])

    start = np.array([0.2, 0.1, -0.3, 0.0, 0.0])
    end = runge_kutta(slope, start, 2.0, 400)
    gained = (motion.kinetic_energy(base, body, train, end[:3])
              - motion.kinetic_energy(base, body, train, start[:3]))
    assert gained + end[4] == pytest.approx(end[3], rel=1e-7)
    assert end[4] > 0.01


@given(st.lists(numbers(-9, 9), min_size=4, max_size=4).map(np.array), numbers(0, 1),
       numbers(0, 1))
def test_losses_never_give_power(rates, viscous, coulomb):
    assert DriveTrain(0.01, viscous, coulomb).loss(rates) @ rates >= 0.0


def test_the_shaft_torque_balances_inertia_friction_and_ground():
    train = DriveTrain(0.01, 0.2, 0.05)
    torque = train.torque(np.array([3.0, -3.0]), np.array([2.0, 2.0]), np.array([0.4, 0.4]))
    np.testing.assert_allclose(torque, [0.02 + 0.6 + 0.05 + 0.4, 0.02 - 0.6 - 0.05 + 0.4])


def test_what_reaches_the_ground_moves_the_base():
    base, body = layouts.rectangle(0.2, 0.15, 0.05), Body(10.0, 0.5, np.array([0.04, 0.02]))
    train, twist = DriveTrain(0.003, 0.04), np.array([0.4, -0.1, 0.6])
    torques = np.array([0.6, -0.2, 0.5, 0.3])
    rate = motion.forward_dynamics(base, body, train, twist, torques)
    ground = motion.ground_torques(base, train, twist, rate, torques)
    np.testing.assert_allclose(wheels_from_body(base).T @ ground,
                               motion.body_wrench(body, twist, rate), atol=1e-10)


def test_traction_says_which_wheel_slips_first():
    base, body = layouts.rectangle(0.2, 0.15, 0.05), Body(10.0, 0.5, np.array([0.1, 0.0]), 0.1)
    calm = judge_torques(base, body, DriveTrain(), np.zeros(3), np.full(4, 0.2), 0.5)[1]
    assert calm.text(base.joint).startswith('all wheels hold') and not any(calm.slips)
    hard = judge_torques(base, body, DriveTrain(), np.zeros(3), np.full(4, 0.5), 0.5)[1]
    assert hard.slips == (False, False, True, True)  # the front carries the weight
    assert 'RL slips' in hard.text(base.joint)
    # force along the roller: T / (r sin 45 deg)
    assert abs(hard.force[0]) == pytest.approx(0.5 / (0.05 * math.sin(math.pi / 4)))


def test_a_lifted_wheel_that_is_driven_slips():
    found = judge(np.array([1.0, 0.0, 1.0]), np.array([-5.0, -5.0, 10.0]), 0.5)
    assert found.slips == (True, False, False) and found.lifted == (True, True, False)
    assert 'is lifted' in found.text(('a', 'b', 'c'))


@pytest.mark.parametrize(('mass', 'inertia', 'key'), [(0.0, 1.0, 'mass'), (1.0, -1.0, 'inertia')])
def test_impossible_bodies_are_refused(mass, inertia, key):
    with pytest.raises(ConfigError, match=key):
        Body(mass, inertia)
