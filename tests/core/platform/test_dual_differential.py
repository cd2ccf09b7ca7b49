"""The dual-differential platform: constraints, inverse, forward, mobility, Lie rank, casters."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wheel_strategies import numbers, twists

from mecanum_base.core.errors import ConfigError, GeometryError
from mecanum_base.core.platform import caster, constraints, differential, lie
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.platform.hinges import Hinges


def carriers(x=(0.3, -0.3), y=(0.0, 0.0), e=(-0.1, -0.1), b=(0.12, 0.12), r=(0.05, 0.05), **more):
    return Carriers(('front', 'rear'), x, y, e, b, r, ('fl', 'rl'), ('fr', 'rr'), **more)


@st.composite
def platforms(draw):
    draw = np.random.default_rng(draw(st.integers(0, 10**6)))
    sign = draw.choice([-1.0, 1.0], 2)
    return carriers(draw.uniform([0.1, -0.4], [0.4, -0.1]), draw.uniform(-0.2, 0.2, 2),
                    sign * draw.uniform(0.05, 0.2, 2), draw.uniform(0.05, 0.2, 2),
                    draw.uniform(0.02, 0.08, 2))


angle_pairs = st.tuples(numbers(-7, 7), numbers(-7, 7)).map(np.array)


def wheel_centres(base, i):
    """Wheel centres of carrier i in carrier axes from the hinge: left, right."""
    return [np.array([base.axle_offset[i], side * base.half_track[i]]) for side in (1, -1)]


@given(platforms(), angle_pairs, twists)
def test_every_wheel_rolls_without_sliding_sideways(base, angles, twist):
    """Velocities of the wheel centres as a mechanic would write them, point by point."""
    rates = differential.wheels_from_body(base, angles) @ twist
    turning = differential.hinges_from_body(base, angles) @ twist
    for i in range(2):
        c, s = math.cos(angles[i]), math.sin(angles[i])
        hinge = twist[:2] + twist[2] * np.array([-base.y[i], base.x[i]])
        for j, place in enumerate(wheel_centres(base, i)):
            arm = np.array([c * place[0] - s * place[1], s * place[0] + c * place[1]])
            velocity = hinge + (twist[2] + turning[i]) * np.array([-arm[1], arm[0]])
            forward = velocity @ [c, s]
            assert velocity @ [-s, c] == pytest.approx(0.0, abs=1e-9)
            assert forward == pytest.approx(base.wheel_radius[i] * rates[2 * i + j], abs=1e-9)


@given(platforms(), angle_pairs, twists, numbers(-3, 3))
def test_the_state_matrix_satisfies_all_constraints_and_their_rank_is_six(
        base, angles, twist, yaw):
    constraint = constraints.constraint_matrix(base, angles, yaw)
    state = constraints.state_from_body(base, angles, yaw)
    scale = np.max(np.abs(state)) * np.max(np.abs(constraint))
    assert np.max(np.abs(constraint @ state)) < 1e-12 * scale
    assert constraints.rank(constraint) == 6 and constraint.shape == (8, 9)
    world = (state @ twist)[:2]
    assert math.hypot(*world) == pytest.approx(math.hypot(twist[0], twist[1]))
    facing = complex(*world) / complex(math.cos(yaw), math.sin(yaw))
    assert (facing.real, facing.imag) == pytest.approx((twist[0], twist[1]), abs=1e-9)


@given(platforms(), angle_pairs, twists)
def test_forward_undoes_inverse_and_nothing_stretches(base, angles, twist):
    rates = differential.wheels_from_body(base, angles) @ twist
    np.testing.assert_allclose(differential.body_from_wheels(base, angles) @ rates, twist,
                               atol=1e-9)
    np.testing.assert_allclose(differential.hinges_from_wheels(base, angles) @ rates,
                               differential.hinges_from_body(base, angles) @ twist, atol=1e-8)
    assert differential.stretch_from_wheels(base, angles) @ rates == pytest.approx(0.0, abs=1e-9)


def test_carriers_that_drive_apart_stretch_the_platform_and_do_not_move_it():
    rates = np.array([1.0, 1.0, -1.0, -1.0])
    base, straight = carriers(), np.zeros(2)
    assert differential.stretch_from_wheels(base, straight) @ rates == pytest.approx(0.1)
    np.testing.assert_allclose(differential.body_from_wheels(base, straight) @ rates, 0.0,
                               atol=1e-12)


def test_straight_ahead_all_wheels_turn_alike_and_hinges_stand():
    twist = np.array([0.5, 0.0, 0.0])
    base, straight = carriers(), np.zeros(2)
    np.testing.assert_allclose(differential.wheels_from_body(base, straight) @ twist, 10.0)
    np.testing.assert_allclose(differential.hinges_from_body(base, straight) @ twist, 0.0)


def test_a_sideways_start_turns_trailing_carriers_into_the_motion():
    rates = differential.hinges_from_body(carriers(), np.zeros(2)) @ np.array([0.0, 0.2, 0.0])
    np.testing.assert_allclose(rates, 2.0)  # v / |e|, to the left


@given(platforms(), angle_pairs)
def test_with_offset_axles_the_platform_is_omnidirectional_at_every_steering_angle(base, angles):
    found = constraints.assess(base.hinges, angles)
    assert found.omnidirectional
    assert (found.twist_dof, found.degree, found.lateral_rank) == (3, 3, 2)


@pytest.mark.parametrize(('offsets', 'dof'), [((0.0, 0.0), 1), ((0.0, -0.1), 2), ((-0.1, 0.0), 2)])
def test_the_count_of_constraints_does_not_show_that_axles_under_the_hinge_cannot(offsets, dof):
    found = constraints.assess(Hinges([0.3, -0.3], [0.0, 0.0], offsets), np.array([0.4, -0.9]))
    assert found.degree == 3 and found.twist_dof == dof and not found.omnidirectional


def test_centred_axles_in_line_leave_two_motions():
    found = constraints.assess(Hinges([0.0, 0.0], [0.3, -0.3], [0.0, 0.0]), np.zeros(2))
    assert found.lateral_rank == 1 and found.twist_dof == 2


def test_axles_under_the_hinge_and_coinciding_hinges_are_refused_in_a_robot_file():
    with pytest.raises(GeometryError, match='omnidirectional'):
        carriers(e=(0.0, -0.1))
    with pytest.raises(GeometryError, match='coincide'):
        carriers(x=(0.3, 0.3))


@pytest.mark.parametrize(('change', 'match'), [
    ({'b': (0.1,)}, 'half_track'), ({'hinge_joint': ('h',)}, 'hinge_joint'),
    ({'hinge_joint': ('fl', '')}, 'only once')])
def test_a_carrier_table_with_wrong_columns_is_refused(change, match):
    with pytest.raises(ConfigError, match=match):
        carriers(**change)


def test_a_platform_needs_two_carriers_and_its_wheel_order_is_left_right_per_carrier():
    with pytest.raises(ConfigError, match='two carriers'):
        Carriers(('one',), [0.1], [0.0], [-0.1], [0.1], [0.05], ('l',), ('r',))
    assert carriers().joint == ('fl', 'fr', 'rl', 'rr') and carriers().count == 4


@given(platforms(), angle_pairs, numbers(-3, 3))
def test_first_brackets_reach_every_posture_and_have_the_closed_form(base, angles, yaw):
    hinges = base.hinges
    assert lie.reachable_rank(hinges, angles, yaw) == (3, 5)
    one, two, three = lie.fields(hinges, angles, yaw).T
    e2 = hinges.axle_offset ** 2
    for got, steering in (
            (lie.bracket(hinges, angles, yaw, 0, 1), 1 / e2),
            (lie.bracket(hinges, angles, yaw, 0, 2) + two, hinges.x / e2),
            (lie.bracket(hinges, angles, yaw, 1, 2) - one, hinges.y / e2)):
        np.testing.assert_allclose(got, [0, 0, 0, *steering], atol=1e-7)
    assert three[2] == 1.0


@given(platforms(), angle_pairs, numbers(-3, 3))
def test_the_brackets_are_those_of_numerical_derivatives(base, angles, yaw):
    hinges, h = base.hinges, 1e-6
    g = lie.fields(hinges, angles, yaw)

    def slope(column):
        parts = np.zeros((5, 5))
        for k, (d_yaw, d_angle) in {2: (h, [0, 0]), 3: (0, [h, 0]), 4: (0, [0, h])}.items():
            parts[:, k] = (lie.fields(hinges, angles + d_angle, yaw + d_yaw)[:, column]
                           - lie.fields(hinges, angles - np.array(d_angle), yaw - d_yaw)[:, column]
                           ) / (2 * h)
        return parts
    for a, b in ((0, 1), (0, 2), (1, 2), (2, 1)):
        np.testing.assert_allclose(lie.bracket(hinges, angles, yaw, a, b),
                                   slope(b) @ g[:, a] - slope(a) @ g[:, b], atol=1e-4)


def test_coinciding_hinges_lose_one_posture():
    hinges = Hinges([0.2, 0.2], [0.1, 0.1], [-0.1, -0.1])
    assert lie.reachable_rank(hinges, np.array([0.3, -0.5]))[1] == 4


@pytest.mark.parametrize('offset', [-0.1, 0.08])
def test_a_carrier_swings_as_the_closed_form_says(offset):
    base, start, speed = carriers(e=(offset, -0.1)), 0.4, 0.2
    twist = np.array([speed, 0.0, 0.0])
    angles, dt = np.array([-start, 0.0]), 1e-3  # carrier points right of the motion
    assert caster.misalignment(base, angles, twist)[0] == pytest.approx(start)
    for _ in range(600):
        middle = angles + dt / 2 * (differential.hinges_from_body(base, angles) @ twist)
        angles = angles + dt * (differential.hinges_from_body(base, middle) @ twist)
    assert caster.misalignment(base, angles, twist)[0] == pytest.approx(
        caster.misalignment_after(offset, speed, start, 0.6), abs=1e-6)


@given(platforms(), angle_pairs, twists)
def test_the_heading_rate_of_a_carrier_is_that_of_the_platform_plus_the_hinge(
        base, angles, twist):
    gap = caster.misalignment(base, angles, twist)
    turning = differential.hinges_from_body(base, angles) @ twist + twist[2]
    for i in range(2):
        hinge = twist[:2] + twist[2] * np.array([-base.y[i], base.x[i]])
        speed = math.hypot(*hinge)
        if speed > 1e-6:
            assert turning[i] == pytest.approx(
                caster.heading_rate(base.axle_offset[i], speed, gap[i]), abs=1e-7)


def test_pushing_a_trailing_carrier_backwards_makes_it_flip():
    base = carriers(e=(-0.1, 0.1))
    assert caster.will_flip(base, np.zeros(2), np.array([0.3, 0, 0])) == (False, True)
    assert caster.will_flip(base, np.zeros(2), np.array([-0.3, 0, 0])) == (True, False)
    assert caster.will_flip(base, np.zeros(2), np.zeros(3)) == (False, False)


def test_the_wheels_peak_during_a_flip_as_announced():
    base, twist = carriers(), np.array([-0.2, 0.0, 0.0])
    scan = np.linspace(-math.pi, math.pi, 2001)
    peak = max(np.max(np.abs(differential.wheels_from_body(base, np.array([a, 0.0]))[:2] @ twist))
               for a in scan)
    assert caster.flip_peak_rate(-0.1, 0.12, 0.05, 0.2) == pytest.approx(peak, rel=1e-5)


def test_the_platform_follows_circle_and_spin_by_its_wheels_alone():
    """Wheel rates of the wanted twist, the motion of those rates, RK4 in the test: to 1e-6."""
    base = carriers(e=(-0.1, -0.08), y=(0.02, -0.05))
    radius, turn, spin = 0.25, math.pi / 7, math.pi / 30

    def slope(time, state):
        yaw = spin * time
        vx, vy = radius * turn * math.cos(turn * time), -radius * turn * math.sin(turn * time)
        wanted = np.array([math.cos(yaw) * vx + math.sin(yaw) * vy,
                           -math.sin(yaw) * vx + math.cos(yaw) * vy, spin])
        rates = differential.wheels_from_body(base, state[3:]) @ wanted
        moved = differential.body_from_wheels(base, state[3:]) @ rates
        c, s = math.cos(state[2]), math.sin(state[2])
        return np.array([c * moved[0] - s * moved[1], s * moved[0] + c * moved[1], moved[2],
                         *(differential.hinges_from_wheels(base, state[3:]) @ rates)])

    state, h = np.array([0.0, radius, 0.0, -0.3, 1.1]), 0.04
    for n in range(350):
        t = n * h
        k1 = slope(t, state)
        k2 = slope(t + h / 2, state + h / 2 * k1)
        k3 = slope(t + h / 2, state + h / 2 * k2)
        k4 = slope(t + h, state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    np.testing.assert_allclose(state[:3], [0.0, radius, 14 * spin], atol=1e-6)
