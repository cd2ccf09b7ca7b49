"""Every stopping rule of the contract, seen from another process by a plain rclpy subscriber.

The drive node runs in its own process; the node in this process steers it with Twist messages and
watches wheel_commands. 'At once' is proven by the values: a zero that follows a full speed without
a ramp in between, while commands keep arriving.
"""

import signal
import time

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool

from mecanum_base import robot_file

SPEED = 0.4  # m/s = 8 rad/s
JOINTS = ['front_left_wheel_joint', 'front_right_wheel_joint', 'rear_left_wheel_joint',
          'rear_right_wheel_joint']


class Watcher:
    """Steers with Twist at 20 Hz and keeps the wheel rates that were heard."""

    def __init__(self, outside, message=Twist):
        self.outside = outside
        self.heard = outside.listen(JointState, 'wheel_commands')
        self.steer_as(message)

    def steer_as(self, message):
        self.publisher = self.outside.node.create_publisher(message, 'cmd_vel', 10)
        self.message = message()
        getattr(self.message, 'twist', self.message).linear.x = SPEED

    def stop_steering(self):
        self.outside.steer = None

    def drive(self):
        """Steer until all wheels run at full speed."""
        self.outside.steer = self.steer
        self.outside.until(lambda: self.heard and min(self.rates(-1)) > 7.9999, 'full speed')

    def steer(self):
        """Send the command once."""
        self.steered = time.time()
        self.publisher.publish(self.message)

    def sent(self, index):
        """Stamp of a message [s], of the clock that :func:`time.time` shows."""
        stamp = self.heard[index][1].header.stamp
        return stamp.sec + stamp.nanosec * 1e-9

    def rates(self, index):
        return list(self.heard[index][1].velocity)

    def stands(self):
        return bool(self.heard) and self.rates(-1) == [0.0] * 4

    def until_standing(self, what):
        self.outside.until(self.stands, what)

    def last_step(self, begin=0):
        """Speeds of the first wheel before and at the first zero after index ``begin``."""
        speeds = [self.rates(i)[0] for i in range(begin, len(self.heard))]
        first = next(i for i in range(1, len(speeds)) if speeds[i] == 0.0 and speeds[i - 1] != 0.0)
        return speeds[first - 1], speeds[first]


def test_time_out_disable_and_refused_parameter_stop_the_wheels(outside, start, robot_path):
    process = start('-m', 'mecanum_base', 'drive', '--robot', robot_path)
    watcher = Watcher(outside)
    outside.until(lambda: len(watcher.heard) > 5, 'wheel commands while idle')
    assert all(watcher.rates(i) == [0.0] * 4 for i in range(len(watcher.heard)))
    assert list(watcher.heard[0][1].name) == JOINTS

    # time-out: full speed for a while after the last command, then a ramp, then zeros
    watcher.drive()
    watcher.stop_steering()
    begin = len(watcher.heard) - 1
    watcher.until_standing('standstill after silence')
    speeds = np.array([watcher.rates(i)[0] for i in range(begin, len(watcher.heard))])
    times = np.array([watcher.sent(i) for i in range(begin, len(watcher.heard))])
    assert (np.diff(speeds) <= 1e-12).all()
    silence = times[speeds < 7.9] - watcher.steered
    assert 0.45 < silence[0] and silence[-1] < 5.0  # the time-out of 0.5 s, not a stop at once
    # a ramp: as much in each gap as the limit allows, in whole periods of 0.02 s; a busy machine
    # makes gaps longer, a step to zero would come from full speed within one
    robot = robot_file.load_robot(robot_path)
    steepest = robot.drive.max_deceleration[0] / robot.base.radius[0]
    assert (-np.diff(speeds) <= steepest * (np.diff(times) + 0.04)).all()

    # disable: zeros at once although commands keep coming; enable: a new command drives again
    watcher.drive()
    begin = len(watcher.heard) - 1
    answer = outside.call(SetBool, 'drive_node/enable', SetBool.Request(data=False))
    assert answer.success and 'disabled' in answer.message
    watcher.until_standing('zeros after disable')
    assert watcher.last_step(begin)[0] > 7.9
    count = len(watcher.heard)
    outside.until(lambda: len(watcher.heard) > count + 15, 'more wheel commands')
    assert all(watcher.rates(i) == [0.0] * 4 for i in range(count, len(watcher.heard)))
    outside.call(SetBool, 'drive_node/enable', SetBool.Request(data=True))
    watcher.drive()

    # a refused parameter: zeros at once, then commands drive again
    begin = len(watcher.heard) - 1
    value = ParameterValue(type=8, double_array_value=[-1.0, 1.0, 1.0])
    answer = outside.call(SetParameters, 'drive_node/set_parameters', SetParameters.Request(
        parameters=[Parameter(name='drive.max_velocity', value=value)]))
    assert not answer.results[0].successful
    assert 'drive.max_velocity[0] = -1.0: must be > 0' in answer.results[0].reason
    outside.until(lambda: any(watcher.rates(i) == [0.0] * 4
                              for i in range(begin, len(watcher.heard))), 'zeros')
    assert watcher.last_step(begin)[0] > 7.9
    watcher.drive()
    assert not process.ended


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_sends_zeros_at_once_and_ends_with_code_0(outside, start, robot_path, number):
    process = start('-m', 'mecanum_base', 'drive', '--robot', robot_path)
    watcher = Watcher(outside)
    watcher.drive()
    begin = len(watcher.heard) - 1
    process.send(number)
    outside.until(lambda: process.ended, 'end of the process')
    outside.wait(0.1)
    assert watcher.stands() and watcher.last_step(begin)[0] > 7.9
    assert process.finish() == 0
    assert f'received {number.name}' in process.output and 'Traceback' not in process.output


