"""The odometry node as other nodes see it: topics, frames, stamps, resets, rejections."""

import math
import pathlib

import numpy as np
import pytest
import yaml

pytest.importorskip('rclpy')

from geometry_msgs.msg import (
    PoseWithCovarianceStamped,
    TransformStamped,
    TwistWithCovarianceStamped,
)
from nav_msgs.msg import Odometry
from rclpy.qos import (
    DurabilityPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import (
    Float64MultiArray,
    Header,
    Int32MultiArray,
    Int64MultiArray,
)
from std_srvs.srv import Trigger

from mecanum_base.ros.diagnostics import ERROR, OK, STALE, WARN
from mecanum_base.ros.odometry_node import OdometryNode
from mecanum_base.ros.qos import SENSOR_PUBLISHER
from mecanum_base.ros.scripted import Script
from mecanum_base.ros.transforms import Transforms

ROBOT = pathlib.Path(__file__).parents[2] / 'config' / 'mecanum4.yaml'
JOINTS = ('front_left_wheel_joint', 'front_right_wheel_joint', 'rear_left_wheel_joint',
          'rear_right_wheel_joint')
RADIUS = 0.05  # m, of the robot file
LATCHED = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)
STEP = 0.01  # s between encoder samples


@pytest.fixture(autouse=True)
def _checked(monkeypatch):
    monkeypatch.setenv('ROS_PYTHON_CHECK_FIELDS', '1')


def robot_with(**changes):
    """The shipped robot with changed keys: encoder__source='wheel_ticks'."""
    mapping = yaml.safe_load(ROBOT.read_text())['/**']['ros__parameters']
    for name, value in changes.items():
        block, _, key = name.partition('__')
        if key:
            mapping.setdefault(block, {})[key] = value
        else:
            mapping[block] = value
    return mapping


class Bench:
    """One odometry node, fed with the sensors of a base that drives forward.

    Speed changes at 2 m/s^2 and the accelerometer feels it: an IMU that contradicts the wheels
    would be slip.
    """

    def __init__(self, script, robot=None, imu=True, **options):
        self.script = script
        self.node = script.add(OdometryNode, robot=robot or robot_with(), **options)
        namespace = options.get('namespace', '')
        self.joints = script.publisher(JointState, f'{namespace}/joint_states', SENSOR_PUBLISHER)
        self.imus = script.publisher(Imu, f'{namespace}/imu/data_raw', SENSOR_PUBLISHER)
        self.odom = script.listen(Odometry, f'{namespace}/odom', QoSProfile(depth=100))
        self.with_imu = imu
        self.travel = self.speed = self.push = 0.0
        script.connect()

    def joint_state(self, angle=None, names=JOINTS):
        msg = JointState(name=list(names))
        self.stamp(msg.header)
        value = self.travel / RADIUS if angle is None else angle
        msg.position = [value] * len(names)
        return msg

    def imu(self, shift_ns=0):
        msg = Imu()
        self.stamp(msg.header, shift_ns)
        msg.header.frame_id = 'imu_link'
        msg.linear_acceleration.x, msg.linear_acceleration.z = self.push, 9.81
        msg.orientation_covariance[0] = -1.0
        return msg

    def stamp(self, header, shift_ns=0):
        seconds, nanoseconds = divmod(self.script.now_ns + shift_ns, 10**9)
        header.stamp.sec, header.stamp.nanosec = seconds, nanoseconds

    def drive(self, seconds, speed=0.0, encoder=True):
        for _ in range(round(seconds / STEP)):
            change = min(max(speed - self.speed, -2.0 * STEP), 2.0 * STEP)
            self.push = change / STEP
            self.travel += (self.speed + 0.5 * change) * STEP
            self.speed += change
            self.script.advance(STEP)
            if self.with_imu:  # twice as fast as the encoders
                self.imus.publish(self.imu(shift_ns=-5_000_000))
                self.imus.publish(self.imu())
            if encoder:
                self.joints.publish(self.joint_state() if encoder is True else encoder(self))
        self.script.settle()

    def statuses(self):
        return {s.name.partition(': ')[2]: s for s in self.node.diagnostics.publish()}


