"""Drive node: commands of the base in, wheel speeds out, zeros whenever something is wrong.

subscribes  cmd_vel          geometry_msgs/Twist or TwistStamped   wanted twist
            joint_states     sensor_msgs/JointState                hinge angles, carriers only
publishes   wheel_commands   sensor_msgs/JointState or std_msgs/Float64MultiArray, at drive.rate
            cmd_vel_limited  geometry_msgs/TwistStamped            what the wheels are told
            /diagnostics     diagnostic_msgs/DiagnosticArray
service     ~/enable         std_srvs/SetBool                      false: zeros at once

Parameters: all blocks of the robot file; block `drive` holds those of this node, its limits and
time-outs may be changed while it runs. A refused change of a parameter stops the wheels; the next
command moves them again. The wheels also stop when cmd_vel is silent for drive.command_timeout
(decelerating), and at once when the node is disabled, ends for whatever reason, when the clock
jumps or a simulated clock stands still for drive.clock_timeout. Without simulated time a clock is
used that nobody can set, so a step of the system's clock changes nothing.
"""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import TwistStamped
from rclpy.publisher import Publisher
from rclpy.timer import Timer
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool

from mecanum_base import messages
from mecanum_base.core.command.driver import Driver, Told
from mecanum_base.core.command.geometry import geometry_of
from mecanum_base.core.command.stopping import DRIVING, IDLE
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.robot import Robot
from mecanum_base.ros.command_topic import CommandTopic
from mecanum_base.ros.diagnostics import Diagnostics, Source
from mecanum_base.ros.drive_report import drive_statuses
from mecanum_base.ros.process import run
from mecanum_base.ros.qos import RELIABLE, SENSOR
from mecanum_base.ros.robot_node import RobotNode
from mecanum_base.ros.time_base import TimeBase
from mecanum_base.ros.wheel_commands import WheelCommands, send_last_zeros

WATCH_PERIOD = 0.1  # s of real time between two looks at the graph and at the clock


class DriveNode(RobotNode):
    """Turns cmd_vel into wheel_commands; see the text of this module."""

    def __init__(self, **options: Any) -> None:
        try:
            super().__init__('drive_node', **options)
        except ConfigError:
            send_last_zeros(self)
            raise
        self.driver = Driver(geometry_of(self.robot.base), self.robot.drive)
        self.told: Told | None = None
        self.time_base = TimeBase(self)
        self.clock_stopped = False
        self._wheels = WheelCommands(self, self.robot)
        self._limited = self.create_publisher(TwistStamped, 'cmd_vel_limited', RELIABLE)
        self.command = CommandTopic(self, self.robot.drive, self._on_command, self.halt)
        self.source = Source('cmd_vel', self.command.name)
        base = self.robot.base
        self._hinge_joint = base.hinge_joint if isinstance(base, Carriers) else ()
        if any(self._hinge_joint):
            self.create_subscription(JointState, 'joint_states', self._on_hinges, SENSOR)
        self.create_service(SetBool, '~/enable', self._on_enable)
        self._timer = self._start_timer()
        self.create_timer(WATCH_PERIOD, self._watch, clock=self.time_base.steady)
        self._diagnostics = Diagnostics(self, lambda: drive_statuses(self))

    def halt(self, reason: str) -> tuple[Publisher, ...]:
        """Zeros at once; returns the publishers whose acknowledgement is worth waiting for."""
        self._send(self.driver.stop(reason))
        return (self._wheels.publisher,)

    def configure(self, robot: Robot) -> None:
        """Take over changed limits, times and rate."""
        self.driver.configure(robot.drive)
        if self._timer.timer_period_ns != _period_ns(robot):
            self._restart_timer()

    def refuse(self, reason: str) -> None:
        """A change that breaks a rule stops the wheels: somebody expects another behaviour."""
        super().refuse(reason)
        self.halt(f'parameter change refused: {reason}')

    def _on_command(self, msg: Any) -> None:
        self.source.arrived(self._latency(msg))
        self.driver.stopping.accept(*messages.command_twist(msg), self.time_base.now_ns())
        self._log_transitions()

    def _latency(self, msg: Any) -> float | None:
        """Seconds from the stamp of a stamped command to now; None without a stamp."""
        header = getattr(msg, 'header', None)
        stamp = 0 if header is None else messages.stamp_ns(header.stamp)
        return (self.get_clock().now().nanoseconds - stamp) * 1e-9 if stamp else None

    def _on_hinges(self, msg: JointState) -> None:
        try:
            sample = messages.wheel_sample(msg, self._hinge_joint)
        except messages.MalformedMessage as error:
            self.source.reject(f'joint_states: {error}')
            return
        if sample is not None:
            self.driver.geometry.measure(sample.position)

    def _on_enable(self, request: SetBool.Request, response: SetBool.Response
                   ) -> SetBool.Response:
        told = self.driver.enable(request.data, f'~/enable called with {request.data}')
        if told is not None:
            self._send(told)
        response.success = True
        response.message = f'{self.driver.stopping.mode}: {self.driver.stopping.reason}'
        return response

    def _tick(self) -> None:
        self.command.take_waiting()  # a busy computer: commands may wait behind this timer
        self._send(self.driver.step(self.time_base.now_ns()))

    def _watch(self) -> None:
        """What must be seen even while a simulated clock stands still."""
        self.command.look()
        if self.time_base.switched():
            self.halt('use_sim_time was changed')
            self._restart_timer()
        limit = self.robot.drive.clock_timeout
        still = self.time_base.stood_still()
        stopped, before = bool(limit) and still > limit, self.clock_stopped
        self.clock_stopped = stopped
        if stopped and not before and not self.driver.stopping.at_once:
            self.halt(f'the simulated clock has stood still for {still:.1f} s')

    def _send(self, told: Told) -> None:
        self.told = told
        stamp, frames = self.get_clock().now().nanoseconds, self.robot.frames
        self._wheels.send(stamp, told.rates)
        self._limited.publish(messages.write_stamped_twist(
            stamp, told.twist, TwistStamped(), frames.tf_frame_prefix + frames.base_frame_id))
        self._log_transitions()

    def _log_transitions(self) -> None:
        for change in self.driver.stopping.take_transitions():
            text = f'{change.before} -> {change.mode}: {change.reason}'
            if change.mode in (DRIVING, IDLE):
                self.get_logger().info(text)
            else:  # rclpy allows one severity per line of code
                self.get_logger().warning(text)

    def _start_timer(self) -> Timer:
        return self.create_timer(_period_ns(self.robot) * 1e-9, self._tick,
                                 clock=self.time_base.clock)

    def _restart_timer(self) -> None:
        self.destroy_timer(self._timer)
        self._timer = self._start_timer()


def _period_ns(robot: Robot) -> int:
    return round(1e9 / robot.drive.rate)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; returns the exit code."""
    return run(DriveNode, args, commands_wheels=True)
