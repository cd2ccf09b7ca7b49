"""Motions of the plane against homogeneous matrices, a fine Euler integration and hand cases."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mecanum_base.core import se2

LENGTHS = st.floats(-50.0, 50.0)
YAWS = st.floats(-3.1, 3.1)
POSES = st.tuples(LENGTHS, LENGTHS, YAWS).map(np.array)
SMALL = st.floats(-2e-4, 2e-4)  # both sides of the switch to the series


def matrix(pose):
    """The homogeneous matrix (3, 3) of a pose."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.array([[c, -s, pose[0]], [s, c, pose[1]], [0.0, 0.0, 1.0]])


def integrated(increment, steps=200_000):
    """Euler steps along a constant twist, at the middle of each step: error ~ (yaw/steps)^2."""
    yaw = (np.arange(steps) + 0.5) / steps * increment[2]
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([np.mean(c * increment[0] - s * increment[1]),
                     np.mean(s * increment[0] + c * increment[1]), increment[2]])


@given(POSES)
def test_the_exponential_undoes_the_logarithm(pose):
    # 1e-9: cot(yaw/2) next to +-pi loses up to three digits of 50 m
    assert se2.exp(se2.log(pose)) == pytest.approx(pose, abs=1e-9)


@given(POSES)
def test_the_logarithm_undoes_the_exponential(increment):
    assert se2.log(se2.exp(increment)) == pytest.approx(increment, abs=1e-9)


@given(POSES, POSES)
def test_composition_is_the_product_of_homogeneous_matrices(first, second):
    assert matrix(se2.compose(first, second)) == pytest.approx(
        matrix(first) @ matrix(second), abs=1e-11)


@given(POSES, POSES, POSES)
def test_composition_does_not_mind_brackets(a, b, c):
    assert se2.compose(se2.compose(a, b), c) == pytest.approx(
        se2.compose(a, se2.compose(b, c)), abs=1e-11)


@given(POSES)
def test_a_pose_and_its_inverse_cancel_both_ways(pose):
    assert se2.compose(pose, se2.inverse(pose)) == pytest.approx(np.zeros(3), abs=1e-11)
    assert se2.compose(se2.inverse(pose), pose) == pytest.approx(np.zeros(3), abs=1e-11)


@pytest.mark.parametrize('increment', [
    (1.0, 0.0, 1.0), (0.3, -0.7, -2.5), (0.0, 2.0, 0.1), (-1.0, 0.4, 6.0), (0.2, 0.1, 1e-3)])
def test_the_exponential_is_the_end_of_a_fine_integration(increment):
    assert se2.exp(np.array(increment)) == pytest.approx(integrated(increment), abs=1e-9)


@given(LENGTHS, LENGTHS, SMALL)
def test_small_turns_agree_with_their_taylor_series(dx, dy, turn):
    # first terms of sin a/a and (1 - cos a)/a; the next ones are below 1e-18 at 2e-4 rad
    along = 1.0 - turn ** 2 / 6.0 + turn ** 4 / 120.0
    across = turn / 2.0 - turn ** 3 / 24.0 + turn ** 5 / 720.0
    # 1e-10: (1 - cos a)/a itself keeps only 12 digits just above the switch
    assert se2.exp(np.array([dx, dy, turn])) == pytest.approx(
        [along * dx - across * dy, across * dx + along * dy, turn], abs=1e-10)


@pytest.mark.parametrize('turn', [1e-4, -1e-4])
def test_nothing_jumps_where_the_series_takes_over(turn):
    below, above = np.array([1.0, 2.0, turn * (1 - 1e-9)]), np.array([1.0, 2.0, turn * (1 + 1e-9)])
    assert se2.exp(below) == pytest.approx(se2.exp(above), abs=1e-11)


def test_no_turn_at_all_is_a_straight_line():
    assert se2.exp(np.array([0.25, -3.0, 0.0])).tolist() == [0.25, -3.0, 0.0]


def test_a_quarter_circle_of_one_metre_radius_ends_one_metre_ahead_and_left():
    quarter = se2.exp(np.array([math.pi / 2, 0.0, math.pi / 2]))
    assert quarter == pytest.approx([1.0, 1.0, math.pi / 2], abs=1e-15)


def test_yaw_is_not_wrapped_by_composition_and_exponential():
    pose = np.zeros(3)
    for _ in range(5):
        pose = se2.compose(pose, se2.exp(np.array([0.0, 0.0, 3.0])))
    assert pose[2] == pytest.approx(15.0, abs=1e-14)
    assert se2.exp(np.array([0.0, 0.0, 20.0]))[2] == 20.0


@given(st.floats(-100.0, 100.0))
def test_a_wrapped_angle_points_the_same_way_and_lies_within_half_a_turn(angle):
    wrapped = se2.wrap_angle(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-12)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-12)


@given(POSES, YAWS)
def test_the_rotation_matrix_turns_body_axes_as_composition_does(pose, yaw):
    moved = se2.compose(np.array([0.0, 0.0, yaw]), pose)
    assert se2.rotation(yaw) @ pose[:2] == pytest.approx(moved[:2], abs=1e-11)