@pytest.fixture
def script():
    with Script() as made:
        yield made


def stamp_of(msg):
    return msg.header.stamp.sec * 10**9 + msg.header.stamp.nanosec


def test_topics_types_and_qos_are_those_of_the_contract(script):
    node = Bench(script).node
    published = {
        '/odom': 'nav_msgs/msg/Odometry', '/tf': 'tf2_msgs/msg/TFMessage',
        '/slip/twist': 'geometry_msgs/msg/TwistWithCovarianceStamped',
        '/slip/wheels': 'sensor_msgs/msg/JointState',
        '/slip/probability': 'std_msgs/msg/Float64MultiArray',
        '/slip/ratio': 'std_msgs/msg/Float64MultiArray',
        '/odometry_reset': 'std_msgs/msg/Header',
        '/diagnostics': 'diagnostic_msgs/msg/DiagnosticArray'}
    for topic, kind in published.items():
        info, = [i for i in node.get_publishers_info_by_topic(topic)
                 if i.node_name == 'odometry_node']
        assert info.topic_type == kind
        assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
        assert info.qos_profile.durability == DurabilityPolicy.VOLATILE
    for topic, kind, reliability in (
            ('/joint_states', 'sensor_msgs/msg/JointState', ReliabilityPolicy.BEST_EFFORT),
            ('/imu/data_raw', 'sensor_msgs/msg/Imu', ReliabilityPolicy.BEST_EFFORT),
            ('/set_pose', 'geometry_msgs/msg/PoseWithCovarianceStamped',
             ReliabilityPolicy.RELIABLE)):
        info, = [i for i in node.get_subscriptions_info_by_topic(topic)
                 if i.node_name == 'odometry_node']
        assert info.topic_type == kind and info.qos_profile.reliability == reliability
    assert '/odometry_node/reset' in dict(node.get_service_names_and_types())


def test_driving_forward_moves_odom_forward(script):
    bench = Bench(script)
    bench.drive(1.0)
    bench.drive(1.0, speed=0.25)
    last = bench.odom[-1]
    # less what still waits for late samples: 30 ms at 0.25 m/s is 8 mm
    assert bench.travel == pytest.approx(0.234, abs=0.001)
    assert last.pose.pose.position.x == pytest.approx(bench.travel - 0.0075, abs=0.005)
    assert last.pose.pose.position.y == pytest.approx(0.0, abs=0.005)
    assert last.twist.twist.linear.x == pytest.approx(0.25, abs=0.02)
    assert (last.header.frame_id, last.child_frame_id) == ('odom', 'base_link')


def test_every_topic_carries_the_stamp_of_the_encoder_sample(script):
    bench = Bench(script)
    twist = script.listen(TwistWithCovarianceStamped, 'slip/twist')
    wheels = script.listen(JointState, 'slip/wheels')
    transforms = []
    Transforms().listen(script._bench, 'tf', SENSOR_PUBLISHER, transforms.extend)
    script.connect()
    sent = []
    script.listen(JointState, 'joint_states', SENSOR_PUBLISHER, lambda m: sent.append(stamp_of(m)))
    bench.drive(0.5, speed=0.1)
    stamps = [stamp_of(m) for m in bench.odom]
    assert stamps and set(stamps) <= set(sent)
    assert [stamp_of(m) for m in twist] == stamps == [stamp_of(m) for m in wheels]
    assert [t.stamp_ns for t in transforms] == stamps
    assert twist[-1].header.frame_id == 'base_link' and wheels[-1].name == list(JOINTS)


def test_the_transform_is_the_pose_of_odom(script):
    bench = Bench(script)
    transforms = []
    Transforms().listen(script._bench, 'tf', SENSOR_PUBLISHER, transforms.extend)
    bench.drive(0.5, speed=0.3)
    for msg, transform in zip(bench.odom, transforms, strict=True):
        pose = msg.pose.pose
        assert (transform.parent, transform.child) == ('odom', 'base_link')
        assert transform.xyz == (pose.position.x, pose.position.y, 0.0)
        turn = pose.orientation
        assert transform.quaternion == (turn.x, turn.y, turn.z, turn.w)


