"""From the recorded bag of a demo to its result: everything shown comes out of topics."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np

from mecanum_base import messages
from mecanum_base.bag.decode import message
from mecanum_base.bag.reader import Bag
from mecanum_base.core.estimation.odometry import WheelOdometry
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.demo.comparison import Track, slip_score
from mecanum_base.demo.result import DemoResult, Phase, SlipHistory, WheelHistory
from mecanum_base.robot import Robot

TOPICS = ('joint_states', 'wheel_commands', 'odom', 'ground_truth/odom', 'ground_truth/slip',
          'slip/wheels', 'slip/probability')


def read_result(bag: pathlib.Path, robot: Robot, name: str,
                phases: tuple[Phase, ...]) -> DemoResult:
    """Read the bag of one demo run. Raises BagError where it cannot be read."""
    heard = _messages(bag)
    joints = robot.base.joint
    wheel_only, wheels = _wheels(heard, robot)
    fused, truth = _track(heard['odom'], True), _track(heard['ground_truth/odom'], False)
    slip = _slip(heard, robot)
    score = slip_score(slip.true_speed, slip.true_stamp, slip.body_probability, slip.stamp)
    return DemoResult(name, joints, truth, fused, wheel_only, wheels, slip, score, phases)


def _messages(bag: pathlib.Path) -> dict[str, list[Any]]:
    heard: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
    with Bag(str(bag)) as recording:
        for block in recording.blocks(lambda channel: channel.topic.lstrip('/') in heard):
            for index, number in enumerate(block.channel.tolist()):
                channel = block.channels[number]
                heard[channel.topic.lstrip('/')].append(
                    message(block.payload(index), channel.type))
    return heard


def _track(odometry: list[Any], with_covariance: bool) -> Track:
    stamps = np.array([messages.stamp_ns(m.header.stamp) for m in odometry], dtype=np.int64)
    pose = np.array([[m.pose.pose.position.x, m.pose.pose.position.y,
                      messages.yaw_of(m.pose.pose.orientation)] for m in odometry]).reshape(-1, 3)
    if not with_covariance:
        return Track(stamps, pose)
    grid = np.array([np.asarray(m.pose.covariance) for m in odometry]).reshape(-1, 6, 6)
    return Track(stamps, pose, grid[:, [0, 1, 5]][:, :, [0, 1, 5]])


def _wheels(heard: dict[str, list[Any]], robot: Robot) -> tuple[Track, WheelHistory]:
    odometry = WheelOdometry(robot.base, robot.encoder)
    joints = robot.base.joint
    stamps, poses, rates = [], [], []
    for msg in heard['joint_states']:
        sample = messages.wheel_sample(msg, joints)
        if sample is None:
            continue
        stamps.append(sample.stamp_ns)
        poses.append(odometry.handle(sample).copy())
        rates.append(sample.velocity)
    commands = [messages.command_sample(msg, joints) for msg in heard['wheel_commands']]
    told = [c for c in commands if c is not None]
    track = Track(np.array(stamps, dtype=np.int64), np.array(poses).reshape(-1, 3))
    return track, WheelHistory(
        np.array([c.stamp_ns for c in told], dtype=np.int64),
        np.array([c.rate for c in told]).reshape(-1, len(joints)),
        np.array(stamps, dtype=np.int64), np.array(rates).reshape(-1, len(joints)))


def _slip(heard: dict[str, list[Any]], robot: Robot) -> SlipHistory:
    """slip/probability has no stamp: it follows slip/wheels message by message."""
    count = robot.base.count
    lever = _speed_per_rate(robot)
    pairs = list(zip(heard['slip/wheels'], heard['slip/probability']))
    stamp = np.array([messages.stamp_ns(w.header.stamp) for w, _ in pairs], dtype=np.int64)
    rate = np.array([np.asarray(w.velocity) for w, _ in pairs]).reshape(-1, count)
    probability = np.array([np.asarray(p.data) for _, p in pairs]).reshape(-1, count + 1)
    true = heard['ground_truth/slip']
    true_stamp = np.array([messages.stamp_ns(m.header.stamp) for m in true], dtype=np.int64)
    true_rate = np.array([np.asarray(m.velocity) for m in true]).reshape(-1, count)
    return SlipHistory(stamp, rate * lever, probability[:, :count], probability[:, count],
                       true_stamp, true_rate * lever)


def _speed_per_rate(robot: Robot) -> FloatArray:
    """Slip speed along the roller axis [m/s] for a slip rate of 1 rad/s, (W,)."""
    base = robot.base
    if isinstance(base, Wheels):
        lever: FloatArray = base.radius * np.abs(np.sin(base.roller))
        return lever
    return np.repeat(base.wheel_radius, 2)
