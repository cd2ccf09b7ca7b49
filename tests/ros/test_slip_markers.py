"""The markers of slip: who slips is red, who rolls is green."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from mecanum_base.core.records import Estimate, SlipEstimate
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.ros.slip_markers import SlipMarkers


class FakePublisher:
    def __init__(self):
        self.sent, self.readers = [], 1

    def get_subscription_count(self):
        return self.readers

    def publish(self, message):
        self.sent.append(message)


class FakeNode:
    def __init__(self):
        self.publisher = FakePublisher()

    def create_publisher(self, kind, topic, qos):
        assert topic == 'slip/markers'
        return self.publisher


def estimate(stamp_ns, x=0.0, rate=(0.0, 0.0, 0.0, 0.0), probability=0.0):
    slip = SlipEstimate(np.array(rate), np.zeros(4), np.full(4, probability), probability,
                        np.ones(5), np.zeros(3), np.eye(3))
    return Estimate(stamp_ns, 'encoder', np.array([x, 0.0, 0.0]), np.eye(3), np.zeros(3),
                    np.eye(3), slip)


def wheel_markers(message):
    return [m for m in message.markers if m.ns == 'wheels']


@pytest.mark.parametrize('name', ['mecanum4.yaml', 'dual_differential.yaml'])
def test_a_slipping_wheel_is_red_and_the_others_green(name):
    node = FakeNode()
    markers = SlipMarkers(node, load_robot(shipped() / name))
    markers.publish(estimate(0, rate=(0.0, 8.0, 0.0, 0.0), probability=1.0))
    wheels = wheel_markers(node.publisher.sent[0])
    assert len(wheels) == 4
    assert wheels[1].color.r > 0.9 and wheels[1].color.g < 0.1
    assert all(w.color.g > 0.7 and w.color.r < 0.3 for w in (wheels[0], wheels[2], wheels[3]))
    for wheel in wheels:  # the axis of the cylinder is the axle: +y here
        q = wheel.pose.orientation
        axis = (2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x))
        assert axis == pytest.approx((0.0, 1.0), abs=1e-9)
        assert math.hypot(q.x, q.y, q.z, q.w) == pytest.approx(1.0)


def test_markers_come_ten_times_a_second_and_only_for_readers():
    node = FakeNode()
    markers = SlipMarkers(node, load_robot(shipped() / 'mecanum4.yaml'))
    for k in range(100):
        markers.publish(estimate(k * 10_000_000, x=0.01 * k))
    assert 9 <= len(node.publisher.sent) <= 11
    path = next(m for m in node.publisher.sent[-1].markers if m.ns == 'path')
    assert 20 <= len(path.points) <= 34  # one every 3 cm of 0.9 m
    node.publisher.readers = 0
    before = len(node.publisher.sent)
    for k in range(100, 200):
        markers.publish(estimate(k * 10_000_000))
    assert len(node.publisher.sent) == before
    node.publisher.readers = 1
    markers.publish(estimate(5_000_000))  # the clock jumped back: shown at once
    assert len(node.publisher.sent) == before + 1
