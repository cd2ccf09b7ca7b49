"""Simulated time follows real time, waits for commands where it is the clock, and never stalls."""

import signal

import pytest
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from mecanum_base.ros.qos import SENSOR
from mecanum_base.ros.sim_pace import STRIDE_NS, Pace
from mecanum_base.sim.config import SimConfig

MS = 1_000_000


class Wall:
    """Real time moved by hand."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def paced(**settings):
    wall = Wall()
    return wall, Pace(SimConfig(**settings), 0, wall)


@pytest.mark.parametrize('factor', [0.25, 1.0, 4.0])
def test_time_passes_at_the_rate_factor(factor):
    wall, pace = paced(publish_clock=True, rate_factor=factor)
    wall.now += 0.1
    assert pace.target(0) == pytest.approx(100 * MS * factor)


def test_the_rate_factor_is_for_the_clock_only():
    wall, pace = paced(rate_factor=4.0)
    wall.now += 0.1
    assert pace.target(0) == pytest.approx(100 * MS)


def test_the_clock_moves_in_strides():
    wall, pace = paced(publish_clock=True, rate_factor=4.0)
    wall.now += 0.2
    times = [0, *pace.strides(0)]
    assert times[-1] == 800 * MS
    assert max(b - a for a, b in zip(times, times[1:])) == STRIDE_NS


def test_time_waits_for_the_next_wheel_command_and_then_catches_up():
    wall, pace = paced(publish_clock=True, rate_factor=4.0, command_timeout=0.25)
    pace.commanded(0)
    wall.now += 0.2  # 0.8 s of simulated time, but drive_node has not been served
    assert pace.target(0) == 125 * MS
    pace.commanded(125 * MS)
    assert pace.target(125 * MS) == 250 * MS
    assert pace.given_up == 0.0


def test_time_goes_on_without_commands_once_they_have_been_silent_in_real_time_too():
    wall, pace = paced(publish_clock=True, rate_factor=4.0, command_timeout=0.25)
    pace.commanded(0)
    wall.now += 0.2
    assert pace.target(0) == 125 * MS
    wall.now += 0.06
    assert pace.target(125 * MS) > 1000 * MS


def test_real_time_waits_for_nobody():
    wall, pace = paced(command_timeout=0.25)
    pace.commanded(0)
    wall.now += 0.2
    assert pace.target(0) == pytest.approx(200 * MS)


def test_what_a_slow_computer_cannot_do_is_given_up_and_counted():
    wall, pace = paced(publish_clock=True, rate_factor=2.0)
    wall.now += 10.0
    assert pace.target(0) == pytest.approx(500 * MS)  # 0.25 s of real time
    assert pace.given_up == pytest.approx(19.5)
    wall.now += 0.1
    assert pace.target(500 * MS) == pytest.approx(700 * MS)


@pytest.mark.slow
def test_four_times_real_time_with_a_starved_drive_node_does_not_stop_the_wheels(
        outside, start, robot_path):
    """drive_node gets no processor for 0.25 s, which is 1 s of simulated time."""
    truth = outside.listen(Odometry, 'ground_truth/odom', SENSOR)
    wheels = outside.listen(JointState, 'wheel_commands')
    clock = outside.listen(Clock, '/clock', SENSOR)
    steer = outside.node.create_publisher(Twist, 'cmd_vel', 10)
    outside.steer = lambda: steer.publish(Twist(linear=Vector3(x=0.2)))
    start('-m', 'mecanum_base', 'sim', '--robot', robot_path, '--ros-args',
          '-p', 'sim.publish_clock:=true', '-p', 'sim.rate_factor:=4.0',
          '-p', 'sim.command_timeout:=0.6')
    drive = start('-m', 'mecanum_base', 'drive', '--robot', robot_path, '--ros-args',
                  '-p', 'use_sim_time:=true', '-p', 'drive.command_timeout:=4.0')
    outside.until(lambda: truth and truth[-1][1].twist.twist.linear.x > 0.19, 'the base to move')
    first = len(truth), len(wheels), len(clock)
    for _ in range(2):
        drive.pause(0.25)
        outside.wait(0.5)
    assert min(m.twist.twist.linear.x for _, m in truth[first[0]:]) > 0.18
    assert min(min(m.velocity) for _, m in wheels[first[1]:]) > 3.5  # rad/s; 0.2 m/s is 4.0
    times = [m.clock.sec + 1e-9 * m.clock.nanosec for _, m in clock[first[2]:]]
    assert times == sorted(times) and times[-1] - times[0] > 1.0
    drive.send(signal.SIGKILL)  # but a dead one does
    outside.until(lambda: abs(truth[-1][1].twist.twist.linear.x) < 0.01, 'the base to stand')