def test_slip_arrays_hold_the_wheels_and_then_the_body(script):
    bench = Bench(script)
    probability = script.listen(Float64MultiArray, 'slip/probability')
    ratio = script.listen(Float64MultiArray, 'slip/ratio')
    bench.drive(0.5)
    assert all(len(m.data) == 5 and all(0.0 <= p <= 1.0 for p in m.data) for m in probability)
    assert probability[-1].layout.dim[0].size == 5
    assert all(math.isnan(v) for v in ratio[-1].data)  # nothing has moved: undefined


def test_unused_axes_have_large_and_used_axes_small_finite_covariance(script):
    bench = Bench(script)
    bench.drive(0.5, speed=0.1)
    for part in (bench.odom[-1].pose, bench.odom[-1].twist):
        grid = np.array(part.covariance).reshape(6, 6)
        assert np.all(np.isfinite(grid)) and np.array_equal(grid, grid.T)
        assert [grid[i, i] for i in (2, 3, 4)] == [1e6] * 3
        assert all(0.0 < grid[i, i] < 1.0 for i in (0, 1, 5))


def test_reset_returns_to_the_origin_and_says_so_for_a_bag(script):
    bench = Bench(script)
    headers = script.listen(Header, 'odometry_reset')
    bench.drive(1.0, speed=0.3)
    assert bench.odom[-1].pose.pose.position.x > 0.2
    answer = script.call(Trigger, 'odometry_node/reset', Trigger.Request())
    assert answer.success
    at = headers[-1].stamp.sec * 10**9 + headers[-1].stamp.nanosec
    bench.drive(0.1)
    before = [m for m in bench.odom if stamp_of(m) < at]
    after = [m for m in bench.odom if stamp_of(m) >= at]
    assert before[-1].pose.pose.position.x > 0.2
    assert abs(after[0].pose.pose.position.x) < 0.01  # one step at 0.3 m/s is 3 mm


def pose_message(bench, x, frame='odom', stamped=True):
    msg = PoseWithCovarianceStamped()
    msg.header.frame_id = frame
    if stamped:
        bench.stamp(msg.header)
    msg.pose.pose.position.x = x
    msg.pose.pose.orientation.w = 1.0
    msg.pose.covariance = (np.eye(6) * 0.01).ravel()
    return msg


@pytest.mark.parametrize('stamped', [True, False])
def test_set_pose_moves_the_estimate(script, stamped):
    bench = Bench(script)
    poses = script.publisher(PoseWithCovarianceStamped, 'set_pose')
    script.connect()
    bench.drive(0.5)
    script.publish(poses, pose_message(bench, 7.0, stamped=stamped))
    bench.drive(0.2)
    assert bench.odom[-1].pose.pose.position.x == pytest.approx(7.0, abs=1e-3)
    assert bench.odom[-1].pose.covariance[0] == pytest.approx(0.01, rel=0.1)


def test_a_pose_in_another_frame_is_refused_by_name(script):
    bench = Bench(script)
    poses = script.publisher(PoseWithCovarianceStamped, 'set_pose')
    script.connect()
    bench.drive(0.3)
    script.publish(poses, pose_message(bench, 7.0, frame='map'))
    bench.drive(0.2)
    assert abs(bench.odom[-1].pose.pose.position.x) < 1e-3
    assert any("'map'" in key for key in bench.statuses()['estimator'].values)


def test_a_pose_from_a_clock_ahead_does_not_make_the_sensors_late(script):
    bench = Bench(script)
    poses = script.publisher(PoseWithCovarianceStamped, 'set_pose')
    script.connect()
    bench.drive(0.3)
    msg = pose_message(bench, 7.0)
    bench.stamp(msg.header, shift_ns=300_000_000)
    script.publish(poses, msg)
    bench.drive(0.2)
    assert abs(bench.odom[-1].pose.pose.position.x) < 1e-3
    bench.drive(0.2)
    assert bench.odom[-1].pose.pose.position.x == pytest.approx(7.0, abs=1e-3)
    assert not any('late' in key for key in bench.statuses()['estimator'].values)


