"""The record node writes every topic of the contract as the bytes that came."""

import signal

import pytest
import yaml

pytest.importorskip('rclpy')
pytest.importorskip('mcap')
pytest.importorskip('rosbags')

from geometry_msgs.msg import TransformStamped, Twist
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Header, String

from mecanum_base.core.errors import BagError, ConfigError
from mecanum_base.ros.contract_topics import contract_topics
from mecanum_base.ros.diagnostics import ERROR, OK, STALE
from mecanum_base.ros.followed_topic import FollowedTopic
from mecanum_base.ros.qos import SENSOR_PUBLISHER
from mecanum_base.ros.record_node import RecordNode
from mecanum_base.ros.scripted import Script
from mecanum_base.ros.transforms import Transforms

STORE = get_typestore(Stores.ROS2_JAZZY)
LATCHED = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture
def script():
    with Script() as made:
        yield made


def recording(script, folder, **parameters):
    return script.add(RecordNode, parameters={'record.output': str(folder), **parameters})


def contents(folder):
    """(topic, log time, decoded message) of a finished bag."""
    with Reader(folder) as reader:
        return [(connection.topic, stamp, STORE.deserialize_cdr(raw, connection.msgtype))
                for connection, stamp, raw in reader.messages()]


def finish(script, node):
    script.remove(node)


def test_every_topic_of_the_contract_can_be_recorded(script, tmp_path):
    """One message on each topic, in its first type, found again with type and log time."""
    topics = {topic: next(iter(types.values()))
              for topic, types in contract_topics(Transforms()).items()
              if topic not in ('tf', 'tf_static')}
    publishers = {topic: script.publisher(kind, topic) for topic, kind in topics.items()}
    node = recording(script, tmp_path / 'bag')
    script.connect()
    for topic, publisher in publishers.items():
        message = topics[topic]()
        if topic == '/clock':
            message.clock.sec = script.now_ns // 10**9
        script.publish(publisher, message)
    finish(script, node)
    found = {topic: type(message).__name__ for topic, _, message in contents(tmp_path / 'bag')}
    assert set(topics) - {'/diagnostics', '/clock'} == {t.lstrip('/') for t in found} - {
        'diagnostics', 'clock'}
    for topic, name in found.items():
        kind = topics.get(topic) or topics[topic.lstrip('/')]
        assert name.endswith(kind.__name__)
    assert {stamp for _, stamp, _ in contents(tmp_path / 'bag')} == {script.now_ns}


def test_the_contract_names_each_topic_of_section_3():
    named = set(contract_topics(Transforms()))
    assert {'cmd_vel', 'wheel_commands', 'cmd_vel_limited', 'joint_states', 'wheel_ticks',
            'imu/data_raw', 'set_pose', 'odom', 'tf', 'tf_static', 'slip/twist', 'slip/wheels',
            'slip/probability', 'slip/ratio', 'odometry_reset', 'ground_truth/odom',
            'ground_truth/slip', 'goal_pose', 'obstacles', 'scan', '/clock',
            '/diagnostics'} == named


def test_values_survive_and_log_time_is_the_clock_of_the_node(script, tmp_path):
    states = script.publisher(JointState, 'joint_states', SENSOR_PUBLISHER)
    node = recording(script, tmp_path / 'bag')
    script.connect()
    times = []
    for i in range(50):
        script.advance(0.01)
        times.append(script.now_ns)
        script.publish(states, JointState(name=['a', 'b'], position=[float(i), -float(i)]))
    finish(script, node)
    found = contents(tmp_path / 'bag')
    assert [stamp for _, stamp, _ in found] == times
    assert [list(m.position) for _, _, m in found] == [[float(i), -float(i)] for i in range(50)]


def test_a_topic_that_appears_late_is_recorded_from_then_on(script, tmp_path):
    node = recording(script, tmp_path / 'bag')
    script.advance(0.1)
    odom = script.publisher(Odometry, 'odom')
    script.connect()  # waits until the record node has found it in the graph
    script.publish(odom, Odometry())
    finish(script, node)
    assert [topic for topic, _, _ in contents(tmp_path / 'bag')] == ['/odom']


