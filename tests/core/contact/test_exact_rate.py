"""The exact contact model against the velocity of a rigid roller in space."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wheel_strategies import mobile_sets, numbers, twists

from mecanum_base.core.contact import rate
from mecanum_base.core.contact.passage import passage
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.roller.shape import RollerShape, surface, wheel_from_roller

UP = np.array([0.0, 0.0, 1.0])
angles = st.lists(numbers(-9, 9), min_size=6, max_size=6).map(np.array)


def turn_about(axis, angle, vector):
    """Rodrigues' rotation."""
    return (vector * math.cos(angle) + np.cross(axis, vector) * math.sin(angle)
            + axis * (axis @ vector) * (1 - math.cos(angle)))


def rigid_roller(wheels, i, angle, twist):
    """(wheel rate, roller spin, contact (2,)) by letting the roller's lowest point stand still.

    Only vectors in space: the pin is carried round by the wheel, the contact lies under it in the
    plane of pin and axle... found as the lowest point of the surface, height 0.
    """
    k, d, r = int(wheels.roller_count[i]), wheels.roller_pin_radius[i], wheels.radius[i]
    u = (angle + math.pi / k) % (2 * math.pi / k) - math.pi / k
    axle = np.array([math.cos(wheels.axle[i]), math.sin(wheels.axle[i]), 0.0])
    heading = wheels.axle[i] + wheels.roller[i]
    pin = turn_about(axle, u, np.array([math.cos(heading), math.sin(heading), 0.0]))
    centre = np.array([wheels.x[i], wheels.y[i], r])
    on_pin = centre + turn_about(axle, u, -d * UP)
    # the common normal of ground and roller meets the pin axis and the wheel axle (Gfrerrer 2)
    # (x, y) = on_pin + s pin lies straight over (x, y) = centre + t axle
    s, t = np.linalg.solve(np.column_stack([pin[:2], -axle[:2]]), (centre - on_pin)[:2])
    contact = (centre + t * axle) * [1, 1, 0]
    hub = np.array([twist[0] - twist[2] * centre[1], twist[1] + twist[2] * centre[0], 0.0])
    # v = hub + (w up + q axle) x (C - A) + spin pin x (C - Q) = 0 on the ground
    base = hub + np.cross(twist[2] * UP, contact - centre)
    by_wheel = np.cross(axle, contact - centre)
    by_spin = np.cross(pin, contact - on_pin)
    q, spin = np.linalg.solve(np.column_stack([by_wheel, by_spin])[:2], -base[:2])
    return q, spin, contact[:2], pin


@given(mobile_sets(counted=True), twists, angles)
def test_the_lowest_point_of_the_roller_stands_still_on_the_ground(wheels, twist, phases):
    phases = phases[:wheels.count]
    rates = rate.wheels_from_body(wheels, phases) @ twist
    spins = rate.roller_spins(wheels, phases, twist)
    for i in range(wheels.count):
        if abs(math.cos(wheels.roller[i])) < 1e-9 and abs(rate.phase(wheels, phases)[i]) < 1e-9:
            continue  # Swedish roller seen end on: pin straight over the axle, any point will do
        q, spin, contact, pin = rigid_roller(wheels, i, phases[i], twist)
        assert rates[i] == pytest.approx(q, rel=1e-7, abs=1e-7)
        assert spins[i] == pytest.approx(spin, rel=1e-7, abs=1e-7)
        np.testing.assert_allclose(rate.contact_points(wheels, phases)[i], contact, atol=1e-9)
        np.testing.assert_allclose(rate.roller_axes(wheels, phases)[i], pin, atol=1e-12)


@given(mobile_sets(counted=True), twists)
def test_a_central_roller_gives_the_nominal_rate(wheels, twist):
    np.testing.assert_allclose(
        rate.wheels_from_body(wheels, np.zeros(wheels.count)) @ twist,
        wheels_from_body(wheels, corrected=False) @ twist, rtol=1e-9, atol=1e-9)


@given(angles)
def test_driving_forward_has_no_ripple_and_spins_no_roller(phases):
    base = layouts.rectangle(0.2, 0.15, 0.05, 0.7, roller_count=8, pin_radius=0.037)
    twist = np.array([0.6, 0.0, 0.0])
    np.testing.assert_allclose(rate.wheels_from_body(base, phases[:4]) @ twist, 12.0, rtol=1e-12)
    np.testing.assert_allclose(rate.roller_spins(base, phases[:4], twist), 0.0, atol=1e-12)