def nan_position(bench):
    msg = bench.joint_state()
    msg.position[1] = math.nan
    return msg


def named_twice(bench):
    return bench.joint_state(names=(*JOINTS, JOINTS[0]))


def too_short(bench):
    msg = bench.joint_state()
    msg.position = msg.position[:3]
    return msg


def empty(bench):
    msg = bench.joint_state()
    msg.position = []
    return msg


@pytest.mark.parametrize('spoil,reason', [
    (named_twice, 'joint named twice'), (too_short, 'array length differs from name'),
    (empty, 'neither position nor velocity')])
def test_malformed_joint_states_are_counted_with_their_reason(script, spoil, reason):
    bench = Bench(script)
    bench.drive(0.3, speed=0.1)
    bench.statuses()
    for _ in range(3):
        script.advance(0.001)
        script.publish(bench.joints, spoil(bench))
    status = bench.statuses()['joint_states']
    assert status.level == ERROR and reason in status.message
    assert status.values[f'rejected: {reason}'] == 3
    bench.drive(0.3, speed=0.1)
    assert math.isfinite(bench.odom[-1].pose.pose.position.x)
    assert bench.statuses()['joint_states'].level == OK


def test_one_wheel_that_is_not_a_number_leaves_the_others_in_use(script):
    bench = Bench(script)
    bench.drive(0.5)
    bench.drive(1.0, speed=0.2, encoder=nan_position)
    assert bench.odom[-1].pose.pose.position.x == pytest.approx(bench.travel - 0.006, abs=0.005)


def test_foreign_joints_are_skipped_silently(script):
    bench = Bench(script)
    bench.drive(0.2)
    script.publish(bench.joints, bench.joint_state(names=('arm', 'gripper')))
    assert bench.statuses()['joint_states'].level == OK
    assert not any(key.startswith('rejected') for key in bench.statuses()['joint_states'].values)


def test_without_an_imu_the_wheels_alone_are_used_and_it_is_said(script):
    bench = Bench(script, imu=False)
    bench.drive(1.0, speed=0.2)
    assert bench.odom[-1].pose.pose.position.x == pytest.approx(bench.travel - 0.006, abs=0.005)
    statuses = bench.statuses()
    assert statuses['imu'].level == WARN and 'no IMU' in statuses['imu'].message
    assert 'no IMU' in statuses['estimator'].message


def test_without_any_data_nothing_is_published_and_diagnostics_say_stale(script):
    bench = Bench(script)
    for _ in range(5):
        script.advance(0.5)
    assert bench.odom == []
    statuses = bench.statuses()
    assert statuses['joint_states'].level == STALE and statuses['estimator'].level == STALE


def test_silent_encoders_still_give_odometry_at_the_minimum_rate(script):
    bench = Bench(script)
    bench.drive(1.0, speed=0.2)
    count, last, silent_since = len(bench.odom), bench.odom[-1], script.now_ns
    bench.drive(1.0, encoder=False)
    predicted = [m for m in bench.odom[count:] if stamp_of(m) > silent_since]
    gaps = np.diff([stamp_of(m) for m in predicted]) * 1e-9
    assert 17 <= len(predicted) <= 22  # 20 Hz for one second, less the start
    # predicted estimates carry stamps of the IMU, every 5 ms
    assert np.all(gaps <= 0.055)
    assert predicted[-1].pose.covariance[0] > last.pose.covariance[0]
    assert bench.statuses()['estimator'].values['published: predicted'] == len(predicted)


def test_a_clock_that_goes_back_restarts_at_the_last_pose(script):
    bench = Bench(script)
    bench.drive(0.5)
    bench.drive(1.0, speed=0.3)
    before = bench.odom[-1]
    script.move_to(script.now_ns - 10 * 10**9 if script.now_ns > 11 * 10**9 else 10**8)
    back = script.now_ns
    bench.drive(0.5)
    after = [m for m in bench.odom if back <= stamp_of(m) < back + 5 * 10**8]
    assert after, 'odometry goes on at the new time'
    assert after[0].pose.pose.position.x == pytest.approx(before.pose.pose.position.x, abs=0.02)
    assert bench.statuses()['estimator'].values['restarts'] == 1