def test_latched_transforms_that_were_sent_before_are_recorded(script, tmp_path):
    msg = TransformStamped()
    msg.header.frame_id, msg.child_frame_id = 'base_link', 'imu_link'
    Transforms().sender(script._bench, 'tf_static', LATCHED)(msg)
    node = recording(script, tmp_path / 'bag')
    script.wait_for(lambda: node.recorder.messages == 1, 'the latched transform')
    finish(script, node)
    (topic, _, message), = contents(tmp_path / 'bag')
    assert topic == '/tf_static' and message.transforms[0].child_frame_id == 'imu_link'
    info = yaml.safe_load((tmp_path / 'bag/metadata.yaml').read_text())
    qos = info['rosbag2_bagfile_information']['topics_with_message_count'][0]['topic_metadata'][
        'offered_qos_profiles'][0]
    assert (qos['durability'], qos['reliability']) == ('transient_local', 'reliable')


@pytest.mark.parametrize('later', [False, True])
def test_best_effort_publishers_are_heard(script, tmp_path, later):
    if later:  # subscribed reliably by then
        node = recording(script, tmp_path / 'bag')
    imu = script.publisher(Imu, 'imu/data_raw', QoSProfile(
        depth=10, reliability=ReliabilityPolicy.BEST_EFFORT))
    if not later:
        node = recording(script, tmp_path / 'bag')
    script.connect()
    script.publish(imu, Imu())
    finish(script, node)
    assert len(contents(tmp_path / 'bag')) == 1


def test_topics_of_a_namespace_are_recorded_under_their_full_names(script, tmp_path):
    odom = script.publisher(Odometry, '/one/odom')
    node = script.add(RecordNode, parameters={'record.output': str(tmp_path / 'bag')},
                      namespace='/one')
    script.connect()
    script.publish(odom, Odometry())
    finish(script, node)
    assert [topic for topic, _, _ in contents(tmp_path / 'bag')] == ['/one/odom']


def test_a_type_that_does_not_belong_to_the_topic_is_reported(script, tmp_path):
    wrong = script.publisher(String, 'odom')
    node = recording(script, tmp_path / 'bag')
    node.look()
    script.publish(wrong, String(data='no odometry'))
    status = {s.name.partition(': ')[2]: s for s in node._diagnostics.publish()}['recording']
    assert status.level == ERROR and 'odom as std_msgs/msg/String' in status.message
    finish(script, node)


def test_diagnostics_tell_nothing_yet_then_how_much(script, tmp_path):
    node = recording(script, tmp_path / 'bag')
    def status():
        return {s.name.partition(': ')[2]: s for s in node._diagnostics.publish()}['recording']
    assert status().level == STALE
    odom = script.publisher(Odometry, 'odom')
    script.connect()
    script.publish(odom, Odometry())
    assert status().level == OK and status().values['odom: messages'] == 1
    finish(script, node)


def test_messages_before_the_first_clock_get_its_time(script, tmp_path):
    headers = script.publisher(Header, 'odometry_reset')
    node = recording(script, tmp_path / 'bag')
    script.connect()
    script.move_to(0)
    script.publish(headers, Header(frame_id='first'))
    script.move_to(5_000_000_000)
    script.publish(headers, Header(frame_id='second'))
    finish(script, node)
    assert [(stamp, m.frame_id) for _, stamp, m in contents(tmp_path / 'bag')] == [
        (5_000_000_000, 'first'), (5_000_000_000, 'second')]


def test_an_existing_folder_is_refused_with_the_parameter_named(script, tmp_path):
    with pytest.raises(ConfigError, match=r'record\.output.*exists already'):
        recording(script, tmp_path)


def test_an_unknown_key_of_the_record_block_is_refused(script, tmp_path):
    with pytest.raises(ConfigError, match=r"record\.flush.*did you mean 'flush_period'"):
        recording(script, tmp_path / 'bag', **{'record.flush': 1.0})


