"""Nodes in processes of their own: the base moves, stops, and survives the loss of any of them."""

import pathlib
import signal
import time

import pytest

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState

from mecanum_base.ros.qos import SENSOR
from mecanum_base.ros.transforms import Transforms

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
        self.reports = outside.listen(DiagnosticArray, '/diagnostics', 100)
        self.cmd_vel = outside.node.create_publisher(Twist, 'cmd_vel', 10)
        self.processes = {verb: self.start(verb) for verb in ('drive', 'sim', 'odometry')}
        outside.until(lambda: self.cmd_vel.get_subscription_count() and self.odom and self.truth
                      and self.commands, 'drive, sim and odometry')
        self.timer = None

    def start(self, verb, output=None):
        words = ['--output', output] if output else ['--robot', self._robot]
        return self._start('-m', 'mecanum_base', verb, *words)

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

    def until(self, condition, what):
        """Wait for the condition; what the nodes report of themselves is part of the failure."""
        try:
            self.outside.until(condition, what)
        except AssertionError as error:
            last = {s.name: (round(time.monotonic() - at, 1), s.message,
                             [(v.key, v.value) for v in s.values])
                    for at, report in self.reports for s in report.status}
            told = '\n'.join(f'{name}: {report}' for name, report in sorted(last.items()))
            raise AssertionError(f'{error}\n(seconds ago, status)\n{told}') from None

    def true_x(self, at):
        """Where the base truly was at a stamp of ours [ns]."""
        nearest = min((m for _, m in self.truth), key=lambda m: abs(stamp_of(m) - at))
        return nearest.pose.pose.position.x

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
    # 1 % of model error and the slip of starting abruptly
    assert robot.x() == pytest.approx(robot.true_x(stamp_of(robot.odom[-1][1])), abs=0.02)
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


def test_by_the_shipped_profile_nodes_share_no_memory(robot):
    """config/integration/fastdds_udp.xml, by which every test of this folder talks."""
    for process in robot.processes.values():
        maps = pathlib.Path(f'/proc/{process.process.pid}/maps')
        if not maps.exists():
            pytest.skip('needs the maps of a process, as Linux shows them')
        text = maps.read_text()
        assert 'libfastrtps' in text  # the other kinds of DDS read no such profile
        assert '/dev/shm/fastrtps' not in text


def assert_no_transform_twice(transforms):
    stamps = [t.stamp_ns for t in transforms if (t.parent, t.child) == ('odom', 'base_link')]
    assert len(stamps) > 20
    assert all(b > a for a, b in zip(stamps, stamps[1:]))


def wait_for_stop(robot, what):
    """The truth stands for 0.3 s: abrupt braking rocks the base first."""
    robot.until(lambda: all(abs(m.twist.twist.linear.x) < 0.01 for _, m in robot.truth[-30:]),
                what)


def test_each_node_may_be_killed_and_come_back(robot, outside, tmp_path):
    """kill -9 of sim, goal, record, drive and odometry in turn, each in a process of its own."""
    from mecanum_base.cli.main import main

    transforms = []
    Transforms().listen(outside.node, 'tf', 100, transforms.extend)
    goals = outside.node.create_publisher(PoseStamped, 'goal_pose', 10)
    far = PoseStamped()
    far.header.frame_id, far.pose.orientation.w, far.pose.position.x = 'odom', 1.0, 100.0
    robot.processes['goal'] = robot.start('goal')
    bags = iter((tmp_path / 'first', tmp_path / 'second'))
    robot.processes['record'] = robot.start('record', next(bags))
    outside.until(lambda: goals.get_subscription_count() >= 2, 'goal and record')
    first = robot.odom[0][1]

    def go():
        outside.steer = lambda: goals.publish(far)  # again and again, until somebody listens
        robot.until(lambda: robot.speed() > 0.1, 'the base to move')
        outside.steer = None

    # hardware, at rest: odometry falls silent, and goes on at its pose with encoders and IMU
    robot.kill('sim')
    robot.until(lambda: time.monotonic() - robot.odom[-1][0] > 0.5, 'odometry to fall silent')
    count, stood = len(robot.odom), robot.odom[-1][1]
    robot.processes['sim'] = robot.start('sim')
    robot.until(lambda: len(robot.odom) > count + 20, 'odometry of the new hardware')
    again = robot.odom[-1][1]
    assert again.pose.pose.position.x == pytest.approx(stood.pose.pose.position.x, abs=0.1)
    assert again.pose.covariance[0] > 0.9 * stood.pose.covariance[0]  # not started anew
    go()
    # goal: cmd_vel falls silent, drive_node times out; the goal is forgotten
    robot.kill('goal')
    wait_for_stop(robot, 'drive_node to time out')
    assert not any(robot.commands[-1][1].velocity)
    robot.processes['goal'] = robot.start('goal')
    go()
    # record: nobody else minds, and the bag can be completed
    robot.kill('record')
    robot.processes['record'] = robot.start('record', next(bags))
    assert robot.speed() > 0.1
    assert main(['record', '--recover', str(tmp_path / 'first')]) == 0
    # drive: nobody says zero, so the hardware must stop by itself
    robot.until(lambda: robot.speed() > 0.1, 'the base to move')
    robot.kill('drive')
    wait_for_stop(robot, 'the simulated hardware to stop')
    assert any(robot.commands[-1][1].velocity)
    at = robot.x()
    robot.processes['drive'] = robot.start('drive')
    robot.until(lambda: robot.speed() > 0.1, 'the base to move again')
    robot.until(lambda: robot.x() > at + 0.05, 'odometry to go on')
    # odometry: goal_node stops without it; it starts anew at the origin, as at its first start
    robot.kill('odometry')
    wait_for_stop(robot, 'goal_node to stop the base')
    # what was on its way when it died is here by now: the next pose is of the new process
    robot.until(lambda: time.monotonic() - robot.odom[-1][0] > 0.5, 'odometry to fall silent')
    count, before, stands = len(robot.odom), robot.x(), robot.truth[-1][1]
    robot.processes['odometry'] = robot.start('odometry')
    robot.until(lambda: len(robot.odom) > count + 20, 'odometry again')
    begin = robot.odom[count][1]
    # goal_node may hear it, and move the base, before this test does
    moved = robot.true_x(stamp_of(begin)) - stands.pose.pose.position.x
    assert before > 0.1
    assert begin.pose.pose.position.x == pytest.approx(moved, abs=0.05)
    # the start-up covariance, the noise of a few samples, and 2 % of what was driven
    assert begin.pose.covariance[0] < 10.0 * first.pose.covariance[0] + (0.02 * moved)**2
    robot.until(lambda: robot.speed() > 0.1, 'the base to move again')
    stamps = [stamp_of(m) for _, m in robot.odom]
    assert all(b > a for a, b in zip(stamps, stamps[1:]))  # one source, no stamp twice
    assert_no_transform_twice(transforms)