def test_frames_carry_the_prefix_and_topics_the_namespace(script):
    bench = Bench(script, robot_with(tf_frame_prefix='one/'), namespace='/one')
    transforms = []
    Transforms().listen(script._bench, '/one/tf', SENSOR_PUBLISHER, transforms.extend)
    bench.drive(0.3)
    assert bench.odom[-1].header.frame_id == 'one/odom'
    assert bench.odom[-1].child_frame_id == 'one/base_link'
    assert (transforms[-1].parent, transforms[-1].child) == ('one/odom', 'one/base_link')


def test_no_transform_is_sent_where_the_robot_file_says_so(script):
    bench = Bench(script, robot_with(enable_odom_tf=False))
    bench.drive(0.1)
    assert bench.node.count_publishers('/tf') == 0
    assert 'enable_odom_tf' in bench.statuses()['transform'].message


# --- wheel_ticks --------------------------------------------------------------------------------

COUNTS = 4096 / (2 * math.pi * RADIUS)  # counts a metre


@pytest.mark.parametrize('kind', [Int64MultiArray, Int32MultiArray])
def test_ticks_of_either_type_are_followed(script, kind):
    ticks = script.publisher(kind, 'wheel_ticks', SENSOR_PUBLISHER)
    node = script.add(OdometryNode, robot=robot_with(encoder__source='wheel_ticks'))
    odom = script.listen(Odometry, 'odom')
    script.connect()
    for i in range(100):
        script.advance(STEP)
        script.publish(ticks, kind(data=[round(0.3 * i * STEP * COUNTS)] * 4))
    assert node.ticks.type.endswith(kind.__name__)
    assert odom[-1].pose.pose.position.x == pytest.approx(0.3, abs=0.015)


def test_ticks_of_two_types_at_once_are_an_error_and_the_first_stays(script):
    node = script.add(OdometryNode, robot=robot_with(encoder__source='wheel_ticks'))
    first = script.publisher(Int64MultiArray, 'wheel_ticks', SENSOR_PUBLISHER)
    script.connect()
    # one participant cannot have both types, so the second one is put into the graph by hand
    other = type('Info', (), {'topic_type': 'std_msgs/msg/Int32MultiArray',
                              'qos_profile': SENSOR_PUBLISHER})
    seen = node.get_publishers_info_by_topic
    node.get_publishers_info_by_topic = lambda topic: [*seen(topic), other]
    node.ticks.look()
    script.publish(first, Int64MultiArray(data=[0] * 4))
    status = {s.name.partition(': ')[2]: s for s in node.diagnostics.publish()}['wheel_ticks']
    assert status.level == ERROR and 'Int32MultiArray' in status.message
    assert node.ticks.type.endswith('Int64MultiArray')


def test_ticks_before_the_first_clock_are_not_used(script):
    node = script.add(OdometryNode, robot=robot_with(encoder__source='wheel_ticks'))
    ticks = script.publisher(Int64MultiArray, 'wheel_ticks', SENSOR_PUBLISHER)
    script.connect()
    script.move_to(0)
    script.publish(ticks, Int64MultiArray(data=[0] * 4))
    status = {s.name.partition(': ')[2]: s for s in node.diagnostics.publish()}['wheel_ticks']
    assert status.values['rejected: no time yet on /clock'] == 1
    assert node.intake.estimator.health.received.get('wheel_ticks', 0) == 0


# --- IMU mount from tf_static -------------------------------------------------------------------

def mount_message(parent, child, xyz=(0.0, 0.0, 0.0), yaw=0.0):
    msg = TransformStamped()
    msg.header.frame_id, msg.child_frame_id = parent, child
    move, turn = msg.transform.translation, msg.transform.rotation
    move.x, move.y, move.z = xyz
    turn.z, turn.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return msg


