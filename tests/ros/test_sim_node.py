"""The simulated hardware as other nodes see it."""

import math
import time

import numpy as np
import pytest
import yaml

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Float64MultiArray, Int32MultiArray, Int64MultiArray
from std_srvs.srv import Trigger

from mecanum_base.ros.qos import SENSOR
from mecanum_base.ros.scripted import Script, parameter
from mecanum_base.ros.sim_node import SimNode

RADIUS = 0.05  # m, of the robot file


@pytest.fixture
def robot(robot_path):
    """The shipped robot without deviations between file and truth, to be changed by a test."""
    mapping = yaml.safe_load(robot_path.read_text())['/**']['ros__parameters']
    mapping['sim'] = {'radius_error': 0.0, 'common_radius_error': 0.0, 'position_error': 0.0,
                      'roller_error': 0.0}
    return mapping


@pytest.fixture
def script():
    with Script() as made:
        yield made


class Bench:
    """A stepped sim node with somebody who commands its wheels 50 times a second."""

    def __init__(self, script, robot):
        self.script, self.joints = script, robot['wheels']['joint']
        self.node = script.add(SimNode, robot=robot, stepped=False, start_ns=script.now_ns)
        self.truth = script.listen(Odometry, 'ground_truth/odom', SENSOR)
        self.states = script.listen(JointState, 'joint_states', SENSOR)
        self.imu = script.listen(Imu, 'imu/data_raw', SENSOR)
        self.commands = script.publisher(JointState, 'wheel_commands')
        script.before_step(lambda now, following: self.node.step_to(following))
        script.connect()

    def drive(self, seconds, rates=None):
        for _ in range(round(seconds / 0.02)):
            if rates is not None:
                self.commands.publish(JointState(name=self.joints, velocity=list(rates)))
            self.script.advance(0.02)


def statuses(node):
    return {s.name.partition(': ')[2]: s for s in node._diagnostics.publish()}


def test_topics_types_and_qos_are_those_of_the_contract(script, robot):
    node = Bench(script, robot).node
    for topic, kind in {'/joint_states': 'sensor_msgs/msg/JointState',
                        '/wheel_ticks': 'std_msgs/msg/Int64MultiArray',
                        '/imu/data_raw': 'sensor_msgs/msg/Imu',
                        '/ground_truth/odom': 'nav_msgs/msg/Odometry',
                        '/ground_truth/slip': 'sensor_msgs/msg/JointState'}.items():
        info, = node.get_publishers_info_by_topic(topic)
        assert info.topic_type == kind
        assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
        assert info.qos_profile.durability == DurabilityPolicy.VOLATILE
    info, = [i for i in node.get_subscriptions_info_by_topic('/wheel_commands')]
    assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    assert node.count_publishers('/clock') == 0


def test_equal_wheel_rates_drive_forward_and_everything_agrees(script, robot):
    bench = Bench(script, robot)
    bench.drive(2.0, [4.0] * 4)
    last = bench.truth[-1]
    assert last.twist.twist.linear.x == pytest.approx(4.0 * RADIUS, rel=0.03)
    turned = np.array(bench.states[-1].position) - np.array(bench.states[0].position)
    # 9 rollers: rolling radius is the wheel radius when driving straight; creep stays below 3 %
    assert last.pose.pose.position.x == pytest.approx(RADIUS * turned.mean(), rel=0.03)
    assert (last.header.frame_id, last.child_frame_id) == ('map', 'base_link')
    assert bench.imu[-1].header.frame_id == 'imu_link'
    assert bench.imu[0].linear_acceleration.z == pytest.approx(9.81, abs=0.3)
    assert bench.imu[0].orientation_covariance[0] == -1.0


def test_rates_of_the_streams_are_those_of_the_robot_file(script, robot):
    bench = Bench(script, robot)
    bench.drive(1.0)
    assert len(bench.imu) == pytest.approx(200, abs=2)
    assert len(bench.states) == pytest.approx(100, abs=2)


