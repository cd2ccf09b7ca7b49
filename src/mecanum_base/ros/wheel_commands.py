"""Publishes wheel rates in the message type and the wheel order that the hardware reads."""

from __future__ import annotations

import time

import numpy as np
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from mecanum_base import messages
from mecanum_base.core.parameter import FloatArray
from mecanum_base.robot import Robot
from mecanum_base.ros.qos import RELIABLE

TOPIC = 'wheel_commands'
FIRST_SUBSCRIBER_WITHIN = 0.5  # s; discovery of a new publisher takes that long
OTHERS_WITHIN = 0.1  # s; the first one may be a mere listener (odometry, recorder), not the motors


class WheelCommands:
    """Topic ``wheel_commands``: sensor_msgs/JointState by name or std_msgs/Float64MultiArray.

    ``robot.encoder.sign`` is applied here, the last moment before the hardware.
    """

    def __init__(self, node: Node, robot: Robot) -> None:
        joints = robot.base.joint
        self._order = robot.drive.order_of(joints)
        self._joints = [joints[i] for i in self._order]
        self._sign = robot.encoder.for_wheels(robot.base.count)[1]
        self._as_array = robot.drive.command_type == 'float64_multi_array'
        self.publisher: Publisher = node.create_publisher(
            Float64MultiArray if self._as_array else JointState, TOPIC, RELIABLE)

    def send(self, stamp_ns: int, rates: FloatArray) -> None:
        """Publish ``rates`` (W,) rad/s, order and positive sense of the wheel table."""
        ordered = (rates * self._sign)[self._order] + 0.0  # no -0.0
        if self._as_array:
            message = messages.write_rate_array(ordered, Float64MultiArray())
        else:
            message = messages.write_wheel_rates(stamp_ns, ordered, JointState(), self._joints)
        self.publisher.publish(message)


def send_last_zeros(node: Node) -> None:
    """Zeros for a robot whose parameters break a rule, as far as its joints can be read.

    Sent by a drive node that is about to give up: the robot may still follow the commands of its
    killed predecessor. Waits a moment for the hardware to be discovered.
    """
    given = {name: item.value for name, item in node._parameter_overrides.items()}
    joints = [name for key in ('wheels.joint', 'carriers.left_joint', 'carriers.right_joint')
              for name in _texts(given.get(key))]
    if not joints:
        return
    as_array = given.get('drive.command_type') == 'float64_multi_array'
    publisher = node.create_publisher(Float64MultiArray if as_array else JointState, TOPIC,
                                      RELIABLE)
    end = time.monotonic() + FIRST_SUBSCRIBER_WITHIN
    while publisher.get_subscription_count() == 0:
        if time.monotonic() > end:
            return
        time.sleep(0.01)
    time.sleep(OTHERS_WITHIN)
    zeros, now = np.zeros(len(joints)), node.get_clock().now().nanoseconds
    publisher.publish(messages.write_rate_array(zeros, Float64MultiArray()) if as_array else
                      messages.write_wheel_rates(now, zeros, JointState(), joints))
    publisher.wait_for_all_acked(Duration(seconds=FIRST_SUBSCRIBER_WITHIN))


def _texts(value: object) -> list[str]:
    items = value if isinstance(value, (list, tuple)) else []
    return [item for item in items if isinstance(item, str)]
