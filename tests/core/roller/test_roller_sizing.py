"""Sizing: take-over, gaps, limits and clearance, partly against brute force."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.roller import shape as model
from mecanum_base.core.roller import sizing
from mecanum_base.core.roller.mesh import roller_mesh, wheel_mesh
from mecanum_base.core.roller.shape import RollerShape

SHAPE = RollerShape(0.05, 0.038, math.pi / 4)


def test_the_shortest_roller_just_takes_over():
    found = sizing.size(SHAPE, 9)
    assert found.contact_ratio == 1.0 and found.axis_drop == 0.0
    assert found.end_radius == found.handover_radius
    assert sizing.size(SHAPE, 9, found.min_length).contact_ratio == pytest.approx(1.0, rel=1e-9)
    assert sizing.size(SHAPE, 9, found.min_length * 1.1).contact_ratio > 1.0


@pytest.mark.parametrize('delta', [math.pi / 4, -0.9, math.pi / 2])
def test_too_short_a_roller_drops_the_axis_onto_its_end_rims(delta):
    shape = RollerShape(0.05, 0.038, delta)
    count = 8
    length = 0.8 * sizing.size(shape, count).min_length
    found = sizing.size(shape, count, length)
    assert found.contact_ratio < 1.0
    # brute force: lowest point of the truncated roller with the wheel turned to mid-gap
    u, v = np.meshgrid(np.linspace(-found.reach, found.reach, 401),
                       np.linspace(-math.pi, math.pi, 3601))
    x, y, z = model.wheel_from_roller(shape, model.surface(shape, u.ravel(), v.ravel())).T
    low = -np.min(y * math.sin(math.pi / count) + z * math.cos(math.pi / count))
    assert found.axis_drop == pytest.approx(shape.radius - low, abs=1e-7)
    assert found.axis_drop > 1e-6


def test_reach_and_length_are_inverse():
    for u in (0.1, 0.3, 0.6):
        assert sizing.reach_of_length(SHAPE, 2 * sizing.half_length(SHAPE, u)) == \
            pytest.approx(u, rel=1e-12)


def test_a_pin_circle_too_large_for_the_roller_count_is_refused_with_the_reason():
    limit = 0.05 * math.cos(math.pi / 9)
    with pytest.raises(ConfigError, match='end in a point before the next roller'):
        sizing.size(RollerShape(0.05, limit, math.pi / 4), 9)
    assert sizing.size(RollerShape(0.05, limit - 1e-6, math.pi / 4), 9).handover_radius < 1e-3


def test_lengths_no_roller_can_have_and_counts_no_wheel_can_have_are_refused():
    longest = sizing.size(SHAPE, 9).max_length
    for length in (0.0, -0.01, longest * 1.001):
        with pytest.raises(ConfigError, match='length'):
            sizing.size(SHAPE, 9, length)
    with pytest.raises(ConfigError, match='at least 3'):
        sizing.size(SHAPE, 2)


@pytest.mark.parametrize('delta', [math.pi / 4, 1.1, -0.6])
def test_the_clearance_is_the_distance_of_the_two_surfaces(delta):
    shape, count = RollerShape(0.05, 0.0425, delta), 8
    length = sizing.size(shape, count).length
    one, _ = roller_mesh(shape, length, rings=61, sectors=90)
    both, _ = wheel_mesh(shape, count, length, rings=61, sectors=90)
    rings = 61 * 90  # surface points only, without the centres of the end caps
    first, second = both[:rings], both[len(one):len(one) + rings]
    nearest = float(cKDTree(second).query(first)[0].min())
    gap = sizing.neighbour_clearance(shape, count, length)
    # the gap is measured across this roller's axis: at most 1 / cos(slope) = 8 % more than the
    # true distance; the point clouds are 1 mm apart
    assert nearest - 1.0e-3 < gap < 1.1 * nearest + 1.0e-3 and gap > 1e-3


@pytest.mark.parametrize('delta', [math.pi / 4, 1.1, -0.6])
def test_the_clearance_is_measured_across_the_axis_of_the_other_roller(delta):
    shape, count = RollerShape(0.05, 0.0405, delta), 9
    length = sizing.size(shape, count).length
    one, _ = roller_mesh(shape, length, rings=61, sectors=120)
    both, _ = wheel_mesh(shape, count, length, rings=61, sectors=120)
    points = both[len(one):len(one) + 61 * 120] - [0.0, 0.0, -shape.pin_radius]
    axis = np.array([math.cos(delta), math.sin(delta), 0.0])
    along = points @ axis
    apart = np.linalg.norm(points - np.outer(along, axis), axis=1)
    inside = np.abs(along) < length / 2
    places, radii = model.meridian(shape, np.linspace(0.0, math.pi / count, 5000))
    own = np.interp(np.abs(along[inside]), np.abs(places), radii)
    # two samplings of the same surface, 0.4 mm and 3 degrees apart
    assert sizing.neighbour_clearance(shape, count, length) == pytest.approx(
        float(np.min(apart[inside] - own)), abs=5e-5)


def test_rollers_that_intersect_have_negative_clearance_and_a_larger_pin_circle_cures_it():
    length = sizing.size(SHAPE, 9).length
    assert sizing.neighbour_clearance(SHAPE, 9, length) < -0.003
    clear = sizing.clear_pin_radius(SHAPE, 9, None)
    assert 0.039 < clear < 0.041
    cured = RollerShape(0.05, clear + 2e-4, math.pi / 4)
    assert sizing.neighbour_clearance(cured, 9, sizing.size(cured, 9).length) > 0.0
    worse = RollerShape(0.05, clear - 2e-4, math.pi / 4)
    assert sizing.neighbour_clearance(worse, 9, sizing.size(worse, 9).length) < 0.0


def test_mirrored_rollers_have_the_same_sizes():
    left, right = (sizing.size(RollerShape(0.05, 0.038, s * 0.9), 9, 0.03) for s in (1, -1))
    assert left == right