def test_wheels_stop_when_commands_cease(script, robot):
    bench = Bench(script, robot)
    bench.drive(1.0, [4.0] * 4)
    ceased = script.now_ns
    bench.drive(1.0)
    speeds = {m.header.stamp.sec * 10**9 + m.header.stamp.nanosec: abs(m.twist.twist.linear.x)
              for m in bench.truth}
    before = [v for t, v in speeds.items() if ceased < t < ceased + 0.2e9]
    after = [v for t, v in speeds.items() if t > ceased + 0.6e9]
    assert min(before) > 0.15 and max(after) < 0.01  # sim.command_timeout is 0.25 s


def test_a_sign_in_the_robot_file_turns_command_and_encoder_alike(script, robot):
    robot['encoder']['sign'] = [1, -1, 1, -1]
    bench = Bench(script, robot)
    ticks = script.listen(Int64MultiArray, 'wheel_ticks', SENSOR)
    bench.drive(1.0, [4.0, -4.0, 4.0, -4.0])
    assert bench.truth[-1].twist.twist.linear.x == pytest.approx(0.2, rel=0.05)
    for first, last in ((bench.states[0].position, bench.states[-1].position),
                        (ticks[0].data, ticks[-1].data)):
        assert np.sign(np.array(last) - np.array(first)).tolist() == [1, -1, 1, -1]


def test_ticks_and_angles_are_the_same_encoder(script, robot):
    robot['encoder']['ticks_type'] = 'int32'
    bench = Bench(script, robot)
    ticks = script.listen(Int32MultiArray, 'wheel_ticks', SENSOR)
    bench.drive(1.0, [4.0, -2.0, 3.0, 1.0])
    turned = (np.array(ticks[-1].data) - np.array(ticks[0].data)) * 2 * math.pi / 4096.0
    assert np.abs(turned).min() > 0.5
    assert turned == pytest.approx(
        np.array(bench.states[-1].position) - np.array(bench.states[0].position), abs=1e-9)


def test_an_array_of_rates_is_taken_in_the_order_of_the_controller(script, robot):
    joints = robot['wheels']['joint']
    robot['drive'] = {'command_joints': [joints[1], joints[0], joints[3], joints[2]]}
    commands = script.publisher(Float64MultiArray, 'wheel_commands')
    node = script.add(SimNode, robot=robot, stepped=False, start_ns=script.now_ns)
    script.before_step(lambda now, following: node.step_to(following))
    states = script.listen(JointState, 'joint_states', SENSOR)
    script.connect()
    for _ in range(50):
        commands.publish(Float64MultiArray(data=[1.0, 2.0, 3.0, 4.0]))
        script.advance(0.02)
    assert states[-1].velocity == pytest.approx([2.0, 1.0, 4.0, 3.0], abs=0.3)


@pytest.mark.parametrize('spoil,reason', [
    (lambda j: JointState(name=j, velocity=[1.0]), 'array length differs from name'),
    (lambda j: JointState(name=[j[0], j[0]], velocity=[1.0, 2.0]), 'joint named twice'),
    (lambda j: JointState(name=['arm'], velocity=[1.0]), 'names no wheel')])
def test_commands_that_make_no_sense_are_counted_and_not_obeyed(script, robot, spoil, reason):
    bench = Bench(script, robot)
    for _ in range(10):
        bench.commands.publish(spoil(bench.joints))
        script.advance(0.02)
    assert abs(bench.truth[-1].twist.twist.linear.x) < 1e-3
    status = statuses(bench.node)['wheel_commands']
    assert status.values[f'rejected: {reason}'] == 10


def test_commands_that_are_not_numbers_move_nothing(script, robot):
    bench = Bench(script, robot)
    bench.drive(0.5, [math.nan, math.inf, -math.inf, math.nan])
    assert abs(bench.truth[-1].twist.twist.linear.x) < 1e-3


def test_reset_puts_the_robot_back_to_its_start(script, robot):
    bench = Bench(script, robot)
    bench.drive(1.0, [4.0] * 4)
    assert script.call(Trigger, 'sim_node/reset', Trigger.Request()).success
    before = script.now_ns
    bench.drive(0.5)  # the command that was obeyed before is forgotten
    last = bench.truth[-1]
    assert abs(last.pose.pose.position.x) < 1e-3 and abs(last.twist.twist.linear.x) < 1e-3
    assert last.header.stamp.sec * 10**9 + last.header.stamp.nanosec >= before  # time goes on


