"""Sim node: simulated hardware. Wheel commands in; encoders, IMU and the truth out.

Subscribes wheel_commands; publishes joint_states, wheel_ticks, imu/data_raw, ground_truth/odom,
ground_truth/slip, /diagnostics and, with sim.publish_clock, /clock; services ~/reset and ~/fault.
The wheels stop sim.command_timeout after the last wheel_commands, as real hardware must.

It never runs on simulated time itself: time is the real time that passes (times sim.rate_factor
where it is the clock, see :mod:`mecanum_base.ros.sim_pace`), or is moved by hand with
:meth:`SimNode.step`.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

from mecanum_base import messages
from mecanum_base.robot import Robot
from mecanum_base.ros import process
from mecanum_base.ros.diagnostics import OK, WARN, Diagnostics, Source, Status
from mecanum_base.ros.fault_service import FaultService
from mecanum_base.ros.followed_topic import FollowedTopic, look_often
from mecanum_base.ros.qos import RELIABLE
from mecanum_base.ros.robot_node import RobotNode
from mecanum_base.ros.sim_pace import Pace
from mecanum_base.ros.sim_topics import SimTopics
from mecanum_base.sim.scenario_file import load_scenario
from mecanum_base.sim.simulation import Simulation

PERIOD = 0.005  # s of real time between two steps
_NANOSECONDS = 1_000_000_000


class SimNode(RobotNode):
    """Simulated hardware of the robot of its parameters.

    With ``start_ns`` simulated time starts there and moves only by :meth:`step`; without it, it
    follows real time. Further keyword arguments are those of rclpy's Node.
    """

    def __init__(self, *, start_ns: int | None = None, **options: Any) -> None:
        super().__init__('sim_node', **options)
        self._refuse_simulated_time()
        robot = self.robot
        scenario = load_scenario(robot.sim.scenario) if robot.sim.scenario else None
        self.simulation = Simulation(robot.base, robot.encoder, robot.imu, robot.sim, scenario,
                                     time.time_ns() if start_ns is None else start_ns)
        self._reached_ns = self.simulation.now_ns
        self.topics = SimTopics(self, robot)
        self._sign = robot.encoder.for_wheels(robot.base.count)[1]
        self._order = robot.drive.command_joints or robot.base.joint
        self._commands = Source('wheel_commands', 'wheel_commands')
        self._fault = _fault(robot)
        self._pace: Pace | None = None
        self._follow = FollowedTopic(
            self, 'wheel_commands', {'sensor_msgs/msg/JointState': JointState,
                                     'std_msgs/msg/Float64MultiArray': Float64MultiArray},
            self._on_commands, lambda _: RELIABLE, default='sensor_msgs/msg/JointState')
        look_often(self, self._follow.look)
        self.create_service(Trigger, '~/reset', self._on_reset)
        FaultService(self, self.simulation)
        self._diagnostics = Diagnostics(self, self._statuses)
        if start_ns is None:
            self._pace = Pace(robot.sim, self.simulation.now_ns)
            self.create_timer(PERIOD, self._catch_up,
                              clock=Clock(clock_type=ClockType.STEADY_TIME))
        if robot.sim.rate_factor != 1.0 and not robot.sim.publish_clock:
            self.get_logger().warning('sim.rate_factor is ignored without sim.publish_clock')

    def step(self, dt: float) -> None:
        """Advance simulated time by ``dt`` s (rounded to ns) and publish what became due."""
        self.step_to(self._reached_ns + round(dt * _NANOSECONDS))

    def step_to(self, until_ns: int) -> None:
        """Advance simulated time up to ``until_ns`` and publish what became due."""
        self._reached_ns = until_ns
        readings = self.simulation.advance(until_ns)
        self.topics.publish_clock(until_ns)
        for reading in readings:
            self.topics.publish(reading)

    def configure(self, robot: Robot) -> None:
        """Take over a changed fault on demand."""
        if _fault(robot) != self._fault:
            self._fault = _fault(robot)
            self.simulation.set_fault(*self._fault)

    def _catch_up(self) -> None:
        """Follow real time, in strides of the clock."""
        assert self._pace is not None
        for until_ns in self._pace.strides(self.simulation.now_ns):
            self.step_to(until_ns)

    def _on_commands(self, msg: Any) -> None:
        self._commands.arrived()
        joints = self.robot.base.joint
        try:
            if self._follow.type.endswith('JointState'):
                sample = messages.command_sample(msg, joints)
                rates = None if sample is None else sample.rate
            else:
                rates = messages.rates_of_array(msg, self._order, joints)
        except messages.MalformedMessage as error:
            self._commands.reject(str(error))
            return
        if rates is None:
            self._commands.reject('names no wheel')
            return
        if self._pace is not None:
            self._catch_up()
            self._pace.commanded(self.simulation.now_ns)
        self.simulation.command(rates * self._sign)

    def _on_reset(self, _request: Any, response: Any) -> Any:
        self.simulation.reset()
        response.success, response.message = True, 'the robot stands at its start again'
        return response

    def _statuses(self) -> list[Status]:
        commands = self._commands.report(
            needed=False, silent='no wheel_commands: the wheels stand still')
        given_up = 0.0 if self._pace is None else self._pace.given_up
        values: dict[str, object] = {
            'simulated time [s]': f'{1e-9 * self.simulation.now_ns:.3f}',
            'fault': self._fault[0], **self.topics.count,
            'time given up [s]': f'{given_up:.3f}'}
        slow = 'slower than real time: this computer cannot keep up'
        return [commands, Status('simulation', WARN if given_up else OK,
                                 slow if given_up else 'running', values)]

    def _refuse_simulated_time(self) -> None:
        if self.get_parameter('use_sim_time').value:
            self.get_logger().warning('use_sim_time is ignored: the simulated hardware is never '
                                      'on simulated time itself')
            self.set_parameters([Parameter('use_sim_time', value=False)])
        self.add_on_set_parameters_callback(_keep_real_time)


def _keep_real_time(changes: list[Parameter]) -> SetParametersResult:
    refused = any(change.name == 'use_sim_time' and change.value for change in changes)
    return SetParametersResult(
        successful=not refused, reason='sim_node never runs on simulated time' if refused else '')


def _fault(robot: Robot) -> tuple[str, tuple[int, ...], float | None]:
    sim = robot.sim
    return sim.fault, tuple(int(wheel) for wheel in sim.fault_wheels), sim.fault_value or None


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is told to end; the exit code."""
    return process.run(SimNode, args)


if __name__ == '__main__':
    sys.exit(main())
