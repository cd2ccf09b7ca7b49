"""Theorem 2: constructed bases with and without a free motion."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from wheel_strategies import numbers, wheel_sets

from mecanum_base.core.errors import GeometryError
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.lines import name_motion, roller_lines
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.mobility import POOR, assess, require_mobile, visible_slip
from mecanum_base.core.kinematics.mounting import judge_mounting, mirrored, yaw_lever
from mecanum_base.core.kinematics.wheels import Wheels


def with_directions(x, y, directions, axle):
    """Wheels whose roller axes on the ground point along ``directions``."""
    axle = np.asarray(axle)
    count = len(axle)
    return Wheels(tuple(f'w{i}' for i in range(count)), x, y, axle,
                  np.asarray(directions) - axle, [0.05] * count)


@st.composite
def concurrent_sets(draw):
    count = draw(st.integers(3, 6))
    place = np.array([draw(numbers(-0.6, 0.6)), draw(numbers(-0.6, 0.6))])
    spokes = np.linspace(0.1, 3.0, count) + draw(numbers(-0.4, 0.4))
    reach = np.array(draw(st.lists(numbers(0.2, 0.7), min_size=count, max_size=count)))
    x, y = place[0] + reach * np.cos(spokes), place[1] + reach * np.sin(spokes)
    axle = spokes + np.array(draw(st.lists(numbers(0.4, 2.5), min_size=count, max_size=count)))
    return place, with_directions(x, y, spokes, axle)


@given(concurrent_sets())
def test_rollers_that_meet_in_a_point_leave_the_rotation_about_it_free(case):
    place, wheels = case
    verdict = assess(wheels)
    assert verdict.rank == 2 and verdict.redundancy == wheels.count - 2
    motion = name_motion(verdict.self_motion)
    assert motion.kind == 'rotation'
    assert motion.centre == pytest.approx(tuple(place), abs=1e-6)
    assert motion.twist == pytest.approx([place[1], -place[0], 1.0], abs=1e-6)
    assert np.max(np.abs(wheels_from_body(wheels) @ motion.twist)) < 1e-6
    assert 'meet in that point' in verdict.text


@given(numbers(-1.5, 1.5), st.lists(numbers(-0.5, 0.5), min_size=4, max_size=4, unique=True))
def test_parallel_rollers_leave_the_translation_across_them_free(direction, places):
    assume(max(places) - min(places) > 0.2)
    # spread across the rollers, so that they are not one single line
    x = -math.sin(direction) * np.array(places)
    y = math.cos(direction) * np.array(places)
    wheels = with_directions(x, y, [direction] * 4, [direction + 0.9, direction - 1.2,
                                                     direction + 1.5, direction + 0.6])
    verdict = assess(wheels)
    assert verdict.rank == 2
    motion = name_motion(verdict.self_motion)
    across = np.array([-math.sin(direction), math.cos(direction)])
    assert motion.kind == 'translation'
    assert abs(motion.twist[:2] @ across) == pytest.approx(1.0, abs=1e-9)
    assert 'parallel' in verdict.text


@given(wheel_sets(3, 3))
def test_three_wheels_drive_exactly_if_the_determinant_of_the_roller_lines_is_not_zero(wheels):
    size = abs(float(np.linalg.det(roller_lines(wheels))))
    assume(size > 1e-3 or size < 1e-12)  # between, the verdict depends on the scale of the base
    assert (assess(wheels).rank == 3) == (size > 1e-3)


def test_all_rollers_on_one_line_leave_two_motions_free():
    wheels = with_directions([0.1, 0.2, 0.4], [0.0, 0.0, 0.0], [0.0] * 3, [1.0, 1.2, 2.0])
    verdict = assess(wheels)
    assert verdict.rank == 1 and 'more free motion' in verdict.text


def test_a_square_base_with_mirrored_rollers_is_refused_and_the_cure_is_named():
    good = layouts.rectangle(0.2, 0.2, 0.05)
    with pytest.raises(GeometryError, match=r'rank 2 of 3.*point \(0, 0\).*rollers mirrored'):
        require_mobile(mirrored(good))
    assert require_mobile(good).rank == 3


def test_the_contact_correction_does_not_hide_a_singular_mounting():
    base = mirrored(layouts.rectangle(0.2, 0.2, 0.05, roller_count=9, pin_radius=0.038))
    assert assess(base).rank == 2


def test_mirrored_rollers_of_an_oblong_base_are_noticed_by_the_yaw_lever():
    base = layouts.rectangle(0.2, 0.3, 0.05)
    np.testing.assert_allclose(yaw_lever(base), 0.5, rtol=1e-12)
    np.testing.assert_allclose(yaw_lever(mirrored(base)), 0.1, rtol=1e-12)
    found = judge_mounting(mirrored(base))
    assert found.suspicious and 'mirrored' in found.text()
    assert not judge_mounting(base).suspicious


def test_swedish_wheels_cannot_be_mounted_mirrored():
    assert not judge_mounting(layouts.swedish_ring(0.2, 0.05, [0.0, 2.0, 4.0])).suspicious


def test_an_almost_singular_base_is_called_so():
    base = mirrored(layouts.rectangle(0.2, 0.205, 0.05))
    verdict = assess(base)
    assert verdict.rank == 3 and verdict.condition < POOR and 'nearly singular' in verdict.text


def test_the_verdict_does_not_depend_on_the_unit_of_length_or_the_choice_of_origin():
    small, large = layouts.rectangle(0.02, 0.015, 0.005), layouts.rectangle(20.0, 15.0, 5.0)
    assert assess(small).condition == pytest.approx(assess(large).condition, rel=1e-9)
    moved = Wheels(small.joint, small.x + 3.0, small.y - 2.0, small.axle, small.roller,
                   small.radius)
    assert assess(moved).condition == pytest.approx(assess(small).condition, rel=1e-6)


def test_two_wheels_are_too_few():
    pair = Wheels(('a', 'b'), [0, 0], [0.1, -0.1], [1.57, 1.57], [0.8, -0.8], [0.05, 0.05])
    with pytest.raises(GeometryError, match='at least 3'):
        require_mobile(pair)


def test_visible_slip_has_one_row_per_redundant_wheel():
    assert visible_slip(layouts.rectangle(0.2, 0.15, 0.05)).shape == (1, 4)
    assert visible_slip(layouts.swedish_ring(0.2, 0.05, [0.0, 2.0, 4.0])).shape == (0, 3)


def test_a_rotation_about_the_middle_is_named_without_negative_zero():
    assert name_motion(np.array([0.0, -0.0, 2.0])).text() == 'rotation about the point (0, 0) m'
    assert name_motion(np.array([0.0, 2.0, 0.0])).text() == 'translation along the bearing 90 deg'


def test_the_sentence_counts_the_redundant_equations():
    assert '; 1 redundant wheel equation' in assess(layouts.rectangle(0.2, 0.15, 0.05)).text
    six = layouts.swedish_ring(0.2, 0.05, np.arange(6.0))
    assert assess(six).text.endswith('3 redundant wheel equations')
    assert 'no redundancy' in assess(layouts.swedish_ring(0.2, 0.05, [0.0, 2.0, 4.0])).text
