"""Every robot file of config/integration, driven with the messages and the QoS of the other side.

A stand-in for the hardware follows wheel_commands exactly and answers as the other side would; the
robot drives a little arc, and the odometry has to end where kinematics says.
"""

import math
import pathlib

import numpy as np
import pytest
import yaml
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from rclpy.qos import qos_profile_system_default as system_default
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Float64MultiArray, Int32MultiArray

from mecanum_base import robot_file
from mecanum_base.ros.drive_node import DriveNode
from mecanum_base.ros.odometry_node import OdometryNode
from mecanum_base.ros.scripted import Script

FOLDER = robot_file.shipped() / 'integration'
FILES = sorted(path.name for path in FOLDER.glob('*.yaml'))
STEP = 0.02
BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE_1 = QoSProfile(depth=1)  # rclcpp::QoS(1), what Nav2 and rclc use


class OtherSide:
    """Hardware that does as told: reaches each command within 0.02 s, sends encoders and IMU.

    ``pose`` is where the base really is: the integral of the twist that cmd_vel_limited told.
    """

    def __init__(self, script, path, commands=Float64MultiArray, command_qos=system_default,
                 sensors=JointState, sensor_qos=system_default):
        self.script, self.robot = script, robot_file.load_robot(path)
        self.joints = self.robot.base.joint
        order = self.robot.drive.command_joints or self.joints
        self.pick = [order.index(joint) for joint in self.joints]
        self.angles, self.pose = np.zeros(4), np.zeros(3)
        # wheel rates and twist as one vector: where the ramp starts, where it ends, where it is
        self.start = self.aim = self.now = np.zeros(7)
        self.phase, self.rates = 1.0, np.zeros(4)
        self.sensors = sensors
        topic = 'joint_states' if sensors is JointState else 'wheel_ticks'
        self.encoders = script.publisher(sensors, topic, sensor_qos)
        self.imu = script.publisher(Imu, 'imu/data_raw', sensor_qos)
        script.listen(commands, 'wheel_commands', command_qos, self.obey)
        script.listen(TwistStamped, 'cmd_vel_limited', 10, self.note)

    def obey(self, message):
        if isinstance(message, Float64MultiArray):
            assert len(message.data) == 4  # a group controller refuses any other length
            self.rates = np.array(message.data)[self.pick]
        else:
            self.rates = np.array([dict(zip(message.name, message.velocity))[joint]
                                   for joint in self.joints])

    def note(self, message):
        told = message.twist
        self.start, self.phase = self.now, 0.0
        self.aim = np.array([*self.rates, told.linear.x, told.linear.y, told.angular.z])

    def work(self):
        """One step of hardware, then its messages."""
        before, self.phase = self.now, min(1.0, self.phase + STEP / 0.02)
        self.now = self.start + (self.aim - self.start) * self.phase
        middle = (before + self.now) / 2.0
        self.angles = self.angles + middle[:4] * STEP
        vx, vy, turn = middle[4:]
        yaw = self.pose[2] + turn * STEP / 2.0
        c, s = math.cos(yaw), math.sin(yaw)
        self.pose = self.pose + STEP * np.array([vx * c - vy * s, vx * s + vy * c, turn])
        slope = (self.now - before)[4:] / STEP
        self.send_encoders()
        self.send_imu([slope[0] - turn * vy, slope[1] + turn * vx, 9.81], self.now[6])

    def send_encoders(self):
        if self.sensors is JointState:
            # as joint_state_broadcaster: other joints too, order of its own, effort NaN
            order = np.argsort(self.joints)
            message = JointState(
                name=['arm_joint', *(self.joints[i] for i in order)],
                position=[0.3, *self.angles[order].tolist()],
                velocity=[0.0, *self.now[order].tolist()], effort=[math.nan] * 5)
            self.stamp(message)
        else:
            counts = self.robot.encoder.counts_per_revolution / (2.0 * math.pi)
            message = Int32MultiArray(data=[round(angle * counts) for angle in self.angles])
        self.script.publish(self.encoders, message)

    def send_imu(self, force, turn):
        message = Imu()
        message.header.frame_id = 'imu_link'
        self.stamp(message)
        message.orientation_covariance[0] = -1.0
        message.angular_velocity.z = float(turn)
        axes = message.linear_acceleration
        axes.x, axes.y, axes.z = map(float, force)
        self.script.publish(self.imu, message)

    def stamp(self, message):
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(
            self.script.now_ns, 10**9)


@pytest.fixture
def script():
    with Script() as made:
        yield made


def stage(script, name, **other_side):
    """Our two nodes on one side, the hardware on the other."""
    path = FOLDER / name
    hardware = OtherSide(script, path, **other_side)
    drive = script.add(DriveNode, robot=path)
    script.add(OdometryNode, robot=path)
    return hardware, drive


def ride(script, hardware, send, seconds, every=0.1):
    """Send a command every ``every`` s while the hardware works."""
    for i in range(round(seconds / STEP)):
        if i % round(every / STEP) == 0:
            send()
        script.advance(STEP)
        hardware.work()


def pose(message):
    turn = message.pose.pose.orientation
    return (message.pose.pose.position.x, message.pose.pose.position.y,
            2.0 * math.atan2(turn.z, turn.w))


def twist_message(kind):
    message = kind()
    inner = getattr(message, 'twist', message)
    inner.linear.x, inner.linear.y, inner.angular.z = 0.25, 0.1, 0.3
    return message


