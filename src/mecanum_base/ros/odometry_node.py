"""Odometry node: wheel angles and IMU in, odometry, transform and slip out.

Subscribes joint_states or wheel_ticks (as encoder.source says), imu/data_raw, set_pose and
wheel_commands (for a note on wheels that do not follow); publishes odom, tf, slip/twist,
slip/wheels, slip/probability, slip/ratio and /diagnostics; offers the service ~/reset, which it
also publishes as odometry_reset, so that a bag can replay it.

All work is done by the estimator behind :class:`mecanum_base.intake.Intake`; `mecanum replay`
uses the same. Time-outs and order depend on the stamps of the data only.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Header, Int32MultiArray, Int64MultiArray
from std_srvs.srv import Trigger

from mecanum_base import messages
from mecanum_base.core.records import Estimate
from mecanum_base.intake import Intake
from mecanum_base.ros import process
from mecanum_base.ros.arrivals import Arrivals
from mecanum_base.ros.diagnostics import Diagnostics, Source
from mecanum_base.ros.followed_topic import FollowedTopic, look_often
from mecanum_base.ros.odometry_commands import OdometryCommands
from mecanum_base.ros.odometry_health import OdometryHealth
from mecanum_base.ros.odometry_topics import OdometryTopics
from mecanum_base.ros.qos import RELIABLE, SENSOR
from mecanum_base.ros.robot_node import RobotNode
from mecanum_base.ros.transforms import Transform, Transforms

TICK_TYPES = {'int64': 'std_msgs/msg/Int64MultiArray', 'int32': 'std_msgs/msg/Int32MultiArray'}
STATIC = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE,
                    durability=DurabilityPolicy.TRANSIENT_LOCAL)


class OdometryNode(RobotNode):
    """Thin: converts, hands on, publishes. Keyword arguments are those of rclpy's Node."""

    def __init__(self, **options: Any) -> None:
        super().__init__('odometry_node', **options)
        robot, transforms = self.robot, Transforms()
        self.intake = Intake(robot)
        self.topics = OdometryTopics(self, robot, transforms)
        self.latest: Estimate | None = None
        self._encoder = Source(robot.encoder.source, robot.encoder.source)
        self._imu = Source('imu', 'imu/data_raw')
        self._ticks: FollowedTopic | None = None
        self._arrivals = Arrivals(self)
        self._subscribe_encoder(robot.encoder.source, robot.encoder.ticks_type)
        self._arrivals.create_subscription(Imu, 'imu/data_raw', self._on_imu, SENSOR)
        self._arrivals.create_subscription(PoseWithCovarianceStamped, 'set_pose',
                                           self._on_set_pose, RELIABLE)
        self.commands = OdometryCommands(self, self.intake, self._arrivals)
        if robot.imu.from_tf:
            transforms.listen(self, 'tf_static', STATIC, self._on_static_transforms)
        self._resets = self.create_publisher(Header, 'odometry_reset', RELIABLE)
        self.create_service(Trigger, '~/reset', self._on_reset)
        self.diagnostics = Diagnostics(self, OdometryHealth(
            self, self._encoder, self._imu, transforms).statuses)
        self.get_logger().info(f'odometry of {robot.base.count} wheels from '
                               f'{robot.encoder.source}; transform {self.topics.tf_way}')

    @property
    def ticks(self) -> FollowedTopic | None:
        """The subscription to wheel_ticks, where that is the encoder source."""
        return self._ticks

    def _subscribe_encoder(self, source: str, ticks_type: str) -> None:
        if source == 'joint_states':
            self._arrivals.create_subscription(JointState, source, self._on_joint_states, SENSOR)
            return
        classes = dict(zip(TICK_TYPES.values(), (Int64MultiArray, Int32MultiArray)))
        wanted = TICK_TYPES.get(ticks_type)
        if wanted is not None:
            classes = {wanted: classes[wanted]}
        self._ticks = FollowedTopic(self, source, classes, self._on_wheel_ticks, lambda _: SENSOR,
                                    default=next(iter(classes)), arrivals=self._arrivals)
        look_often(self, self._ticks.look)

    def _on_joint_states(self, msg: Any, _arrival: int) -> None:
        self._encoder.arrived(self._age(msg.header))
        self._publish(self.intake.joint_states(msg))

    def _on_wheel_ticks(self, msg: Any, arrival: int) -> None:
        self._encoder.arrived()
        if arrival == 0:  # simulated time that has not begun
            self._encoder.reject('no time yet on /clock')
            return
        self._publish(self.intake.wheel_ticks(msg, arrival))

    def _on_imu(self, msg: Any, _arrival: int) -> None:
        self._imu.arrived(self._age(msg.header))
        self._publish(self.intake.imu(msg))

    def _on_set_pose(self, msg: Any, _arrival: int) -> None:
        self._publish(self.intake.set_pose(msg))

    def _on_static_transforms(self, transforms: list[Transform]) -> None:
        for item in transforms:
            known = self.intake.mount_known
            self._publish(self.intake.static_transform(item.parent, item.child, item.xyz,
                                                       item.quaternion))
            if self.intake.mount_known and not known:
                mount = self.intake.robot.imu
                self.get_logger().info(f'IMU mount from tf_static: xyz {mount.xyz.tolist()} m, '
                                       f'rpy {mount.rpy.tolist()} rad')

    def _on_reset(self, _request: Any, response: Any) -> Any:
        """Reset behind everything received so far, and say so on odometry_reset."""
        newest = self.intake.estimator.newest_ns
        stamp = self.get_clock().now().nanoseconds if newest is None else newest
        header = messages.write_reset(stamp, Header(), self.robot.frames.odom_frame_id)
        self._resets.publish(header)
        self._publish(self.intake.odometry_reset(header))
        response.success = True
        response.message = f'pose set to 0, 0, 0 at stamp {stamp * 1e-9:.9f} s'
        return response

    def _publish(self, estimates: Sequence[Estimate]) -> None:
        for estimate in estimates:
            self.topics.publish(estimate)
            self.latest = estimate

    def _age(self, header: Any) -> float:
        """Seconds from the stamp of a message to now."""
        return 1e-9 * (self.get_clock().now().nanoseconds - messages.stamp_ns(header.stamp))


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is told to end; the exit code."""
    return process.run(OdometryNode, args)


if __name__ == '__main__':
    sys.exit(main())
