"""Nodes in processes of their own: the base moves, stops, and survives the loss of any of them."""

import signal

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState

from mecanum_base.ros.qos import SENSOR

pytestmark = pytest.mark.slow
PUBLISH_PERIOD = 0.1  # s: cmd_vel at 10 Hz
SPEED = 0.2  # m/s


def stamp_of(msg):
    return msg.header.stamp.sec * 10**9 + msg.header.stamp.nanosec


class Robot:
    """drive, sim and odometry as the commands a user types."""

    def __init__(self, outside, start, robot_path):
        self.outside, self._start, self._robot = outside, start, robot_path
        self.commands = outside.listen(JointState, 'wheel_commands')
        self.odom = outside.listen(Odometry, 'odom')
        self.truth = outside.listen(Odometry, 'ground_truth/odom', SENSOR)
        self.cmd_vel = outside.node.create_publisher(Twist, 'cmd_vel', 10)
        self.processes = {verb: self.start(verb) for verb in ('drive', 'sim', 'odometry')}
        outside.until(lambda: self.cmd_vel.get_subscription_count() and self.odom and self.truth
                      and self.commands, 'drive, sim and odometry')
        self.timer = None

    def start(self, verb):
        return self._start('-m', 'mecanum_base', verb, '--robot', self._robot)

    def kill(self, verb):
        self.processes[verb].send(signal.SIGKILL)
        assert self.processes[verb].finish() == -signal.SIGKILL

    def steer(self, speed=SPEED):
        """Publish at 10 Hz, as a plain rclpy program does."""
        twist = Twist()
        twist.linear.x = speed
        self.timer = self.outside.node.create_timer(
            PUBLISH_PERIOD, lambda: self.cmd_vel.publish(twist))

    def release(self):
        self.outside.node.destroy_timer(self.timer)

    def x(self):
        return self.odom[-1][1].pose.pose.position.x

    def speed(self):
        return self.truth[-1][1].twist.twist.linear.x


@pytest.fixture
def robot(outside, start, robot_path):
    return Robot(outside, start, robot_path)


def test_a_plain_publisher_moves_odom_and_sigint_ends_each_process_with_zeros(robot, outside):
    robot.steer()
    outside.until(lambda: robot.x() > 0.15 and robot.speed() > 0.9 * SPEED, 'odom to move')
    at = stamp_of(robot.odom[-1][1])
    truth = min((m for _, m in robot.truth), key=lambda m: abs(stamp_of(m) - at))
    # 1 % of model error and the slip of starting abruptly
    assert robot.x() == pytest.approx(truth.pose.pose.position.x, abs=0.02)
    robot.release()  # a silent commander is a stop though all processes live
    outside.until(lambda: abs(robot.speed()) < 0.01, 'the base to stand')
    assert not any(p.ended for p in robot.processes.values())
    robot.steer()
    outside.until(lambda: robot.speed() > 0.9 * SPEED, 'the base to move again')
    robot.processes['drive'].send(signal.SIGINT)
    assert robot.processes['drive'].finish() == 0
    outside.until(lambda: not any(robot.commands[-1][1].velocity), 'zeros', 5.0)
    outside.until(lambda: abs(robot.speed()) < 0.01, 'the base to stand')
    for verb in ('odometry', 'sim'):
        robot.processes[verb].send(signal.SIGINT)
    for verb in ('odometry', 'sim'):
        assert robot.processes[verb].finish() == 0, robot.processes[verb].output
        assert 'Traceback' not in robot.processes[verb].output
    assert not any(robot.commands[-1][1].velocity)


def test_each_node_may_be_killed_and_come_back(robot, outside):
    robot.steer()
    outside.until(lambda: robot.speed() > 0.9 * SPEED, 'the base to move')
    # drive: nobody says zero, so the hardware must stop by itself
    robot.kill('drive')
    last = robot.commands[-1][1]
    assert any(last.velocity)
    outside.until(lambda: abs(robot.speed()) < 0.01, 'the simulated hardware to stop')
    assert robot.commands[-1][1] == last
    at = robot.x()
    robot.processes['drive'] = robot.start('drive')
    outside.until(lambda: robot.speed() > 0.9 * SPEED, 'the base to move again')
    outside.until(lambda: robot.x() > at + 0.05, 'odometry to go on')
    # odometry: starts anew at the origin, and nothing else publishes in between
    robot.kill('odometry')
    count, before = len(robot.odom), robot.x()
    robot.processes['odometry'] = robot.start('odometry')
    outside.until(lambda: len(robot.odom) > count + 20, 'odometry again')
    begin = robot.odom[count + 1][1]
    assert abs(begin.pose.pose.position.x) < 0.05 < before
    stamps = [stamp_of(m) for _, m in robot.odom[count:]]
    assert all(b > a for a, b in zip(stamps[1:], stamps[2:]))  # one source, no stamp twice
    # hardware: odometry falls silent, and goes on when encoders and IMU are back
    robot.kill('sim')
    robot.processes['sim'] = robot.start('sim')
    count = len(robot.odom)
    outside.until(lambda: len(robot.odom) > count + 20, 'odometry of the new hardware')
    assert all(abs(m.pose.pose.position.x) < 5.0 for _, m in robot.odom)
