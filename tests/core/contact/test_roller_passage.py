"""One roller passing over the ground: extremes, mean and travel against brute force."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from wheel_strategies import mobile_sets, twists

from mecanum_base.core.contact import passage as model
from mecanum_base.core.contact.rate import local_radii, roller_speeds, wheels_from_body
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.wheels import Wheels


@settings(max_examples=20)
@given(mobile_sets(counted=True), twists)
def test_extremes_and_mean_are_those_of_a_fine_scan(wheels, twist):
    found = model.passage(wheels, twist)
    half = math.pi / wheels.roller_count
    ends = np.array([wheels_from_body(wheels, s * half * (1 - 1e-12)) @ twist for s in (-1, 1)])
    share = (np.arange(300) + 0.5) / 150 - 1  # midpoints of 300 intervals
    scan = np.array([wheels_from_body(wheels, s * half) @ twist for s in share])
    size = np.max(np.abs(scan))
    low, high = (f(np.vstack([scan, ends]), axis=0) for f in (np.min, np.max))
    np.testing.assert_allclose(found.low, low, atol=3e-4 * size)  # parabola between scan points
    np.testing.assert_allclose(found.high, high, atol=3e-4 * size)
    assert np.all(found.low <= low + 1e-9 * size) and np.all(found.high >= high - 1e-9 * size)
    np.testing.assert_allclose(found.mean, np.mean(scan, axis=0), atol=2e-5 * size)


@pytest.mark.parametrize('delta', [0.5, math.pi / 4, -1.1])
def test_sideways_travel_per_pitch_is_the_chord_and_not_the_arc(delta):
    r, d, k = 0.05, 0.036, 8
    wheel = Wheels(('w',), [0.1], [0.0], [math.pi / 2], [delta], [r], np.array([k]), [d])
    # integrate d(travel)/d(angle) = 1 / (rate per m/s) over one pitch
    u = np.linspace(-math.pi / k, math.pi / k, 4001)[:-1] + math.pi / k / 4000
    step = [1.0 / wheels_from_body(wheel, np.array([a]))[0, 1] for a in u]
    travel = abs(sum(step)) * 2 * math.pi / k / 4000
    assert model.lateral_travel(wheel)[0] == pytest.approx(travel, rel=1e-6)
    nominal = 2 * r * abs(math.tan(delta)) * math.pi / k
    assert model.lateral_scale(k) == pytest.approx(travel / nominal, rel=1e-6)


def test_a_passage_needs_the_roller_count():
    with pytest.raises(ValueError, match='roller count'):
        model.passage(layouts.rectangle(0.2, 0.15, 0.05), np.ones(3))


def test_the_roller_surface_moves_with_lambda_and_the_local_radius_shrinks_to_the_ends():
    wheel = Wheels(('w',), [0.0], [0.0], [0.0], [math.pi / 4], [0.05], np.array([9]), [0.038])
    along = roller_speeds(wheel, np.array([0.0]), np.array([0.3, 0.0, 0.0]))[0]
    assert along == pytest.approx(0.3 / math.sin(math.pi / 4))  # v along the axle / sin(delta)
    radii = [local_radii(wheel, np.array([a]))[0] for a in (0.0, 0.2, 0.349)]
    assert radii[0] == pytest.approx(0.012) and radii[0] > radii[1] > radii[2] > 0.009