def test_the_same_seed_gives_the_same_messages(robot):
    def run():
        with Script() as script:
            bench = Bench(script, robot)
            bench.drive(0.5, [4.0, -4.0, 4.0, -4.0])
            return [m.angular_velocity.z for m in bench.imu], [
                list(m.position) for m in bench.states]
    assert run() == run()


def test_it_is_the_clock_where_it_is_told_to_be(script, robot):
    robot['sim']['publish_clock'] = True
    bench = Bench(script, robot)
    clocks = script.listen(Clock, '/clock')
    bench.drive(0.2)
    assert clocks[-1].clock.sec * 10**9 + clocks[-1].clock.nanosec == script.now_ns


def test_it_never_runs_on_simulated_time_itself(script, robot):
    node = script.add(SimNode, robot=robot, parameters={'use_sim_time': True}, stepped=False)
    assert not node.get_clock().ros_time_is_active
    answer, = node.set_parameters([parameter('use_sim_time', True)])
    assert not answer.successful and 'never' in answer.reason


def test_a_fault_can_be_switched_on_and_off_while_it_runs(script, robot):
    bench = Bench(script, robot)
    bench.drive(0.2)
    answer, = bench.node.set_parameters([parameter('sim.fault', 'encoder_dropped')])
    assert answer.successful, answer.reason
    count = len(bench.states)
    bench.drive(0.2)
    assert len(bench.states) <= count + 1  # one was on its way
    bench.node.set_parameters([parameter('sim.fault', 'none')])
    bench.drive(0.2)
    assert len(bench.states) >= count + 18


def test_in_real_time_it_follows_the_time_that_passes(script, robot):
    node = script.add(SimNode, robot=robot, stepped=False)
    imu = script.listen(Imu, 'imu/data_raw', SENSOR)
    begin, start = time.monotonic(), node.simulation.now_ns
    assert abs(time.time_ns() - start) < 60e9
    script.wait_for(lambda: node.simulation.now_ns - start > 0.2e9, 'time to pass', 20.0)
    passed = time.monotonic() - begin
    # never ahead of real time; how far behind depends on the load of this computer
    assert (node.simulation.now_ns - start) * 1e-9 <= passed + 1e-3
    assert imu


def test_a_computer_too_slow_lets_time_pass_and_says_so(script, robot):
    node = script.add(SimNode, robot=robot, stepped=False)
    node._pace._began -= 10.0  # ten seconds behind
    script.wait_for(lambda: node._pace.given_up > 0.0, 'a step', 20.0)
    assert node._pace.given_up == pytest.approx(10.0, abs=1.0)
    assert 'slower than real time' in statuses(node)['simulation'].message


def test_nodes_on_simulated_time_follow_its_clock(script, robot):
    """Ticks have no stamp: the odometry node stamps them with the clock it hears."""
    from mecanum_base.ros.odometry_node import OdometryNode
    robot['sim']['publish_clock'] = True
    robot['encoder']['source'] = 'wheel_ticks'
    odometry = script.add(OdometryNode, robot=robot, stepped=False,
                          parameters={'use_sim_time': True})
    odom = script.listen(Odometry, 'odom')
    bench = Bench(script, robot)
    bench.drive(1.0, [4.0] * 4)
    assert odometry.get_clock().now().nanoseconds == script.now_ns
    last = odom[-1]
    behind = script.now_ns - last.header.stamp.sec * 10**9 - last.header.stamp.nanosec
    assert 0 < behind < 60_000_000  # the reorder wait and a step of the script
    assert last.pose.pose.position.x == pytest.approx(
        bench.truth[-1].pose.pose.position.x, abs=0.03)


def test_its_clock_runs_at_the_rate_it_is_told(script, robot):
    robot['sim'].update(publish_clock=True, rate_factor=0.25)
    node = script.add(SimNode, robot=robot, stepped=False)
    begin, start = time.monotonic(), node.simulation.now_ns
    script.wait_for(lambda: node.simulation.now_ns - start > 0.05e9, 'time to pass', 20.0)
    assert (node.simulation.now_ns - start) * 1e-9 <= 0.25 * (time.monotonic() - begin) + 1e-3
