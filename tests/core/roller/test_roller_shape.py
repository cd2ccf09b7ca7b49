"""Curve, surface, meridian and torus of a roller: mutual consistency and brute force."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wheel_strategies import numbers

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.roller import shape as model
from mecanum_base.core.roller import torus
from mecanum_base.core.roller.shape import RollerShape

deltas = st.one_of(numbers(0.4, 1.5), numbers(-1.5, -0.4), st.just(math.pi / 2))
shapes = st.builds(lambda r, share, delta: RollerShape(r, share * r, delta),
                   numbers(0.02, 0.2), numbers(0.5, 0.85), deltas)
turns = st.lists(numbers(-0.45, 0.45), min_size=5, max_size=5).map(np.array)


@given(shapes, turns)
def test_the_curve_lies_on_the_wheel_cylinder_and_on_its_paraboloid(shape, u):
    x, y, z = model.contact_curve(shape, u).T
    np.testing.assert_allclose(np.hypot(y, z), shape.radius, rtol=1e-12)
    cot = 1 / math.tan(shape.angle)
    np.testing.assert_allclose(x * z + shape.pin_radius * cot * y, 0.0, atol=1e-12)


@given(shapes, turns)
def test_the_curve_in_roller_axes_is_the_same_curve(shape, u):
    back = model.wheel_from_roller(shape, model.contact_curve_of_roller(shape, u))
    np.testing.assert_allclose(back, model.contact_curve(shape, u), atol=1e-12)


@given(shapes, turns)
def test_the_meridian_is_the_distance_of_the_curve_from_the_roller_axis(shape, u):
    along, radius = model.meridian(shape, u)
    x, y, z = model.contact_curve_of_roller(shape, u).T
    np.testing.assert_allclose(radius, np.hypot(y, z), rtol=1e-9)
    np.testing.assert_allclose(along, x, atol=1e-15)


@given(shapes, turns, numbers(-3, 3))
def test_the_surface_is_the_curve_turned_about_the_roller_axis(shape, u, v):
    points = model.surface(shape, u, np.full(5, v))
    x, y, z = model.contact_curve_of_roller(shape, u).T
    c, s = math.cos(v), math.sin(v)
    np.testing.assert_allclose(points[:, 1] + 1j * points[:, 2], (y + 1j * z) * (c + 1j * s),
                               atol=1e-12)
    np.testing.assert_allclose(points[:, 0], x)


@given(shapes)
def test_the_knot_is_where_the_roller_has_no_radius_left(shape):
    knot = np.array([shape.knot * (1 - 1e-12)])
    np.testing.assert_allclose(model.contact_curve(shape, knot)[0], model.knot_point(shape),
                               atol=1e-6)
    assert abs(model.meridian(shape, knot)[1][0]) < 1e-6
    assert model.meridian(shape, np.zeros(1))[1][0] == pytest.approx(shape.equator_radius)


@given(shapes, numbers(-0.4, 0.4))
def test_the_curve_touches_the_ground_and_nothing_lies_deeper(shape, angle):
    """The wheel turned by angle stands on c(-angle) at height r: brute force over the roller."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 161), np.linspace(-math.pi, math.pi, 181))
    x, y, z = model.wheel_from_roller(shape, model.surface(shape, u.ravel(), v.ravel())).T
    height = y * math.sin(angle) + z * math.cos(angle)
    assert np.min(height) > -shape.radius * (1 + 1e-9)
    assert np.min(height) == pytest.approx(-shape.radius, rel=1e-3)


@given(shapes)
def test_the_torus_osculates_in_the_middle(shape):
    found = torus.torus_of(shape)
    # curvature radius and height of the meridian in the middle, by finite differences
    h = 1e-3
    along, radius = model.meridian(shape, np.array([-h, 0.0, h]))
    bend = (radius[0] - 2 * radius[1] + radius[2]) / along[2] ** 2
    assert -1 / bend == pytest.approx(found.meridian_radius, rel=1e-4)
    assert found.meridian_radius - found.centre_radius == pytest.approx(shape.equator_radius)


@given(st.builds(lambda r, share, delta: RollerShape(r, share * r, delta),
                 numbers(0.02, 0.2), numbers(0.5, 0.85), numbers(0.4, 1.2)))
def test_the_torus_leaves_the_meridian_with_the_fourth_power(shape):
    u = np.array([0.02])
    want = shape.pin_radius * math.cos(shape.angle) ** 2 * u ** 4 / 8
    assert torus.meridian_deviation(shape, u)[0] == pytest.approx(want[0], rel=0.02)
    assert torus.axis_height_error(shape, u)[0] == pytest.approx(-want[0], rel=0.02)
    assert torus.axis_height_error_leading(shape, u)[0] == pytest.approx(-want[0], rel=1e-9)
    # f vanishes to third order: doubling u multiplies it by 16
    one, two = (torus.torus_equation(shape, np.array([step]))[0] for step in (0.04, 0.08))
    assert two / one == pytest.approx(16.0, rel=0.03)


@given(shapes, turns)
def test_the_torus_radius_solves_the_torus_equation(shape, u):
    along, radius = model.meridian(shape, u)
    found = torus.torus_of(shape)
    assert np.all(np.abs((torus.torus_radius(shape, along) + found.centre_radius) ** 2
                         + along ** 2 - found.meridian_radius ** 2) < 1e-12)
    assert np.max(np.abs(torus.torus_radius(shape, along) - radius)) < 0.02 * shape.radius


@given(numbers(0.02, 0.2), numbers(0.4, 0.9), turns)
def test_a_swedish_roller_is_a_circle_and_its_torus_is_exact(r, share, u):
    shape = RollerShape(r, share * r, math.pi / 2)
    along, radius = model.meridian(shape, u)
    np.testing.assert_allclose(along ** 2 + (radius + shape.pin_radius) ** 2, r * r, rtol=1e-12)
    np.testing.assert_allclose(torus.meridian_deviation(shape, u), 0.0, atol=1e-12)
    np.testing.assert_allclose(torus.axis_height_error(shape, u), 0.0, atol=1e-12)


@pytest.mark.parametrize(('values', 'key'), [
    ((0.0, 0.01, 0.8), 'radius'), ((float('nan'), 0.01, 0.8), 'radius'),
    ((0.05, 0.0, 0.8), 'pin_radius'), ((0.05, 0.05, 0.8), 'pin_radius'),
    ((0.05, 0.04, 0.0), 'angle'), ((0.05, 0.04, math.pi), 'angle')])
def test_an_impossible_roller_is_refused_by_name(values, key):
    with pytest.raises(ConfigError) as caught:
        RollerShape(*values)
    assert caught.value.key == key