FAILING = """
import sys
from mecanum_base.ros import drive_node, process
class Failing(drive_node.DriveNode):
    def _on_command(self, msg):
        super()._on_command(msg)
        if self.source.received > 20:
            raise ValueError('broken on purpose')
sys.exit(process.run(Failing, sys.argv[1:], commands_wheels=True))
"""


def test_an_exception_in_a_callback_sends_zeros_and_ends_with_code_1(outside, start, robot_path):
    process = start('-c', FAILING, '--ros-args', '--params-file', robot_path)
    watcher = Watcher(outside)
    watcher.drive()
    outside.until(lambda: process.ended, 'end of the process')
    outside.wait(0.1)
    assert watcher.stands() and watcher.last_step()[0] > 7.9
    assert process.finish() == 1
    assert 'Traceback' in process.output and 'broken on purpose' in process.output


def test_an_invalid_parameter_at_the_start_sends_zeros_only_and_ends_with_code_2(
        outside, start, robot_path):
    watcher = Watcher(outside)
    outside.steer = watcher.steer
    process = start('-m', 'mecanum_base', 'drive', '--robot', robot_path, '--ros-args', '-p',
                    'drive.max_jerk:=[0.0, 1.0, 1.0]')
    outside.until(lambda: process.ended, 'end of the process')
    outside.wait(0.1)
    assert process.finish() == 2
    assert process.output.strip().splitlines()[-1] == (
        'drive_node: drive.max_jerk[0] = 0.0: must be > 0 [m/s^3, m/s^3, rad/s^3]')
    assert watcher.heard and all(watcher.rates(i) == [0.0] * 4 for i in range(len(watcher.heard)))


def test_the_command_type_follows_the_publishers_and_a_conflict_is_named(
        outside, start, robot_path):
    start('-m', 'mecanum_base', 'drive', '--robot', robot_path)
    watcher = Watcher(outside)
    watcher.drive()
    # the publisher changes over to TwistStamped: zeros first, then it is followed
    begin = len(watcher.heard) - 1
    watcher.stop_steering()
    outside.node.destroy_publisher(watcher.publisher)
    watcher.steer_as(TwistStamped)
    outside.steer = watcher.steer
    outside.until(lambda: any(watcher.rates(i) == [0.0] * 4
                              for i in range(begin, len(watcher.heard))), 'zeros at the change')
    watcher.drive()

    # a second participant sends the other type: named in diagnostics, the first stays
    other = type(outside)(outside.domain)  # one participant has one type per topic
    try:
        reports = outside.listen(DiagnosticArray, '/diagnostics')
        publisher = other.node.create_publisher(Twist, 'cmd_vel', 10)
        publisher.publish(Twist())

        def conflict():
            return [s for _, m in reports for s in m.status
                    if s.name == 'drive_node: cmd_vel' and s.level == DiagnosticStatus.ERROR]

        outside.until(conflict, 'the conflict in /diagnostics')
        assert 'geometry_msgs/msg/Twist on /cmd_vel is ignored' in conflict()[0].message
        assert min(watcher.rates(-1)) > 7.9
    finally:
        other.close()
