"""The same messages give the same bytes of track.csv, live or replayed, in any order."""

import pathlib
import random

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('mcap')
pytest.importorskip('rosbags')

from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Header, Int64MultiArray
from std_srvs.srv import Trigger

from mecanum_base import messages, robot_file
from mecanum_base.bag.recorder import Recorder
from mecanum_base.bag.replay import replay
from mecanum_base.bag.topics import Topics
from mecanum_base.bag.track import TrackWriter
from mecanum_base.core.records import ImuSample, TickSample, WheelSample
from mecanum_base.intake import Intake
from mecanum_base.robot import Robot
from mecanum_base.robot_file import read_parameters
from mecanum_base.ros.odometry_node import STATIC, OdometryNode
from mecanum_base.ros.qos import SENSOR_PUBLISHER
from mecanum_base.ros.record_node import RecordNode
from mecanum_base.ros.scripted import Script
from mecanum_base.ros.transforms import Transforms
from mecanum_base.sim.simulation import Simulation

ROBOT = pathlib.Path(__file__).parents[2] / 'config' / 'mecanum4.yaml'
START = 1_700_000_000_000_000_000
ORDERS = 50
SECONDS = 0.8
WHEEL_STEP = 10_000_000  # ns between commands


@pytest.fixture(autouse=True)
def _checked(monkeypatch):
    monkeypatch.setenv('ROS_PYTHON_CHECK_FIELDS', '1')


def simulated(robot, seconds=SECONDS, start_ns=START):
    """Sensor messages of a run with standstill, driving, strafing and a turn: (arrival, msg)."""
    sim = Simulation(robot.base, robot.encoder, robot.imu, robot.sim, start_ns=start_ns)
    found = []
    for step in range(round(seconds * 1e9 / WHEEL_STEP)):
        phase = 4.0 * step * WHEEL_STEP * 1e-9 / seconds
        wave = [0.0, 4.0, 8.0, -6.0][int(phase)]
        sim.command([wave, -wave if phase > 2.0 else wave, wave, wave])
        for item in sim.advance_published(start_ns + (step + 1) * WHEEL_STEP):
            msg = as_message(item.reading, robot)
            if msg is not None:
                found.append((item.at_ns, msg))
    return found


def as_message(reading, robot):
    if isinstance(reading, WheelSample):
        return messages.write_wheel_angles(reading, JointState(), robot.base.joint)
    if isinstance(reading, TickSample):
        return messages.write_ticks(reading, Int64MultiArray())
    if isinstance(reading, ImuSample):
        return messages.write_imu(reading, Imu(), 'imu_link')
    return None


def pose_message(stamp, x):
    msg = PoseWithCovarianceStamped()
    messages.write_stamp(stamp, msg.header.stamp)
    msg.header.frame_id = 'odom'
    msg.pose.pose.position.x, msg.pose.pose.orientation.w = x, 1.0
    msg.pose.covariance[0] = msg.pose.covariance[7] = msg.pose.covariance[35] = 1e-4
    return msg


def reset_message(stamp):
    return messages.write_reset(stamp, Header(), 'odom')


def stamp_of(msg):
    return messages.stamp_ns(msg.stamp if isinstance(msg, Header) else msg.header.stamp)


def feed(intake, arrival, msg):
    if isinstance(msg, JointState):
        return intake.joint_states(msg)
    if isinstance(msg, Imu):
        return intake.imu(msg)
    if isinstance(msg, Header):
        return intake.odometry_reset(msg)
    if isinstance(msg, PoseWithCovarianceStamped):
        return intake.set_pose(msg)
    return intake.wheel_ticks(msg, arrival)


def track_of(robot, arrivals, folder):
    """Bytes of track.csv for messages in this order of arrival."""
    intake = Intake(robot)
    with TrackWriter(folder, robot.base.joint) as writer:
        for arrival, msg in arrivals:
            for estimate in feed(intake, arrival, msg):
                writer.write(estimate)
        for estimate in intake.flush():
            writer.write(estimate)
    late = {key: n for key, n in intake.estimator.health.rejected.items() if 'late' in key[1]}
    assert not late, late
    return (folder / 'track.csv').read_bytes()


