"""Meshes: closed, oriented, of the right size and place."""

import math

import numpy as np
import pytest

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.roller.mesh import roller_mesh, wheel_mesh
from mecanum_base.core.roller.shape import RollerShape, meridian
from mecanum_base.core.roller.sizing import size

SHAPES = [RollerShape(0.05, 0.04, math.pi / 4), RollerShape(0.05, 0.04, -0.9),
          RollerShape(0.06, 0.045, math.pi / 2), RollerShape(0.05, 0.04, 2.3)]


def edges_are_shared_twice_in_opposite_directions(faces):
    directed = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    seen = {tuple(edge) for edge in directed.tolist()}
    return len(seen) == len(directed) and all((b, a) in seen for a, b in seen)


def volume(vertices, faces):
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.sum(a * np.cross(b, c))) / 6.0


@pytest.mark.parametrize('shape', SHAPES)
@pytest.mark.parametrize('bore', [0.0, 0.003])
def test_a_roller_is_watertight_points_outwards_and_has_the_volume_of_its_meridian(shape, bore):
    length = size(shape, 9).length
    vertices, faces = roller_mesh(shape, length, bore=bore, rings=80, sectors=120)
    assert edges_are_shared_twice_in_opposite_directions(faces)
    u = np.linspace(-math.pi / 9, math.pi / 9, 4001)
    along, radius = meridian(shape, u)
    step = np.abs(np.diff(along))
    want = math.pi * float(np.sum(step * ((radius[1:] + radius[:-1]) / 2) ** 2)) \
        - math.pi * bore ** 2 * length
    # a polygon of 120 sides has 0.05 % less area than its circle
    assert volume(vertices, faces) == pytest.approx(want, rel=2e-3)
    assert np.max(vertices[:, 0]) == pytest.approx(length / 2, rel=1e-9)


def test_the_set_is_closed_and_no_roller_reaches_beyond_the_wheel():
    shape, count = SHAPES[0], 9
    length = size(shape, count).length
    vertices, faces = wheel_mesh(shape, count, length, rings=40, sectors=60)
    one, _ = roller_mesh(shape, length, rings=40, sectors=60)
    assert len(vertices) == count * len(one)
    assert edges_are_shared_twice_in_opposite_directions(faces)
    assert np.min(faces) == 0 and np.max(faces) == len(vertices) - 1
    reach = np.hypot(vertices[:, 1], vertices[:, 2])
    assert np.max(reach) == pytest.approx(shape.radius, rel=1e-3)
    assert np.max(reach) <= shape.radius * (1 + 1e-12)


def test_a_bore_wider_than_the_ends_is_refused():
    with pytest.raises(ConfigError, match='bore'):
        roller_mesh(SHAPES[0], size(SHAPES[0], 9).length, bore=0.02)


def test_the_ends_are_the_narrowest_place_for_the_bore():
    found = size(SHAPES[0], 9)
    roller_mesh(SHAPES[0], found.length, bore=found.end_radius * 0.999, rings=8, sectors=8)
    with pytest.raises(ConfigError, match='bore'):
        roller_mesh(SHAPES[0], found.length, bore=found.end_radius * 1.001, rings=8, sectors=8)
