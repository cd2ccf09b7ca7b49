"""H and its inverses against written-out listings and laws of rigid motion."""

import math

import numpy as np
import pytest
from hypothesis import given
from wheel_strategies import mobile_sets, numbers, twists, wheel_sets

from mecanum_base.core.kinematics import layouts, solve
from mecanum_base.core.kinematics.matrix import effective_roller, wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels

CLOSE = {'rtol': 1e-9, 'atol': 1e-9}  # a few roundings of numbers of order 1 to 100


def turned(wheels, angle):
    """The same base drawn on a sheet that is turned by ``angle``."""
    c, s = math.cos(angle), math.sin(angle)
    return Wheels(wheels.joint, c * wheels.x - s * wheels.y, s * wheels.x + c * wheels.y,
                  wheels.axle + angle, wheels.roller, wheels.radius, wheels.roller_count,
                  wheels.roller_pin_radius)


def test_the_usual_base_follows_the_listing_of_source_r():
    lx, ly, r = 0.2, 0.15, 0.05
    vx, vy, w = 0.7, -0.3, 1.1
    k = lx + ly
    listing = np.array([vx - vy - k * w, vx + vy + k * w, vx + vy - k * w, vx - vy + k * w]) / r
    rates = wheels_from_body(layouts.rectangle(lx, ly, r)) @ [vx, vy, w]
    np.testing.assert_allclose(rates, listing, **CLOSE)


def test_driving_forward_turns_every_wheel_forward_and_strafing_splits_the_diagonals():
    matrix = wheels_from_body(layouts.rectangle(0.2, 0.15, 0.05))
    assert np.all(matrix[:, 0] > 0)
    assert (np.sign(matrix[:, 1]) == [-1, 1, 1, -1]).all()  # to the left: FL and RR backwards
    assert (np.sign(matrix[:, 2]) == [-1, 1, -1, 1]).all()  # ccw: right wheels forward


def test_a_roller_angle_other_than_45_degrees_scales_sideways_travel_by_its_cotangent():
    lx, ly, r, delta = 0.25, 0.18, 0.06, 0.6
    vx, vy, w = 0.4, 0.5, -0.9
    cot = 1.0 / math.tan(delta)
    k = lx * cot + ly
    want = np.array([vx - cot * vy - k * w, vx + cot * vy + k * w,
                     vx + cot * vy - k * w, vx - cot * vy + k * w]) / r
    np.testing.assert_allclose(wheels_from_body(layouts.rectangle(lx, ly, r, delta)) @ [vx, vy, w],
                               want, **CLOSE)


def test_swedish_wheels_on_a_ring_push_counter_clockwise():
    distance, r = 0.21, 0.04
    mounts = np.radians([30.0, 150.0, 270.0])
    vx, vy, w = 0.3, -0.8, 0.5
    want = (-np.sin(mounts) * vx + np.cos(mounts) * vy + distance * w) / r
    np.testing.assert_allclose(
        wheels_from_body(layouts.swedish_ring(distance, r, mounts)) @ [vx, vy, w], want, **CLOSE)


@given(wheel_sets(), twists)
def test_the_rim_gives_the_wheel_centre_its_velocity_along_the_roller(wheels, twist):
    rates = wheels_from_body(wheels) @ twist
    for i in range(wheels.count):
        velocity = twist[:2] + twist[2] * np.array([-wheels.y[i], wheels.x[i]])
        along = np.array([math.cos(wheels.axle[i] + wheels.roller[i]),
                          math.sin(wheels.axle[i] + wheels.roller[i])])
        # material point of the wheel at the ground: centre + u a x (0, 0, -r)
        rim = rates[i] * wheels.radius[i] * np.array([-math.sin(wheels.axle[i]),
                                                      math.cos(wheels.axle[i])])
        assert along @ (velocity + rim) == pytest.approx(0.0, abs=1e-9)


@given(mobile_sets(), twists)
def test_forward_undoes_inverse_and_the_projector_sees_nothing(wheels, twist):
    matrix = wheels_from_body(wheels)
    rates = matrix @ twist
    for weighting in solve.WEIGHTINGS:
        back = solve.body_from_wheels(matrix, solve.weights(wheels, weighting)) @ rates
        np.testing.assert_allclose(back, twist, rtol=1e-7, atol=1e-8)  # condition up to 10
    scale = max(1.0, float(np.max(np.abs(rates))))
    assert np.max(np.abs(solve.parity_projector(matrix) @ rates)) < 1e-10 * scale
    assert np.max(np.abs(solve.parity_basis(matrix) @ rates), initial=0.0) < 1e-10 * scale


@given(mobile_sets(low=4), numbers(-3.0, 3.0))
def test_what_forward_leaves_over_is_the_projected_rates(wheels, tilt):
    matrix = wheels_from_body(wheels)
    rates = np.cos(np.arange(wheels.count) * (1.3 + tilt))
    left = rates - matrix @ (solve.body_from_wheels(matrix) @ rates)
    np.testing.assert_allclose(solve.parity_projector(matrix) @ rates, left, **CLOSE)
    basis = solve.parity_basis(matrix)
    np.testing.assert_allclose(basis.T @ (basis @ rates), left, **CLOSE)