@given(angles)
def test_sideways_rates_ripple_as_the_secant_whatever_the_pin_radius(phases):
    for pin in (0.03, 0.044):
        base = layouts.rectangle(0.2, 0.15, 0.05, 0.7, roller_count=8, pin_radius=pin)
        twist = np.array([0.0, 0.5, 0.0])
        u = rate.phase(base, phases[:4])
        nominal = wheels_from_body(base, corrected=False) @ twist
        np.testing.assert_allclose(rate.wheels_from_body(base, phases[:4]) @ twist,
                                   nominal / np.cos(u), rtol=1e-12)


@given(mobile_sets(counted=True), twists)
def test_only_yaw_makes_the_rate_jump_at_the_hand_over_and_the_axis_never_jumps(wheels, twist):
    half = math.pi / wheels.roller_count
    before, after = half * (1 - 1e-12), half * (1 + 1e-12)
    jump = (rate.wheels_from_body(wheels, after) - rate.wheels_from_body(wheels, before)) @ twist
    scale = 1e-8 * (1.0 + np.max(np.abs(wheels_from_body(wheels) @ twist)))
    np.testing.assert_allclose(jump, passage(wheels, twist).jump, atol=scale)
    straight = twist * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(rate.wheels_from_body(wheels, after) @ straight,
                               rate.wheels_from_body(wheels, before) @ straight, atol=scale)
    np.testing.assert_allclose(rate.roller_axes(wheels, after)[:, :2],
                               rate.roller_axes(wheels, before)[:, :2], atol=1e-9)
    travel = np.linalg.norm(rate.contact_points(wheels, after)
                            - rate.contact_points(wheels, before), axis=1)
    np.testing.assert_allclose(travel, passage(wheels, twist).travel, atol=1e-9)


def test_the_contact_is_the_lowest_point_of_the_roller_and_the_wheel_stands_at_its_radius():
    r, d, delta, k = 0.05, 0.038, math.radians(50), 9
    wheel = Wheels(('w',), [0.0], [0.0], [0.0], [delta], [r], np.array([k]), [d])
    shape = RollerShape(r, d, delta)
    grid = np.linspace(-0.5, 0.5, 401)
    u, v = np.meshgrid(grid, np.linspace(-math.pi, math.pi, 721))
    points = wheel_from_roller(shape, surface(shape, u.ravel(), v.ravel()))
    for angle in (-0.3, -0.1, 0.0, 0.2, 0.34):
        y, z = points[:, 1], points[:, 2]
        height = y * math.sin(angle) + z * math.cos(angle)  # wheel turned by +angle about +x
        low = int(np.argmin(height))
        assert height[low] == pytest.approx(-r, abs=2e-6)  # grid of 2.5 mrad x 8.7 mrad
        contact = rate.contact_points(wheel, np.array([angle]))[0]
        across = y[low] * math.cos(angle) - z[low] * math.sin(angle)
        assert points[low, 0] == pytest.approx(contact[0], abs=2e-4)
        assert across == pytest.approx(contact[1], abs=3e-4)


@given(st.integers(3, 20), numbers(-50, 50))
def test_the_phase_stays_within_half_a_pitch(count, angle):
    wheel = Wheels(('w',), [0.0], [0.0], [0.0], [1.0], [0.05], np.array([count]), [0.01])
    u = float(rate.phase(wheel, np.array([angle]))[0])
    assert -math.pi / count <= u + 1e-12 and u < math.pi / count + 1e-12
    pitches = (angle - u) / (2 * math.pi / count)
    assert pitches == pytest.approx(round(pitches), abs=1e-9)


def test_an_unknown_roller_count_keeps_the_contact_in_the_middle():
    wheel = layouts.rectangle(0.2, 0.15, 0.05)
    np.testing.assert_array_equal(rate.phase(wheel, np.array([0.3, 1.0, 2.0, -4.0])), 0.0)


def test_a_missing_pin_radius_is_named():
    wheel = layouts.rectangle(0.2, 0.15, 0.05, roller_count=9)
    with pytest.raises(ConfigError, match=r'roller_pin_radius\[0\]'):
        rate.wheels_from_body(wheel, np.zeros(4))


def test_swedish_wheels_need_no_pin_radius_and_have_no_ripple():
    wheel = Wheels(('w',), [0.1], [0.2], [0.3], [math.pi / 2], [0.05], np.array([8]))
    twist = np.array([0.3, 0.4, 0.5])
    for angle in (0.0, 0.2, -0.35):
        np.testing.assert_allclose(rate.wheels_from_body(wheel, np.array([angle])) @ twist,
                                   wheels_from_body(wheel) @ twist, rtol=1e-12)