def shuffled(found, wait_ns, seed):
    """Another order of arrival: each message is delayed by less than half the reorder wait."""
    rng = random.Random(seed)
    delayed = [(stamp_of(msg) + rng.randrange(wait_ns // 2), index, msg)
               for index, (_, msg) in enumerate(found)]
    return [(arrival, msg) for arrival, _, msg in sorted(delayed, key=lambda item: item[:2])]


def mixed(robot):
    """0.4 s of joint_states and IMU with a given pose and a reset in between."""
    found = [(at, msg) for at, msg in simulated(robot, 0.4)
             if not isinstance(msg, Int64MultiArray)]
    found.insert(len(found) // 2, (0, pose_message(START + 203_000_000, 5.0)))
    found.insert(3 * len(found) // 4, (0, reset_message(START + 300_000_000)))
    return found


def test_fifty_orders_of_arrival_give_the_same_bytes(tmp_path):
    robot = robot_file.load_robot(ROBOT)
    found = mixed(robot)
    wait_ns = round(robot.estimator.reorder_wait * 1e9)
    tracks = set()
    orders = set()
    for seed in range(ORDERS):
        arrivals = shuffled(found, wait_ns, seed)
        orders.add(tuple(id(msg) for _, msg in arrivals))
        tracks.add(track_of(robot, arrivals, tmp_path / str(seed)))
    assert len(orders) == ORDERS and len(tracks) == 1
    lines = tracks.pop().decode().splitlines()
    xs = [float(line.split(',')[1]) for line in lines[1:]]
    assert max(xs) > 4.9 and abs(xs[-1]) < 1.0  # pose and reset were applied
    assert len(lines) > 0.9 * 0.4 * 100


def record(folder, arrivals):
    """A bag of these messages, logged at their arrival."""
    recorder = Recorder(folder)
    from rclpy.serialization import serialize_message

    from mecanum_base.ros.contract_topics import type_name
    topics = {JointState: '/joint_states', Imu: '/imu/data_raw', Header: '/odometry_reset',
              PoseWithCovarianceStamped: '/set_pose', Int64MultiArray: '/wheel_ticks'}
    channels = {}
    for arrival, msg in arrivals:
        kind = type(msg)
        if kind not in channels:
            channels[kind] = recorder.channel(topics[kind], type_name(kind))
        if isinstance(msg, JointState):  # an empty trailing array serializes 4 bytes too long
            msg.effort = [0.0] * len(msg.name)
        recorder.write(channels[kind], arrival, arrival, serialize_message(msg))
    recorder.close()
    return folder


def replayed(robot, bag, out):
    replay([str(bag)], robot, out, Topics.of(robot))
    return (out / 'track.csv').read_bytes()


def test_a_replayed_bag_gives_the_bytes_of_the_intake(tmp_path):
    robot = robot_file.load_robot(ROBOT)
    found = mixed(robot)
    arrivals = shuffled(found, round(robot.estimator.reorder_wait * 1e9), 7)
    live = track_of(robot, arrivals, tmp_path / 'live')
    assert replayed(robot, record(tmp_path / 'bag', arrivals), tmp_path / 'out') == live


class Tap:
    """Writes what a live odometry node publishes into track files."""

    def __init__(self, node, folder):
        self.folder, self.node = folder, node
        self.writer = TrackWriter(folder, node.robot.base.joint)
        publish = node.topics.publish

        def both(estimate):
            self.writer.write(estimate)
            publish(estimate)
        node.topics.publish = both

    def track(self):
        for estimate in self.node.intake.flush():
            self.writer.write(estimate)
        self.writer.close()
        return (self.folder / 'track.csv').read_bytes()


def mount_message():
    msg = TransformStamped()
    msg.header.frame_id, msg.child_frame_id = 'base_link', 'imu_link'
    msg.transform.translation.x, msg.transform.rotation.w = 0.05, 1.0
    return msg


@pytest.mark.parametrize('source,from_tf,late', [
    ('joint_states', False, 0.0), ('wheel_ticks', False, -0.0123456789),
    ('joint_states', True, 0.0123456789)])
def test_what_the_node_published_is_what_replay_of_the_recording_writes(tmp_path, source, from_tf,
                                                                        late):
    """Odometry node and record node hear the same topics; the bag replays to the same bytes.

    All messages travel through DDS; a reset is asked for by service and a pose is given; the
    mount of the IMU is in the robot file or comes on tf_static, in the middle of the data. The IMU
    is stamped on time, early and late.
    """
    mapping = read_parameters(ROBOT)
    mapping['encoder']['source'] = source
    mapping['imu'].update(from_tf=from_tf, late=late)
    robot = Robot.from_mapping(mapping)
    with Script(start_ns=START) as script:
        found = simulated(robot, 0.8)
        tell_mount = Transforms().sender(script._bench, 'tf_static', STATIC)
        publishers = {
            JointState: script.publisher(JointState, 'joint_states', SENSOR_PUBLISHER),
            Int64MultiArray: script.publisher(Int64MultiArray, 'wheel_ticks', SENSOR_PUBLISHER),
            Imu: script.publisher(Imu, 'imu/data_raw', SENSOR_PUBLISHER),
            PoseWithCovarianceStamped: script.publisher(PoseWithCovarianceStamped, 'set_pose')}
        odometry = script.add(OdometryNode, robot=mapping)
        recorder = script.add(RecordNode, parameters={'record.output': str(tmp_path / 'bag')})
        tap = Tap(odometry, tmp_path / 'live')
        script.wait_for(lambda: odometry.count_publishers('/odometry_reset') == 1, 'discovery')
        script.connect()
        recorder.look()
        half = len(found) // 2
        for index, (arrival, msg) in enumerate(found):
            if arrival > script.now_ns:
                script.move_to(arrival)
            script.publish(publishers[type(msg)], msg)
            if index == 100:
                tell_mount(mount_message())
                script.settle()
            if index == half:
                script.publish(publishers[PoseWithCovarianceStamped],
                               pose_message(script.now_ns, 5.0))
            if index == half + 100:
                assert script.call(Trigger, 'odometry_node/reset', Trigger.Request()).success
        live = tap.track()
        script.remove(recorder)
    assert replayed(robot, tmp_path / 'bag', tmp_path / 'out') == live
    xs = [float(line.split(',')[1]) for line in live.decode().splitlines()[1:]]
    assert max(xs) > 4.9 and abs(xs[-1]) < 1.0
