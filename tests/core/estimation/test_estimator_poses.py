"""Poses from outside, resets and restarts."""

import functools
import math

import numpy as np
import pytest
from staged_drive import (
    MS,
    T0,
    estimator,
    frames,
    imu,
    is_sound,
    merged,
    run,
    staged,
    wheel_angles,
)

from mecanum_base.core.records import PoseSample, ResetSample, WheelSample

MOTION = staged((0.6, (0, 0, 0)), (1.4, (0.4, 0.1, 0.6)))
SAMPLES = merged(imu(MOTION), frames(MOTION, wheel_angles(MOTION)))
AT = 1500  # ms, in full drive, between no two samples: on a frame


def turned(pose, yaw):
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * pose[0] - s * pose[1], s * pose[0] + c * pose[1], pose[2]])


@functools.cache
def plain():
    return {e.stamp_ns: e for e in run(estimator(), SAMPLES)}


def at(found, ms):
    return next(e for e in found if e.stamp_ns == T0 + ms * MS)


@pytest.mark.parametrize('late', [0, 15], ids=['in time', '15 ms late'])
def test_a_given_pose_holds_from_its_stamp_on_and_the_way_goes_on_from_there(late):
    given = np.array([3.0, -1.0, 2.0])
    pose = PoseSample(T0 + AT * MS, given, np.diag([0.01, 0.02, 0.03]))
    before = [s for s in SAMPLES if s.stamp_ns < T0 + (AT + late) * MS]
    after = [s for s in SAMPLES if s.stamp_ns >= T0 + (AT + late) * MS]
    subject = estimator()
    found = run(subject, [*before, pose, *after])
    assert at(found, AT - 10).pose.tolist() == plain()[T0 + (AT - 10) * MS].pose.tolist()
    # the frame of the same stamp follows it: at once the pose given, but for that frame's news
    assert at(found, AT).pose == pytest.approx(given, abs=2e-3)
    old, new = plain()[T0 + AT * MS].pose, plain()[T0 + 2000 * MS].pose
    way = turned(new - old, 2.0 - old[2])
    assert found[-1].pose == pytest.approx(given + way, abs=3e-3)
    assert subject.health.used['set_pose'] == 1
    assert all(map(is_sound, found))


def test_a_certain_pose_of_zero_covariance_stays_positive_definite():
    pose = PoseSample(T0 + AT * MS, np.zeros(3), np.zeros((3, 3)))
    found = run(estimator(), sorted([*SAMPLES, pose], key=lambda s: s.stamp_ns))
    assert all(map(is_sound, found))


def test_a_reset_returns_to_the_origin():
    slip = {1: (1.0, 1.3, 8.0)}
    samples = merged(imu(MOTION), frames(MOTION, wheel_angles(MOTION, slip=slip)))
    reset = ResetSample(T0 + AT * MS)
    subject = estimator()
    found = run(subject, sorted([*samples, reset], key=lambda s: s.stamp_ns))
    assert at(found, AT - 10).slip.angle[1] > 1.5
    assert np.abs(found[-1].slip.angle).max() < 0.5
    # the reset comes before the frame of its stamp: one frame of news at most
    assert at(found, AT).pose == pytest.approx(np.zeros(3), abs=2e-3)
    # from then on 0.5 s at (0.4, 0.1) m/s and 0.6 rad/s, by the arc in closed form
    w, t = 0.6, 0.5
    arc = [(math.sin(w * t) * 0.4 - (1 - math.cos(w * t)) * 0.1) / w,
           ((1 - math.cos(w * t)) * 0.4 + math.sin(w * t) * 0.1) / w, w * t]
    assert found[-1].pose == pytest.approx(arc, abs=0.006)
    assert subject.health.used['odometry_reset'] == 1


def test_a_restart_keeps_the_pose_and_learnt_biases_with_start_up_covariance():
    subject = estimator()
    before = run(subject, merged(imu(MOTION, gyro_bias=0.02),
                                 frames(MOTION, wheel_angles(MOTION))))[-1]
    bias = subject.health.gyro_bias
    fresh = estimator().health
    subject.restart()
    health = subject.health
    assert health.restarts == 1
    assert health.gyro_bias == pytest.approx(bias, abs=1e-12)
    assert health.gyro_bias_sigma == pytest.approx(fresh.gyro_bias_sigma)
    # an earlier clock, other counters: the first sample arms, the pose goes on from where it was
    again = run(subject, [WheelSample(k * 10 * MS, np.full(4, 7.0 + 0.1 * k), np.full(4, math.nan))
                          for k in range(30)])
    c, s = math.cos(before.pose[2]), math.sin(before.pose[2])
    way = 0.1 * 29 * 0.05
    # at once from rest to 0.5 m/s: some frames are taken for slip without an IMU to ask
    assert again[-1].pose[:2] == pytest.approx(before.pose[:2] + way * np.array([c, s]), abs=0.02)
    assert all(map(is_sound, again))


def test_two_estimators_share_nothing():
    one, two = estimator(), estimator()
    run(one, SAMPLES[:200])
    assert two.health.received == {}
    found = run(two, SAMPLES[:200])
    assert found[-1].pose.tolist() == run(estimator(), SAMPLES[:200])[-1].pose.tolist()
