"""Intervals of the calibration: the statistics on made-up numbers, windows and their clusters.

The campaigns are tests/bag/calibration_coverage.py and tests/bag/physics_coverage.py.
"""

import driving
import numpy as np
import pytest

from mecanum_base.bag.analysis.agreement import yaw_agreement
from mecanum_base.bag.analysis.calibration_windows import windows_of
from mecanum_base.bag.analysis.clusters import clusters
from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.bag.analysis.robust_fit import robust_fit
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.robot import Robot
from mecanum_base.robot_file import parse_parameters

MATRIX = wheels_from_body(Robot.from_mapping(parse_parameters(driving.YAML, 'test')).base)
UP = np.array([0.0, 0.0, 1.0])


def trial(draw, groups, kind):
    """Whether the interval of the first of two values covers it; errors in clusters of 8."""
    count = 8 * groups
    cluster = np.repeat(np.arange(groups), 8)
    busy = np.ones(groups) if kind == 'alike' else np.where(draw.random(groups) < 0.5, 1.0, 0.05)
    x = draw.normal(size=count) * np.repeat(busy, 8)
    z = draw.normal(size=count)
    error = 0.01 * draw.normal(size=count)
    if kind == 'with the motion':
        error = 0.2 * error + 0.02 * x * np.repeat(draw.normal(size=count // 2), 2)
    elif kind == 'dependent':
        error += 0.01 * np.sign(x) * np.repeat(draw.normal(size=groups), 8)
    fit = robust_fit(np.column_stack([x, z]), 1.03 * x + 0.1 * z + error, cluster,
                     np.array([1.0, 0.0]), np.array([np.inf, 0.2]))
    return abs(fit.value[0] - 1.03) <= fit.half_width(0)


@pytest.mark.parametrize('kind', ['alike', 'few busy ones', 'with the motion', 'dependent'])
def test_ninety_percent_intervals_cover_ninety_percent(kind):
    """150 draws: 2.4 % sigma; three of them."""
    draw = np.random.default_rng(3)
    share = np.mean([trial(draw, 20, kind) for _ in range(150)])
    assert 0.82 <= share <= 0.98


def test_errors_that_repeat_within_a_cluster_widen_the_interval():
    draw = np.random.default_rng(1)
    x, cluster = np.ones((160, 1)), np.repeat(np.arange(20), 8)
    alone = robust_fit(x, draw.normal(size=160), cluster).half_width(0)
    together = robust_fit(x, np.repeat(draw.normal(size=20), 8), cluster).half_width(0)
    assert together > 2.0 * alone  # sqrt(8) in theory


def test_a_prior_counts_as_knowledge_of_its_spread():
    """Without any excitation the interval is that of the prior: 1.645 standard deviations."""
    draw = np.random.default_rng(2)
    x = np.column_stack([draw.normal(size=800), 1e-9 * draw.normal(size=800)])
    fit = robust_fit(x, x[:, 0] + 0.01 * draw.normal(size=800), np.arange(800) // 8,
                     np.array([1.0, 0.5]), np.array([np.inf, 0.05]))
    assert fit.value[1] == pytest.approx(0.5, abs=1e-4)
    assert fit.sigma[1] == pytest.approx(0.05, rel=0.01)


def test_clusters_are_cut_where_the_base_rests():
    t = np.arange(0.0, 60.0, 0.1)
    speed = np.abs(np.sin(np.pi * t / 3.0))  # still each 3 s
    number = clusters(speed, 0.1)
    cuts = t[1:][np.diff(number) > 0]
    assert 12 <= len(cuts) <= 15
    assert np.abs((cuts + 1.5) % 3.0 - 1.5).max() < 0.11
    assert np.diff(cuts).max() < 7.5


def still_wheels(pose, t):
    """WheelMotion of ideal wheels on a track of poses (N, 3): body steps at the middle heading."""
    step = np.diff(pose, axis=0)
    middle = pose[:-1, 2] + step[:, 2] / 2.0
    c, s = np.cos(middle), np.sin(middle)
    body = np.column_stack([c * step[:, 0] + s * step[:, 1], c * step[:, 1] - s * step[:, 0],
                            step[:, 2]])
    angle = np.vstack([np.zeros(4), np.cumsum(body @ MATRIX.T, axis=0)])
    return WheelMotion(driving.JOINTS, driving.T0 + np.round(t * 1e9).astype(np.int64), angle)


@pytest.mark.parametrize('path', ['straight in the world', 'arc'])
def test_windows_of_a_base_that_turns_while_it_goes_match_its_wheels(path):
    """0.6 rad in a window: a chord for an arc, or the other way round, would be 3 % wrong."""
    t = np.arange(0.0, 20.0, 0.002)
    yaw = 1.2 * t
    pose = np.column_stack([0.5 * t, 0.2 * t, yaw])
    if path == 'arc':
        pose[:, 0], pose[:, 1] = np.sin(yaw) / 2.4, (1.0 - np.cos(yaw)) / 2.4
    motion = still_wheels(pose, t)
    truth = Track(motion.stamp_ns[::10], pose[::10])  # 50 Hz
    windows = windows_of(motion, truth, None, UP)
    wheels = windows.wheel @ body_from_wheels(MATRIX).T
    np.testing.assert_allclose(windows.moved, wheels, atol=2e-4)  # of 0.27 m


def test_slip_does_not_pull_the_time_offset():
    misses = []
    for seed in range(4):
        made = driving.drive(seed=seed, seconds=60.0, slip=0.15, imu_late=0.04)
        found = yaw_agreement(WheelMotion(driving.JOINTS, made.wheel_ns, made.angle),
                              Gyro(made.imu_ns, made.gyro, made.accel))
        misses.append(abs(found.offset - 0.04))
        assert misses[-1] < 2.0 * found.offset_half
    assert np.mean(misses) < 0.001  # 2 ms and more without the weights