@given(mobile_sets(), twists, numbers(-3.0, 3.0))
def test_turning_the_whole_drawing_turns_the_twist_and_keeps_the_rates(wheels, twist, angle):
    c, s = math.cos(angle), math.sin(angle)
    seen = np.array([c * twist[0] - s * twist[1], s * twist[0] + c * twist[1], twist[2]])
    np.testing.assert_allclose(wheels_from_body(turned(wheels, angle)) @ seen,
                               wheels_from_body(wheels) @ twist, rtol=1e-8, atol=1e-8)


@given(mobile_sets(counted=True), twists)
def test_in_a_mirror_the_base_drives_mirrored(wheels, twist):
    # reflection in the x axis; an axle is an axial vector: its reflection points backwards too
    image = Wheels(wheels.joint, wheels.x, -wheels.y, math.pi - wheels.axle, -wheels.roller,
                   wheels.radius, wheels.roller_count, wheels.roller_pin_radius)
    np.testing.assert_allclose(wheels_from_body(image) @ (twist * [1, -1, -1]),
                               wheels_from_body(wheels) @ twist, rtol=1e-8, atol=1e-8)


@given(wheel_sets(counted=True), twists)
def test_a_roller_angle_and_its_opposite_end_are_the_same_roller(wheels, twist):
    flipped = Wheels(wheels.joint, wheels.x, wheels.y, wheels.axle, wheels.roller + math.pi,
                     wheels.radius, wheels.roller_count, wheels.roller_pin_radius)
    np.testing.assert_allclose(wheels_from_body(flipped) @ twist, wheels_from_body(wheels) @ twist,
                               rtol=1e-8, atol=1e-8)


def test_the_contact_correction_shortens_sideways_travel_by_the_chord_over_the_arc():
    wheels = layouts.rectangle(0.2, 0.15, 0.05, roller_count=9, pin_radius=0.038)
    half = math.pi / 9
    ratio = wheels_from_body(wheels)[0, 1] / wheels_from_body(wheels, corrected=False)[0, 1]
    assert ratio == pytest.approx(half / math.sin(half), rel=1e-12)
    assert wheels_from_body(wheels)[0, 0] == pytest.approx(20.0, rel=1e-12)  # forward: untouched


def test_the_contact_correction_leaves_swedish_wheels_and_unknown_counts_alone():
    roller = np.array([math.pi / 2, -math.pi / 2, 0.7, -2.4])
    base = Wheels(('a', 'b', 'c', 'd'), [0.1] * 4, [0.2] * 4, [0.0] * 4, roller, [0.05] * 4,
                  np.array([8, 8, 0, 0]))
    np.testing.assert_allclose(effective_roller(base), roller, atol=1e-12)


def test_the_parity_of_the_usual_base_is_front_minus_rear():
    null = solve.null_vector(wheels_from_body(layouts.rectangle(0.3, 0.2, 0.05, 0.5)))
    np.testing.assert_allclose(null, [1, 1, -1, -1], atol=1e-12)


@given(mobile_sets(low=4, high=4))
def test_the_null_vector_of_any_four_wheels_annihilates_every_motion(wheels):
    matrix = wheels_from_body(wheels)
    null = solve.null_vector(matrix)
    assert np.max(np.abs(null @ matrix)) < 1e-9 * np.max(np.abs(matrix))
    assert np.max(null) == pytest.approx(1.0) and np.max(np.abs(null)) == pytest.approx(1.0)


def test_there_is_no_single_null_vector_for_three_or_six_wheels():
    for wheels in (layouts.swedish_ring(0.2, 0.05, [0.0, 2.0, 4.0]),
                   layouts.swedish_ring(0.2, 0.05, np.arange(6.0))):
        with pytest.raises(ValueError, match='not one'):
            solve.null_vector(wheels_from_body(wheels))


def test_an_unknown_weighting_is_refused():
    with pytest.raises(ValueError, match='rate'):
        solve.weights(layouts.rectangle(0.2, 0.1, 0.05), 'metres')


def test_weighting_by_slip_trusts_a_large_wheel_more():
    wheels = Wheels(('a', 'b', 'c', 'd'), [.2, .2, -.2, -.2], [.15, -.15, .15, -.15],
                    [math.pi / 2] * 4, [.8, -.8, -.8, .8], [0.1, 0.05, 0.05, 0.05])
    matrix, rates = wheels_from_body(wheels), np.array([1.0, 0.0, 0.0, 0.0])
    left = [np.abs((rates - matrix @ (solve.body_from_wheels(matrix, solve.weights(
        wheels, weighting)) @ rates))[0]) for weighting in solve.WEIGHTINGS]
    assert left[1] < left[0]
