"""The publishers of the simulated hardware: one reading in, one message out."""

from __future__ import annotations

from typing import Any

from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Int32MultiArray, Int64MultiArray

from mecanum_base import messages
from mecanum_base.core.records import ImuSample, TickSample, WheelSample
from mecanum_base.robot import Robot
from mecanum_base.ros.qos import RELIABLE, SENSOR_PUBLISHER
from mecanum_base.sim.records import Reading, Truth

WORLD_FRAME = 'map'  # the frame of the truth


class SimTopics:
    """Publishes readings on joint_states, wheel_ticks, imu/data_raw and ground_truth/*."""

    def __init__(self, node: Any, robot: Robot) -> None:
        frames = robot.frames
        prefix = frames.tf_frame_prefix
        self._joints = robot.base.joint
        self._base_frame, self._imu_frame = prefix + frames.base_frame_id, prefix + (
            frames.imu_frame_id)
        ticks = Int32MultiArray if robot.encoder.ticks_type == 'int32' else Int64MultiArray
        self._angles = node.create_publisher(JointState, 'joint_states', SENSOR_PUBLISHER)
        self._ticks = node.create_publisher(ticks, 'wheel_ticks', SENSOR_PUBLISHER)
        self._imu = node.create_publisher(Imu, 'imu/data_raw', SENSOR_PUBLISHER)
        self._truth = node.create_publisher(Odometry, 'ground_truth/odom', SENSOR_PUBLISHER)
        self._slip = node.create_publisher(JointState, 'ground_truth/slip', SENSOR_PUBLISHER)
        self._clock = (node.create_publisher(Clock, '/clock', RELIABLE)
                       if robot.sim.publish_clock else None)
        self._filled = JointState(), ticks(), Imu(), Odometry(), JointState()
        self.count: dict[str, int] = {}

    def publish(self, reading: Reading) -> None:
        """Publish one reading on the topic it belongs to."""
        angles, ticks, imu, truth, slip = self._filled
        kind = type(reading).__name__
        self.count[kind] = self.count.get(kind, 0) + 1
        if isinstance(reading, WheelSample):
            self._angles.publish(messages.write_wheel_angles(reading, angles, self._joints))
        elif isinstance(reading, TickSample):
            self._ticks.publish(messages.write_ticks(reading, ticks))
        elif isinstance(reading, ImuSample):
            self._imu.publish(messages.write_imu(reading, imu, self._imu_frame))
        elif isinstance(reading, Truth):
            self._truth.publish(messages.write_truth(reading, truth, WORLD_FRAME,
                                                     self._base_frame))
            self._slip.publish(messages.write_slip_wheels(
                reading.stamp_ns, reading.slip_rate, reading.slip_angle, slip, self._joints))

    def publish_clock(self, now_ns: int) -> None:
        """Publish simulated time, where this node is the clock."""
        if self._clock is not None:
            msg = Clock()
            messages.write_stamp(now_ns, msg.clock)
            self._clock.publish(msg)
