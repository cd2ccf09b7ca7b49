"""Potential field: closed forms, branches, keep-out (D21-D23 and our repulsion)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wheel_strategies import numbers

from mecanum_base.core import se2
from mecanum_base.core.command.goal import GoalConfig
from mecanum_base.core.command.potential_field import GoalField
from mecanum_base.core.errors import ConfigError

CONFIG = GoalConfig(max_speed=0.4, max_yaw_rate=1.2, slow_radius=0.3)
poses = st.tuples(numbers(-2, 2), numbers(-2, 2), numbers(-3, 3)).map(np.array)


def drive(field, pose, goal, reference, time, step=1e-3, **more):
    """Poses of the closed loop, midpoint rule, independent of the package's own stepping."""
    track = [pose]
    for _ in range(round(time / step)):
        first = field.twist(pose, goal, reference, **more)
        middle = pose + step / 2 * np.append(se2.rotation(pose[2]) @ first[:2], first[2])
        second = field.twist(middle, goal, reference, **more)
        pose = pose + step * np.append(se2.rotation(middle[2]) @ second[:2], second[2])
        track.append(pose)
    return np.array(track)


def test_the_distance_falls_linearly_then_exponentially_on_a_straight_line():
    goal, start = np.array([0.5, -0.3]), np.array([-0.3, 0.3, 1.0])
    track = drive(GoalField(CONFIG), start, goal, 1.0, 4.0)
    distance = np.hypot(*(track[:, :2] - goal).T)
    kink = (1.0 - 0.3) / 0.4
    for time in (0.5, 1.2, 2.0, 3.0, 4.0):
        want = 1.0 - 0.4 * time if time < kink else 0.3 * math.exp(-(time - kink) * 0.4 / 0.3)
        assert distance[round(time * 1000)] == pytest.approx(want, abs=1e-4)  # kink in a step
    off = (track[:, :2] - start[:2]) @ np.array([0.6, 0.8])  # across the line to the goal
    assert np.max(np.abs(off)) < 1e-9
    assert np.all(np.diff(distance) < 0)  # no overshoot


def test_the_heading_error_follows_its_closed_form_and_pi_is_an_equilibrium():
    field = GoalField(CONFIG)
    track = drive(field, np.array([0, 0, -1.9]), np.zeros(2), 0.6, 2.0)
    error = 0.6 - track[-1, 2]
    assert math.tan(error / 2) == pytest.approx(math.tan(2.5 / 2) * math.exp(-2.0 * 1.2), rel=1e-5)
    assert field.yaw_rate(math.pi) == pytest.approx(0.0, abs=1e-12)
    assert field.yaw_rate(0.2) > 0 > field.yaw_rate(-0.2)


@given(poses, st.tuples(numbers(-2, 2), numbers(-2, 2)).map(np.array), numbers(-3, 3))
def test_the_commanded_velocity_points_at_the_goal_with_the_speed_of_its_branch(pose, goal, ref):
    field = GoalField(GoalConfig(max_speed=0.4, slow_radius=0.3, stop_radius=0.05))
    twist = field.twist(pose, goal, ref)
    gap = goal - pose[:2]
    distance = math.hypot(*gap)
    speed = 0.4 if distance > 0.3 else 0.4 * distance / 0.3 if distance > 0.05 else 0.0
    c, s = math.cos(pose[2]), math.sin(pose[2])
    world = np.array([c * twist[0] - s * twist[1], s * twist[0] + c * twist[1]])
    np.testing.assert_allclose(world, speed * gap / distance if distance else 0.0, atol=1e-9)


def test_inside_the_stop_radius_the_base_stands_but_still_turns():
    field = GoalField(GoalConfig(stop_radius=0.05))
    twist = field.twist(np.zeros(3), np.array([0.04, 0.0]), 0.5)
    assert twist[0] == twist[1] == 0.0 and twist[2] > 0.0
    assert field.twist(np.zeros(3), np.zeros(2), 0.0) == pytest.approx([0, 0, 0])


def test_reached_means_near_and_aligned():
    field = GoalField(GoalConfig(position_tolerance=0.02, yaw_tolerance=0.1))
    goal = np.array([1.0, 0.0])
    assert field.reached(np.array([0.985, 0.0, 0.05 + 2 * math.pi]), goal, 0.0)
    assert not field.reached(np.array([0.97, 0.0, 0.0]), goal, 0.0)
    assert not field.reached(np.array([1.0, 0.0, 0.2]), goal, 0.0)
    wide = GoalField(GoalConfig(stop_radius=0.1))
    assert wide.reached(np.array([0.91, 0.0, 0.0]), goal, 0.0)  # it will not come nearer


def test_a_moving_goal_is_followed_with_lag_and_without_lag_with_feed_forward():
    field, speed = GoalField(CONFIG), np.array([0.1, 0.0, 0.0])
    for feed_forward, lag in ((None, 0.3 * 0.1 / 0.4), (speed, 0.0)):
        pose, step = np.array([-0.1, 0.0, 0.0]), 2e-3
        for index in range(5000):
            goal = np.array([0.1 * index * step, 0.0])
            twist = field.twist(pose, goal, 0.0, feed_forward)
            pose = pose + step * np.append(se2.rotation(pose[2]) @ twist[:2], twist[2])
        assert 0.1 * 5000 * step - pose[0] == pytest.approx(lag, abs=5e-4)


def test_feed_forward_is_given_in_the_world_and_turned_into_base_axes():
    field = GoalField(CONFIG)
    twist = field.twist(np.array([0, 0, math.pi / 2]), np.zeros(2), math.pi / 2,
                        np.array([0.1, 0.0, 0.3]))
    np.testing.assert_allclose(twist, [0.0, -0.1, 0.3], atol=1e-12)