def arc_is_followed(script, hardware, commands, odom_qos):
    """Drive an arc and compare the odometry, heard with the QoS of the consumer."""
    odom = script.listen(Odometry, 'odom', odom_qos)
    script.connect()
    ride(script, hardware, lambda: None, 0.5)
    message = twist_message(commands.msg_type)
    ride(script, hardware, lambda: script.publish(commands, message), 1.4)
    ride(script, hardware, lambda: None, 1.0)
    # 1 cm of half a metre: the encoders are quantised, the IMU comes in steps of 0.02 s
    assert pose(odom[-1]) == pytest.approx(hardware.pose, abs=0.01)
    assert math.hypot(*hardware.pose[:2]) > 0.3  # it did drive
    return odom


@pytest.mark.parametrize('name', FILES)
def test_every_example_loads_and_both_nodes_start_with_it(script, name):
    robot = robot_file.load_robot(FOLDER / name, strict=True)
    assert robot.base.count == 4
    assert script.add(DriveNode, robot=FOLDER / name).robot.base.joint == robot.base.joint
    script.add(OdometryNode, robot=FOLDER / name)


def test_ros2_control_group_controller_and_broadcaster(script):
    commands = script.publisher(Twist, 'cmd_vel')
    hardware, drive = stage(script, 'ros2_control.yaml')
    document = yaml.safe_load((FOLDER / 'ros2_control.yaml').read_text())
    controller = document['wheel_velocity_controller']['ros__parameters']['joints']
    assert list(drive.robot.drive.command_joints) == controller
    arc_is_followed(script, hardware, commands, system_default)


@pytest.mark.parametrize('kind', [Twist, TwistStamped])
def test_nav2_in_both_kinds_of_commands_with_stamps_that_stand_still(script, kind):
    commands = script.publisher(kind, 'cmd_vel', RELIABLE_1)  # before: one type a participant
    hardware, _ = stage(script, 'nav2.yaml', commands=JointState, command_qos=10)
    odom = arc_is_followed(script, hardware, commands, system_default)
    assert {m.header.frame_id for m in odom} == {'odom'}
    assert {m.child_frame_id for m in odom} == {'base_link'}
    moving = odom[len(odom) * 6 // 10].twist.twist  # what the OdomSmoother reads
    assert (moving.linear.x, moving.linear.y) == pytest.approx((0.25, 0.1), abs=0.03)


def test_a_collision_monitor_that_falls_silent_lets_the_base_stop_by_itself(script):
    hardware, _ = stage(script, 'nav2.yaml', commands=JointState, command_qos=10)
    commands = script.publisher(Twist, 'cmd_vel', RELIABLE_1)
    script.connect()
    ride(script, hardware, lambda: script.publish(commands, twist_message(Twist)), 1.0)
    assert hardware.rates[1] > 1.0
    ride(script, hardware, lambda: None, 1.0)
    assert not hardware.rates.any()


def test_robot_localization_gets_a_usable_twist_and_no_second_transform(script):
    commands = script.publisher(Twist, 'cmd_vel')
    hardware, drive = stage(script, 'robot_localization.yaml', commands=JointState,
                            command_qos=10)
    odom = arc_is_followed(script, hardware, commands, qos_profile_sensor_data)
    assert not drive.robot.frames.enable_odom_tf
    publishers = drive.get_publishers_info_by_topic('/tf')
    assert publishers == []
    used = [0, 7, 35]  # vx, vy, yaw rate: robot_localization needs finite values above zero
    for message in odom:
        assert all(0.0 < message.twist.covariance[i] < 1.0 for i in used)
        assert np.isfinite(message.twist.covariance).all()
        assert message.twist.covariance[14] == 1e6  # an unused axis, never 0 or infinite


@pytest.mark.parametrize('name', ['micro_ros.yaml', 'linorobot2.yaml'])
def test_firmware_that_counts_ticks_in_int32(script, name):
    commands = script.publisher(Twist, 'cmd_vel')
    hardware, drive = stage(script, name, command_qos=BEST_EFFORT, sensors=Int32MultiArray,
                            sensor_qos=RELIABLE_1)
    odom = arc_is_followed(script, hardware, commands, 10)
    assert odom[-1].child_frame_id == drive.robot.frames.base_frame_id
    if name == 'micro_ros.yaml':  # mirrored motors: forward is a negative count on the right
        assert hardware.angles[0] > 0.0 > hardware.angles[1]


def test_rosbot_xl(script):
    commands = script.publisher(Twist, 'cmd_vel')
    hardware, drive = stage(script, 'rosbot_xl.yaml')
    arc_is_followed(script, hardware, commands, 10)
    # Husarion's own formula with its multipliers: v = vx - vy - (x + y) / 2 w over r
    twist = np.array([0.3, 0.1, 0.5])
    front_left = (0.3 - 0.1 - (0.170 + 0.270) / 2.0 * 0.95 * 0.5) / (0.047 * 1.05)
    assert (drive.driver.geometry.matrix() @ twist)[0] == pytest.approx(front_left, rel=1e-9)


def test_the_limits_of_nav2_are_below_those_of_the_base():
    document = yaml.safe_load((FOLDER / 'nav2.yaml').read_text())
    base = document['/**']['ros__parameters']['drive']['max_velocity']
    smoother = document['velocity_smoother']['ros__parameters']['max_velocity']
    assert all(0.0 < outer <= inner for outer, inner in zip(smoother, base))


def test_every_example_says_how_to_use_it():
    for path in map(pathlib.Path, (FOLDER / name for name in FILES)):
        assert path.read_text().startswith('# '), path
