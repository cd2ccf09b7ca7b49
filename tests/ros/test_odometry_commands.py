"""Wheel commands at the odometry node: a jammed wheel is named, silence is no fault."""

import math

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Twist, Vector3
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from mecanum_base.robot_file import read_parameters, shipped
from mecanum_base.ros.diagnostics import OK, WARN
from mecanum_base.ros.drive_node import DriveNode
from mecanum_base.ros.odometry_node import OdometryNode
from mecanum_base.ros.qos import SENSOR_PUBLISHER
from mecanum_base.ros.scripted import Script, parameter
from mecanum_base.ros.sim_node import SimNode

NOTE = 'wheel {} does not follow its command'
JOINTS = ('front_left_wheel_joint', 'front_right_wheel_joint', 'rear_left_wheel_joint',
          'rear_right_wheel_joint')


@pytest.fixture(autouse=True)
def _checked(monkeypatch):
    monkeypatch.setenv('ROS_PYTHON_CHECK_FIELDS', '1')


def robot_with(drive=(), encoder=()):
    mapping = dict(read_parameters(shipped() / 'mecanum4.yaml'))
    mapping['drive'] = dict(drive)
    mapping['encoder'] = {**mapping['encoder'], **dict(encoder)}
    return mapping


def estimator_of(node):
    return next(s for s in node.diagnostics.publish() if s.name.endswith(': estimator'))


def test_a_wheel_jammed_in_the_simulated_hardware_is_named_while_it_is_jammed():
    """cmd_vel to drive_node to sim_node; wheel 1 is blocked, then free again."""
    robot = robot_with({'command_type': 'float64_multi_array',
                        'command_joints': [JOINTS[i] for i in (3, 1, 0, 2)]},
                       {'source': 'wheel_ticks', 'sign': [1, -1, 1, -1]})
    with Script() as script:
        # the type that comes first is that of the participant: drive_node's publisher
        drive = script.add(DriveNode, robot=robot)
        sim = script.add(SimNode, robot=robot, stepped=False, start_ns=script.now_ns)
        odometry = script.add(OdometryNode, robot=robot)
        script.before_step(lambda now, following: sim.step_to(following))
        steer = script.publisher(Twist, 'cmd_vel')
        script.connect()

        def run(seconds):
            for _ in range(round(seconds / 0.2)):
                script.publish(steer, Twist(linear=Vector3(x=0.4)))
                script.run(0.2, 0.02)
            return estimator_of(odometry)

        status = run(1.0)
        used = int(status.values['used: wheel_commands'])
        assert used > 40 and 'follow' not in status.message
        assert drive is not None and odometry.commands.topic.conflict == ''
        sim.set_parameters([parameter('sim.fault_wheels', [1]), parameter('sim.fault', 'jam')])
        status = run(1.6)
        assert NOTE.format(JOINTS[1]) in status.message and status.level == WARN
        assert status.message.count('follow') == 1  # no other wheel
        sim.set_parameters([parameter('sim.fault', 'none')])
        assert 'follow' not in run(1.2).message


class Standing:
    """One odometry node that hears wheels standing still."""

    def __init__(self, script, robot=None):
        self.script = script
        self.node = script.add(OdometryNode, robot=robot or robot_with())
        self.joints = script.publisher(JointState, 'joint_states', SENSOR_PUBLISHER)

    def run(self, seconds, publisher=None, message=None):
        for k in range(round(seconds / 0.02)):
            self.script.advance(0.02)
            state = JointState(name=list(JOINTS), position=[0.1] * 4)
            self.stamp(state)
            self.joints.publish(state)
            if message is not None:
                publisher.publish(message(k))
            self.script.settle()
        return estimator_of(self.node)

    def stamp(self, msg):
        msg.header.stamp.sec, msg.header.stamp.nanosec = divmod(self.script.now_ns, 10**9)
        return msg


def test_without_commands_nothing_is_warned_of():
    with Script() as script:
        bench = Standing(script)
        script.connect()
        status = bench.run(1.0)
        assert 'command' not in status.message
        assert not [key for key in status.values if 'wheel_commands' in key]
        assert not [s for s in bench.node.diagnostics.publish() if 'command' in s.name]
        info, = [i for i in bench.node.get_subscriptions_info_by_topic('/wheel_commands')
                 if i.node_name == 'odometry_node']
        assert info.topic_type == 'sensor_msgs/msg/JointState'
        assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE  # the contract's rule


def test_bad_commands_are_counted_and_change_no_odometry():
    """Of three commands one is good and ignored by the last wheel: the others have wrong lengths
    or no number."""
    with Script() as script:
        bench = Standing(script)
        commands = script.publisher(JointState, 'wheel_commands', QoSProfile(depth=10))
        script.connect()

        def message(k):
            rates = [[0.0, 0.0, 0.0, 5.0], [1.0] * 3, [math.nan] * 4][k % 3]
            return bench.stamp(JointState(name=list(JOINTS), velocity=rates))

        status = bench.run(1.5, commands, message)
        assert status.values['used: wheel_commands'] == 25
        assert status.values['rejected: wheel_commands: array length differs from name'] == 25
        assert status.values['rejected: wheel_commands: not one number a wheel'] == 25
        assert status.values['received: wheel_commands'] == 75
        assert NOTE.format(JOINTS[3]) in status.message and status.message.count('follow') == 1
        pose = bench.node.latest.pose
        assert abs(pose[0]) + abs(pose[1]) + abs(pose[2]) == pytest.approx(0.0, abs=1e-9)


def test_commands_without_names_follow_the_order_of_the_controller():
    order = [JOINTS[2], *JOINTS[:2], JOINTS[3]]
    with Script() as script:
        bench = Standing(script, robot_with({'command_type': 'float64_multi_array',
                                             'command_joints': order}))
        commands = script.publisher(Float64MultiArray, 'wheel_commands', QoSProfile(depth=10))
        script.connect()
        status = bench.run(1.5, commands,
                           lambda _: Float64MultiArray(data=[6.0, 0.0, 0.0, 0.0]))
        assert NOTE.format(JOINTS[2]) in status.message
        assert status.message.count('follow') == 1 and status.level != OK
        status = bench.run(0.1, commands, lambda _: Float64MultiArray(data=[6.0]))
        assert status.values['rejected: wheel_commands: wheel_commands has 1 entries instead of '
                             '4'] == 5