def test_the_imu_mount_is_read_from_tf_static_through_a_chain(script):
    bench = Bench(script, robot_with(imu__from_tf=True))
    bench.drive(0.2)
    assert bench.odom == []  # waits for the mount
    assert 'tf_static' in bench.statuses()['imu'].message
    send = Transforms().sender(script._bench, 'tf_static', LATCHED)
    send(mount_message('base_link', 'deck', (0.1, 0.0, 0.2), math.pi / 2))
    script.settle()
    send(mount_message('deck', 'imu_link', (0.05, 0.0, 0.0), math.pi / 2))
    script.settle()
    bench.drive(0.2)
    mount = bench.node.intake.robot.imu
    # the deck is turned left: its x axis is the y axis of the base
    assert mount.xyz == pytest.approx([0.1, 0.05, 0.2], abs=1e-12)
    assert mount.rpy == pytest.approx([0.0, 0.0, math.pi], abs=1e-12)
    assert len(bench.odom) >= 36  # the samples that waited were not lost
    assert bench.statuses()['imu'].level == OK


def test_without_the_mount_odometry_starts_from_the_wheels_after_a_while(script, monkeypatch):
    monkeypatch.setattr('mecanum_base.intake.MOUNT_WAIT', 0.5)
    bench = Bench(script, robot_with(imu__from_tf=True))
    bench.drive(0.8, speed=0.1)
    assert bench.odom and bench.statuses()['imu'].level == ERROR
    at = bench.odom[-1].pose.pose.position.x
    assert at == pytest.approx(bench.travel, abs=0.01)
    Transforms().sender(script._bench, 'tf_static', LATCHED)(mount_message('base_link',
                                                                           'imu_link'))
    script.settle()
    bench.drive(0.5, speed=0.1)
    assert bench.statuses()['imu'].level == OK
    assert bench.odom[-1].pose.pose.position.x == pytest.approx(at + 0.05, abs=0.01)


# --- time ---------------------------------------------------------------------------------------

def test_a_forward_jump_of_the_clock_neither_floods_nor_stops_odometry(script):
    bench = Bench(script)
    bench.drive(0.5, speed=0.2)
    bench.drive(0.2)
    before = bench.odom[-1]
    script.move_to(script.now_ns + 3600 * 10**9)
    landed = script.now_ns
    bench.drive(0.3)
    after = [m for m in bench.odom if stamp_of(m) > stamp_of(before)]
    assert 20 <= len([m for m in after if stamp_of(m) >= landed]) <= 31
    assert len(after) < 50  # an hour is not filled with predictions
    assert after[-1].pose.pose.position.x == pytest.approx(bench.travel, abs=0.05)
    assert after[-1].pose.covariance[0] > 0.5  # m^2: the base may have been moved meanwhile


def test_a_small_step_back_of_the_clock_is_bridged(script):
    """As when NTP puts the clock of a robot right by 0.3 s."""
    bench = Bench(script)
    bench.drive(1.0, speed=0.2)
    script.move_to(script.now_ns - 300_000_000)
    step = script.now_ns
    bench.drive(1.0, speed=0.2)
    stamps = [stamp_of(m) for m in bench.odom]
    assert stamps == sorted(stamps)
    assert stamps[-1] > step + 900_000_000
    rejected = bench.statuses()['joint_states'].values['rejected: late']
    assert rejected == pytest.approx(28, abs=2)  # 0.3 s less the reorder wait, at 100 Hz
    # no more is lost than was driven during the step: 0.3 s at 0.2 m/s
    assert bench.travel - 0.07 < bench.odom[-1].pose.pose.position.x < bench.travel


def test_a_paused_clock_publishes_nothing_and_is_reported(script):
    bench = Bench(script)
    bench.drive(0.3)
    bench.statuses()
    count = len(bench.odom)
    for _ in range(20):
        script.settle()
    assert len(bench.odom) == count
    assert bench.statuses()['clock'].level == STALE
    bench.drive(0.3)
    assert bench.statuses()['clock'].level == OK and len(bench.odom) > count + 20