def test_a_robot_file_may_be_given_too(script, tmp_path, robot_path):
    node = script.add(RecordNode, robot=robot_path,
                      parameters={'record.output': str(tmp_path / 'bag')})
    assert node.get_parameter('wheels.radius').value[0] == 0.05
    finish(script, node)


def test_a_full_disk_ends_the_recording_and_not_the_node(script, tmp_path, monkeypatch):
    odom = script.publisher(Odometry, 'odom')
    node = recording(script, tmp_path / 'bag')
    script.connect()

    def full(*_):
        raise BagError('bag_0.mcap: cannot be written: No space left on device')
    monkeypatch.setattr(node.recorder, 'write', full)
    script.publish(odom, Odometry())
    script.publish(odom, Odometry())
    status = {s.name.partition(': ')[2]: s for s in node._diagnostics.publish()}['recording']
    assert status.level == ERROR and 'No space left' in status.message
    node.recorder.close()


def test_a_changed_type_is_followed_and_the_old_one_let_go():
    """Twist is replaced by TwistStamped, as when another teleoperation program is started."""
    class Graph:
        def __init__(self):
            self.types, self.made, self.gone = [], [], []

        def get_publishers_info_by_topic(self, topic):
            return [type('I', (), {'topic_type': t, 'qos_profile': None}) for t in self.types]

        def create_subscription(self, kind, topic, callback, profile, raw):
            self.made.append(kind)
            return kind

        def destroy_subscription(self, subscription):
            self.gone.append(subscription)

    graph = Graph()
    followed = FollowedTopic(graph, 'cmd_vel', {'twist': 'A', 'stamped': 'B'}, None,
                             lambda infos: SENSOR_PUBLISHER, default='twist')
    assert followed.type == 'twist'
    graph.types = ['twist', 'stamped']
    assert not followed.look() and followed.conflict == 'stamped'
    graph.types = ['stamped', 'other']
    assert followed.look() and (followed.type, followed.conflict) == ('stamped', '')
    assert followed.unknown == 'other'
    assert (graph.made, graph.gone) == (['A', 'B'], ['A'])


@pytest.mark.slow
def test_a_killed_process_leaves_all_but_the_last_second_and_recovery_completes_it(
        outside, start, tmp_path):
    """SIGKILL in the middle of a recording at 200 Hz, from another process."""
    from mecanum_base.cli.main import main
    bag = tmp_path / 'killed'
    publisher = outside.node.create_publisher(Twist, 'cmd_vel', 10)
    process = start('-m', 'mecanum_base', 'record', '--output', bag)
    outside.until(lambda: publisher.get_subscription_count() == 1, 'the record node')
    sent = []
    outside.steer = None
    clock = outside.node.get_clock()

    def send():
        twist = Twist()
        twist.linear.x = float(len(sent))
        publisher.publish(twist)
        sent.append(clock.now().nanoseconds)
    outside.node.create_timer(0.005, send)
    outside.wait(1.6)
    killed_at = clock.now().nanoseconds
    process.send(signal.SIGKILL)
    assert process.finish() == -signal.SIGKILL
    path = bag / 'killed_0.mcap'
    numbers, last = [], 0
    with path.open('rb') as stream, pytest.raises(EndOfFile):
        for _, channel, message in NonSeekingReader(stream).iter_messages(log_time_order=False):
            last = message.log_time
            if channel.topic != '/cmd_vel':  # the recorder's own diagnostics
                continue
            numbers.append(STORE.deserialize_cdr(message.data, 'geometry_msgs/msg/Twist').linear.x)
    assert numbers == [float(i) for i in range(len(numbers))]
    # flushed every 0.5 s; a second is what the contract allows to lose
    assert (killed_at - last) * 1e-9 < 1.0
    assert main(['record', '--recover', str(path)]) == 0
    assert [m.linear.x for topic, _, m in contents(bag) if topic == '/cmd_vel'] == numbers
