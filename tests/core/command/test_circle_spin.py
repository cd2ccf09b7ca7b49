"""The circle-and-spin experiment on both bases, and its reference trajectory (D24)."""

import dataclasses
import math

import numpy as np
import pytest

from mecanum_base.core.command.circle_spin import PAPER_ERROR, Camera, advance, run
from mecanum_base.core.command.goal import GoalConfig
from mecanum_base.core.command.potential_field import GoalField
from mecanum_base.core.command.trajectory import CircleSpin
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.platform.carriers import Carriers

PATH = CircleSpin()
FIELD = GoalField(GoalConfig(max_speed=0.3, max_yaw_rate=1.0, slow_radius=0.2))
MECANUM = layouts.rectangle(0.2, 0.15, 0.05, roller_count=9, pin_radius=0.038)
PLATFORM = Carriers(('front', 'rear'), [0.3, -0.3], [0.0, 0.0], [-0.1, -0.1], [0.12, 0.12],
                    [0.05, 0.05], ('fl', 'rl'), ('fr', 'rr'))
BASES = {'mecanum': MECANUM, 'platform': PLATFORM}


def test_the_reference_is_a_clockwise_circle_from_its_top_at_constant_speed():
    np.testing.assert_allclose(PATH.pose(0.0), [0.0, 0.25, 0.0], atol=1e-15)
    assert PATH.pose(1.0)[0] > 0.0 and PATH.pose(1.0)[1] < 0.25
    h = 1e-6
    for time in (0.0, 1.3, 7.7):
        slope = (PATH.pose(time + h) - PATH.pose(time - h)) / (2 * h)
        np.testing.assert_allclose(PATH.velocity(time), slope, atol=1e-8)
        twist = PATH.twist(time)
        assert math.hypot(twist[0], twist[1]) == pytest.approx(0.25 * math.pi / 7)
        yaw = PATH.pose(time)[2]
        back = complex(twist[0], twist[1]) * complex(math.cos(yaw), math.sin(yaw))
        assert (back.real, back.imag) == pytest.approx(tuple(slope[:2]), abs=1e-8)


@pytest.mark.parametrize('name', BASES)
def test_the_exact_twist_keeps_the_base_on_the_reference(name):
    base, step = BASES[name], 5e-3
    pose, hinges = PATH.pose(0.0), np.array([-0.1, 0.9]) if name == 'platform' else np.zeros(0)
    for index in range(1400):
        twist = PATH.twist((index + 0.5) * step)
        pose, hinges, _ = advance(base, pose, hinges, twist, step)
    # the twist of the middle of each step is second order; the wheel rates of the platform are
    # held over a step during which its hinges swing, at first by 1 rad/s: first order, once
    np.testing.assert_allclose(pose, PATH.pose(7.0), atol=2e-6 if name == 'mecanum' else 1.5e-3)


@pytest.mark.parametrize('name', BASES)
def test_with_feed_forward_the_error_is_far_below_the_papers(name):
    figures = run(BASES[name], FIELD, PATH, duration=9.0, feed_forward=True,
                  step=0.02, settled=3.0).figures()
    assert figures['paper'] == PAPER_ERROR == 0.04
    assert figures['max'] < 1e-3 and figures['heading_max'] < 1e-3


@pytest.mark.parametrize('name', BASES)
def test_without_feed_forward_the_base_runs_inside_its_circle_as_the_closed_form_says(name):
    result = run(BASES[name], FIELD, PATH, duration=14.0, feed_forward=False, step=0.02,
                 settled=9.0)
    lag = PATH.angular_rate * 0.2 / 0.3
    late = result.time >= 9.0
    radius = np.hypot(*result.pose[late, :2].T)
    want = 0.25 / math.sqrt(1 + lag ** 2)
    assert np.max(np.abs(radius - want)) < 5e-4
    assert result.figures()['mean'] == pytest.approx(want * lag, abs=5e-4)
    assert result.figures()['heading_max'] == pytest.approx(math.asin(PATH.spin), abs=1e-3)


def test_the_camera_of_the_paper_costs_millimetres():
    seen = run(MECANUM, FIELD, PATH, duration=14.0, feed_forward=True, camera=Camera(),
               settled=3.0).figures()
    exact = run(MECANUM, FIELD, PATH, duration=14.0, feed_forward=True, settled=3.0).figures()
    assert exact['max'] + 0.002 < seen['max'] < PAPER_ERROR


def test_a_camera_shows_its_grid_at_its_frames_and_late():
    grid = Camera(pixel=0.01, angle=0.1).quantise(np.array([0.014, -0.026, 0.26]))
    np.testing.assert_allclose(grid, [0.01, -0.03, 0.3])
    np.testing.assert_array_equal(Camera(pixel=0.0, angle=0.0).quantise(np.ones(3) / 3),
                                  np.ones(3) / 3)
    slow = [run(MECANUM, FIELD, PATH, duration=10.0, feed_forward=True, settled=5.0,
                camera=Camera(rate=5.0, pixel=0.0, angle=0.0, delay=delay)).figures()['mean']
            for delay in (0, 2)]
    assert slow[1] > slow[0] + 0.01  # 0.4 s later at 0.11 m/s


def test_the_settings_decide_about_feed_forward_unless_the_call_does():
    field = GoalField(GoalConfig(max_speed=0.3, slow_radius=0.2, feed_forward=True))
    by_setting = run(MECANUM, field, PATH, duration=2.0)
    by_call = run(MECANUM, field, PATH, duration=2.0, feed_forward=True)
    np.testing.assert_array_equal(by_setting.pose, by_call.pose)


def test_wheels_never_exceed_their_limit():
    slow = layouts.rectangle(0.2, 0.15, 0.05)
    slow = dataclasses.replace(slow, max_speed=np.full(4, 1.5))
    result = run(slow, FIELD, PATH, duration=3.0, start=np.array([0.5, 0.5, 1.0]))
    assert np.max(np.abs(result.rates)) <= 1.5 * (1 + 1e-12)


def test_a_perfect_camera_at_every_step_is_no_camera():
    perfect = Camera(rate=100.0, pixel=0.0, angle=0.0, delay=0)
    aside = {'start': np.array([0.1, 0.2, 0.4]), 'duration': 1.0, 'step': 0.01}
    seen = run(MECANUM, FIELD, PATH, camera=perfect, **aside)
    true = run(MECANUM, FIELD, PATH, **aside)
    np.testing.assert_array_equal(seen.pose, true.pose)
