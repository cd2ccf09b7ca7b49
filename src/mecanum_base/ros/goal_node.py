"""Goal node: drives to goal_pose past obstacles, by a potential field.

Subscribes goal_pose, odom, obstacles, scan (and tf, tf_static); publishes cmd_vel and
/diagnostics; service ~/cancel. Goals and obstacles may be in odom, base_link (fixed where they
were when they came) or any frame that tf connects with these; others are refused by name. While
odom is older than goal.odom_timeout the command is zero; at the goal it is zero once, then silent.
Without simulated time durations come from a clock that nobody can set.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseArray, PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.publisher import Publisher
from rclpy.timer import Timer
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from mecanum_base import messages
from mecanum_base.core.command.potential_field import GoalField
from mecanum_base.core.parameter import FloatArray
from mecanum_base.messages import MalformedMessage
from mecanum_base.robot import Robot
from mecanum_base.ros import process
from mecanum_base.ros.diagnostics import Diagnostics, Source
from mecanum_base.ros.goal_health import goal_statuses
from mecanum_base.ros.pursuit import Pursuit
from mecanum_base.ros.qos import RELIABLE, SENSOR
from mecanum_base.ros.robot_node import RobotNode
from mecanum_base.ros.time_base import TimeBase
from mecanum_base.ros.world_frames import WorldFrames

_NOWHERE = np.zeros((0, 2))


class GoalNode(RobotNode):
    """Pursues one goal at a time. Keyword arguments are those of rclpy's Node."""

    def __init__(self, **options: Any) -> None:
        super().__init__('goal_node', **options)
        robot = self.robot
        self.frames = WorldFrames(self, robot.frames)
        self.pursuit = Pursuit(GoalField(robot.goal))
        self.sources = {topic: Source(topic, topic)
                        for topic in ('odom', 'goal_pose', 'obstacles', 'scan')}
        self.time_base = TimeBase(self)
        self._odom_ns = -1
        self._points = {'obstacles': _NOWHERE, 'scan': _NOWHERE}
        stamped = robot.drive.cmd_vel_type == 'twist_stamped'
        self._commands: Publisher = self.create_publisher(
            TwistStamped if stamped else Twist, 'cmd_vel', RELIABLE)
        self._stamped = stamped
        for message, topic, take, qos in (
                (Odometry, 'odom', self._on_odom, RELIABLE),
                (PoseStamped, 'goal_pose', self._on_goal, RELIABLE),
                (PoseArray, 'obstacles', self._on_obstacles, RELIABLE),
                (LaserScan, 'scan', self._on_scan, SENSOR)):
            self.create_subscription(message, topic, self._counted(topic, take), qos)
        self.create_service(Trigger, '~/cancel', self._on_cancel)
        self._timer = self._start_timer()
        self._diagnostics = Diagnostics(self, lambda: goal_statuses(self))

    @property
    def odom_age(self) -> float:
        """Seconds since odom was heard; infinite before the first."""
        if self._odom_ns < 0:
            return float('inf')
        return abs(self.time_base.now_ns() - self._odom_ns) * 1e-9

    @property
    def obstacles(self) -> FloatArray:
        """All obstacle points (N, 2) in odom."""
        return np.concatenate([self._points['obstacles'], self._points['scan']])

    def configure(self, robot: Robot) -> None:
        """Take over changed settings of the field."""
        self.pursuit.field = GoalField(robot.goal)

    def halt(self, reason: str) -> Sequence[Publisher]:
        """Stop for good if a goal is pursued; returns the publishers that said so."""
        if not self.pursuit.active:
            return ()
        self.pursuit.cancel()
        self.get_logger().info(f'stopped: {reason}')
        self._send(np.zeros(3))
        return (self._commands,)

    def _counted(self, topic: str, take: Callable[[Any], None]) -> Callable[[Any], None]:
        source = self.sources[topic]

        def receive(msg: Any) -> None:
            source.arrived()
            try:
                take(msg)
            except MalformedMessage as error:
                source.reject(str(error))
                self.get_logger().warning(f'{topic} refused: {error}',
                                          throttle_duration_sec=5.0)
        return receive

    def _on_odom(self, msg: Any) -> None:
        self.frames.base = messages.planar_pose(msg.pose.pose)
        if self.time_base.switched():
            self.destroy_timer(self._timer)
            self._timer = self._start_timer()
        self._odom_ns = self.time_base.now_ns()

    def _on_goal(self, msg: Any) -> None:
        frame, goal = messages.frame_of(msg), messages.planar_pose(msg.pose)
        self.pursuit.start(frame, goal, self.frames, self.time_base.now_ns())
        x, y, yaw = goal.tolist()
        self.get_logger().info(f'goal {x:.3f} m, {y:.3f} m, {yaw:.3f} rad in {frame}',
                               throttle_duration_sec=1.0)

    def _on_obstacles(self, msg: Any) -> None:
        self._points['obstacles'] = self.frames.points(messages.frame_of(msg),
                                                       messages.obstacle_points(msg))

    def _on_scan(self, msg: Any) -> None:
        self._points['scan'] = self.frames.points(messages.frame_of(msg),
                                                  messages.scan_points(msg))

    def _on_cancel(self, _request: Any, response: Any) -> Any:
        response.success = self.pursuit.active
        response.message = 'stopped' if response.success else 'no goal was pursued'
        self.halt('cancelled')
        return response

    def _on_timer(self) -> None:
        if not self.pursuit.active:
            return
        fresh = self.odom_age <= self.robot.goal.odom_timeout
        before = self.pursuit.state
        twist = self.pursuit.twist(self.frames, self.obstacles, fresh, self.time_base.now_ns())
        self._send(twist)
        if self.pursuit.state != before:
            self.get_logger().info(self.pursuit.state)

    def _start_timer(self) -> Timer:
        return self.create_timer(1.0 / self.robot.goal.rate, self._on_timer,
                                 clock=self.time_base.clock)

    def _send(self, twist: FloatArray) -> None:
        if self._stamped:
            frames = self.robot.frames
            msg = messages.write_stamped_twist(
                self.get_clock().now().nanoseconds, twist, TwistStamped(),
                frames.tf_frame_prefix + frames.base_frame_id)
        else:
            msg = messages.write_twist(twist, Twist())
        self._commands.publish(msg)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is told to end; the exit code."""
    return process.run(GoalNode, args, commands_wheels=True)


if __name__ == '__main__':
    sys.exit(main())