def test_far_obstacles_do_not_matter():
    field = GoalField(CONFIG)
    args = (np.zeros(3), np.array([1.0, 0.0]), 0.0)
    np.testing.assert_array_equal(
        field.twist(*args), field.twist(*args, obstacles=np.array([[0.0, 0.81], [0.0, -3.0]])))
    none = field.twist(*args, obstacles=np.zeros((0, 2)))
    np.testing.assert_array_equal(field.twist(*args), none)


@given(st.lists(st.tuples(numbers(-1, 1), numbers(-1, 1)), min_size=1, max_size=8),
       st.integers(0, 10**6))
def test_no_obstacle_is_approached_beyond_its_keep_out_circle(points, seed):
    points = np.array(points)
    pose = np.random.default_rng(seed).uniform(-1.5, 1.5, 3)
    field = GoalField(CONFIG)
    twist = field.twist(pose, np.array([0.3, 0.2]), 0.0, obstacles=points)
    velocity = se2.rotation(pose[2]) @ twist[:2]
    away = pose[:2] - points
    reach = np.hypot(*away.T)
    if np.min(reach) < CONFIG.keep_out_radius:
        return  # already inside: the way out is another test
    allowed = CONFIG.max_speed * (reach - CONFIG.keep_out_radius) / 0.4
    approach = -(away @ velocity) / reach
    near = reach < CONFIG.influence_radius
    assert np.all(approach[near] <= allowed[near] + 1e-9)


def test_the_base_slides_round_an_obstacle_to_the_goal_and_keeps_its_distance():
    field, goal = GoalField(CONFIG), np.array([2.0, 0.0])
    point = np.array([[1.0, 0.01]])
    track = drive(field, np.zeros(3), goal, 0.0, 25.0, step=1e-2, obstacles=point)
    assert np.min(np.hypot(*(track[:, :2] - point[0]).T)) > CONFIG.keep_out_radius - 1e-3
    assert np.hypot(*(track[-1, :2] - goal)) < 0.05


def test_from_inside_a_keep_out_circle_the_base_drives_out():
    field = GoalField(CONFIG)
    twist = field.twist(np.array([0.2, 0.0, 0.0]), np.array([-1.0, 0.0]), 0.0,
                        obstacles=np.array([[0.0, 0.0]]))
    assert twist[0] > 0.0


def test_between_obstacles_on_all_sides_the_base_stands_rather_than_enters():
    ring = 0.41 * np.array([[math.cos(a), math.sin(a)] for a in np.arange(12) * math.pi / 6])
    twist = GoalField(CONFIG).twist(np.zeros(3), np.array([1.0, 0.3]), 0.0, obstacles=ring)
    assert math.hypot(twist[0], twist[1]) <= 0.4 * 0.01 / 0.4 / math.cos(math.pi / 12) + 1e-9


@pytest.mark.parametrize('values', [{'stop_radius': 0.2, 'slow_radius': 0.2},
                                    {'keep_out_radius': 0.8, 'influence_radius': 0.8}])
def test_radii_in_the_wrong_order_are_refused(values):
    with pytest.raises(ConfigError, match='must be (below|above)'):
        GoalConfig(**values)


def test_reached_is_judged_in_every_coordinate():
    field = GoalField(GoalConfig(position_tolerance=0.02, yaw_tolerance=0.1))
    assert field.reached(np.array([0.5, -0.7, 2.05]), np.array([0.51, -0.69]), 2.1)
    assert not field.reached(np.array([0.5, -0.7, 2.05]), np.array([0.5, 0.7]), 2.1)
    assert not field.reached(np.array([0.5, -0.7, 2.05]), np.array([0.5, -0.7]), -2.05)


def test_an_obstacle_repels_in_proportion_to_how_deep_the_base_stands():
    for repulsion, want in ((1.0, 0.2), (0.5, 0.1), (4.0, 0.4)):  # at most max_speed
        config = GoalConfig(max_speed=0.4, keep_out_radius=0.4, influence_radius=0.8,
                            repulsion=repulsion)
        twist = GoalField(config).twist(np.zeros(3), np.zeros(2), 0.0,
                                        obstacles=np.array([[0.36, 0.48]]))
        np.testing.assert_allclose(twist[:2], [-0.6 * want, -0.8 * want], atol=1e-12)


def test_without_repulsion_only_the_approach_is_slowed_and_the_rest_is_kept():
    config = GoalConfig(max_speed=0.4, keep_out_radius=0.4, influence_radius=0.8, repulsion=0.0)
    twist = GoalField(config).twist(np.zeros(3), np.array([3.0, 4.0]), 0.0,
                                    obstacles=np.array([[0.6, 0.0]]))
    # wanted (0.24, 0.32); towards the obstacle at most 0.4 (0.6 - 0.4) / 0.4 = 0.2
    np.testing.assert_allclose(twist[:2], [0.2, 0.32], atol=1e-9)


def test_a_narrow_wedge_of_obstacles_is_not_entered_faster_than_either_allows():
    config = GoalConfig(max_speed=0.4, keep_out_radius=0.4, influence_radius=0.8, repulsion=0.0)
    for spread in (60.0, 80.0, 87.0):
        bearings = np.radians([spread, -spread])
        points = 0.405 * np.column_stack([np.cos(bearings), np.sin(bearings)])
        for goal in ((2.0, 0.0), (2.0, 0.4), (1.0, -1.0)):
            twist = GoalField(config).twist(np.zeros(3), np.array(goal), 0.0, obstacles=points)
            assert np.all(points @ twist[:2] / 0.405 <= 0.4 * 0.005 / 0.4 + 1e-9)
            assert twist[0] > 0.0  # and it is not stopped for nothing
