"""A bag played at any speed gives the same odometry: time is that of the stamps."""

import time

import pytest
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState

from mecanum_base import messages
from mecanum_base.core.records import ImuSample, WheelSample
from mecanum_base.robot_file import load_robot
from mecanum_base.ros.qos import SENSOR_PUBLISHER
from mecanum_base.sim.simulation import Simulation

START = 1_000_000_000_000
RATES = {'slow': 0.5, 'fast': 4.0}  # as of `ros2 bag play --rate`
AHEAD = 50_000_000  # ns that are played before the odometry of it has come


def recording(robot_path):
    """(stamp [ns], message) of one second that begins at rest."""
    robot = load_robot(robot_path)
    sim = Simulation(robot.base, robot.encoder, robot.imu, robot.sim, start_ns=START)
    found = []
    for step in range(100):
        sim.command([0.0] * 4 if step < 20 else [6.0, 3.0, 5.0, 4.0])
        for reading in sim.advance(START + (step + 1) * 10_000_000):
            if isinstance(reading, WheelSample):
                found.append((reading.stamp_ns, messages.write_wheel_angles(
                    reading, JointState(), robot.base.joint)))
            elif isinstance(reading, ImuSample):
                found.append((reading.stamp_ns, messages.write_imu(reading, Imu(), 'imu_link')))
    return sorted(found, key=lambda item: item[0])


class Player:
    """Plays the recording with /clock into one namespace."""

    def __init__(self, outside, space, rate, found):
        self.rate, self.found, self.next = rate, found, 0
        create = outside.node.create_publisher
        self.clock = create(Clock, f'{space}/clock', 10)
        self.publishers = {JointState: create(JointState, f'{space}/joint_states',
                                              SENSOR_PUBLISHER),
                           Imu: create(Imu, f'{space}/imu/data_raw', SENSOR_PUBLISHER)}
        self.odom = outside.listen(Odometry, f'{space}/odom', SENSOR_PUBLISHER)

    @property
    def ready(self):
        return all(p.get_subscription_count() for p in (self.clock, *self.publishers.values()))

    def play(self, began):
        now = START + round((time.monotonic() - began) * self.rate * 1e9)
        if self.odom:  # a busy computer: queues are short, and what is lost there is no error
            now = min(now, messages.stamp_ns(self.odom[-1][1].header.stamp) + AHEAD)
        else:
            now = min(now, START + 2 * AHEAD)
        self.clock.publish(Clock(clock=messages.write_stamp(now, Clock().clock)))
        while self.next < len(self.found) and self.found[self.next][0] <= now:
            self.publishers[type(self.found[self.next][1])].publish(self.found[self.next][1])
            self.next += 1

    def track(self):
        return {(m.header.stamp.sec, m.header.stamp.nanosec):
                (m.pose.pose.position.x, m.pose.pose.position.y, m.twist.twist.linear.x,
                 m.twist.twist.angular.z, tuple(m.pose.covariance)) for _, m in self.odom}


@pytest.mark.slow
def test_half_and_four_times_the_speed_give_the_same_odometry(outside, start, robot_path):
    found = recording(robot_path)
    players = [Player(outside, space, rate, found) for space, rate in RATES.items()]
    for space in RATES:
        start('-m', 'mecanum_base', 'odometry', '--robot', robot_path, '--ros-args',
              '-p', 'use_sim_time:=true', '-r', f'__ns:=/{space}', '-r', f'/clock:=/{space}/clock')
    outside.until(lambda: all(p.ready for p in players), 'both odometry nodes')
    outside.wait(0.3)
    began = time.monotonic()
    while any(p.next < len(found) for p in players):
        for player in players:
            player.play(began)
        outside.executor.spin_once(timeout_sec=0.001)
    outside.until(lambda: all(len(p.odom) > 85 for p in players), 'odometry')
    outside.wait(0.2)
    slow, fast = (player.track() for player in players)
    shared = slow.keys() & fast.keys()
    assert len(shared) > 80
    assert all(slow[stamp] == fast[stamp] for stamp in shared)  # to the bit
    assert max(pose[0] for pose in slow.values()) > 0.1
