"""Transforms reach other nodes with the name, hash and bytes of tf2_msgs/TFMessage."""

import math
import os
import random

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from mecanum_base.ros.qos import SENSOR_PUBLISHER
from mecanum_base.ros.scripted import Script
from mecanum_base.ros.transforms import (
    MalformedTransform,
    Transforms,
    decode,
    encode,
)

LATCHED = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)
# type name and hash that ROS 2 Jazzy shows for tf2_msgs (ros2 topic info -v /tf)
TYPE_HASH = 'e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087'


@pytest.fixture(autouse=True)
def _checked(monkeypatch):
    monkeypatch.setenv('ROS_PYTHON_CHECK_FIELDS', '1')


def transform(rng):
    msg = TransformStamped()
    msg.header.stamp.sec, msg.header.stamp.nanosec = rng.randrange(2**31), rng.randrange(10**9)
    msg.header.frame_id = 'o' * rng.randrange(12)
    msg.child_frame_id = 'bäse' * rng.randrange(4)
    move, turn = msg.transform.translation, msg.transform.rotation
    move.x, move.y, move.z = (rng.uniform(-10, 10) for _ in range(3))
    turn.x, turn.y, turn.z, turn.w = (rng.uniform(-1, 1) for _ in range(4))
    return msg


def values(msg):
    move, turn = msg.transform.translation, msg.transform.rotation
    return (msg.header.stamp.sec * 10**9 + msg.header.stamp.nanosec, msg.header.frame_id,
            msg.child_frame_id, (move.x, move.y, move.z), (turn.x, turn.y, turn.z, turn.w))


def as_tuple(item):
    return item.stamp_ns, item.parent, item.child, item.xyz, item.quaternion


def test_encoding_and_decoding_are_inverse():
    rng = random.Random(1)
    for count in (0, 1, 2, 5):
        sent = [transform(rng) for _ in range(count)]
        assert [as_tuple(t) for t in decode(encode(sent))] == [values(m) for m in sent]


def test_the_bytes_are_those_of_an_independent_serializer():
    rosbags = pytest.importorskip('rosbags.typesys')
    store = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)
    types, rng = store.types, random.Random(2)
    for count in (0, 1, 3):
        sent = [transform(rng) for _ in range(count)]
        mirrored = [types['geometry_msgs/msg/TransformStamped'](
            header=types['std_msgs/msg/Header'](
                stamp=types['builtin_interfaces/msg/Time'](
                    sec=m.header.stamp.sec, nanosec=m.header.stamp.nanosec),
                frame_id=m.header.frame_id),
            child_frame_id=m.child_frame_id,
            transform=types['geometry_msgs/msg/Transform'](
                translation=types['geometry_msgs/msg/Vector3'](*values(m)[3]),
                rotation=types['geometry_msgs/msg/Quaternion'](*values(m)[4]))) for m in sent]
        whole = types['tf2_msgs/msg/TFMessage'](transforms=mirrored)
        assert encode(sent) == bytes(store.serialize_cdr(whole, 'tf2_msgs/msg/TFMessage'))


def test_big_endian_bytes_of_other_machines_are_read():
    rosbags = pytest.importorskip('rosbags.typesys')
    store = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)
    sent = [transform(random.Random(3))]
    whole = store.deserialize_cdr(encode(sent), 'tf2_msgs/msg/TFMessage')
    big = bytes(store.serialize_cdr(whole, 'tf2_msgs/msg/TFMessage', little_endian=False))
    assert big[:2] == b'\0\0'
    assert [as_tuple(t) for t in decode(big)] == [values(m) for m in sent]


@pytest.mark.parametrize('cut', [0, 3, 5, 7, 12, 40, 80])
def test_cut_bytes_are_refused(cut):
    msg = transform(random.Random(4))
    msg.header.frame_id = 'odom'
    with pytest.raises(MalformedTransform):
        decode(encode([msg])[:cut])


def test_a_transform_arrives_as_it_was_sent():
    transforms = Transforms()
    assert transforms.available
    with Script() as script:
        heard = []
        send = transforms.sender(script._bench, 'tf', SENSOR_PUBLISHER)
        transforms.listen(script._bench, 'tf', SENSOR_PUBLISHER, heard.extend)
        rng = random.Random(5)
        sent = [transform(rng) for _ in range(20)]
        for msg in sent:
            send(msg)
            script.settle()
        assert [as_tuple(t) for t in heard] == [values(m) for m in sent]


def test_the_topic_has_the_name_and_hash_of_tf2_msgs():
    with Script() as script:
        Transforms().sender(script._bench, 'tf', SENSOR_PUBLISHER)
        info, = script._bench.get_publishers_info_by_topic('/tf')
        assert info.topic_type == 'tf2_msgs/msg/TFMessage'
        assert info.topic_type_hash.value.hex() == TYPE_HASH


def test_a_late_listener_hears_static_transforms():
    transforms = Transforms()
    with Script() as script:
        heard = []
        transforms.sender(script._bench, 'tf_static', LATCHED)(transform(random.Random(6)))
        transforms.listen(script._bench, 'tf_static', LATCHED, heard.extend)
        script.wait_for(lambda: heard, 'the latched transform')


def test_bytes_that_are_no_transforms_are_skipped():
    transforms = Transforms()
    if transforms.native:
        pytest.skip('a compiled publisher takes no bytes')
    with Script() as script:
        heard, rng = [], random.Random(8)
        publisher = script._bench.create_publisher(transforms.message, 'tf', SENSOR_PUBLISHER)
        transforms.listen(script._bench, 'tf', SENSOR_PUBLISHER, heard.extend)
        for _ in range(50):
            script.publish(publisher, b'\0\1\0\0' + rng.randbytes(rng.randrange(4, 90)))
        heard.clear()
        script.publish(publisher, encode([transform(rng)]))
        assert len(heard) == 1


def test_many_contexts_one_after_the_other_keep_working():
    transforms = Transforms()
    for round_number in range(10):
        with Script() as script:
            heard = []
            send = transforms.sender(script._bench, 'tf', SENSOR_PUBLISHER)
            transforms.listen(script._bench, 'tf', SENSOR_PUBLISHER, heard.extend)
            msg = transform(random.Random(round_number))
            send(msg)
            script.settle()
            assert [as_tuple(t) for t in heard] == [values(msg)]


def test_the_way_is_told_in_words():
    transforms = Transforms()
    assert 'tf2_msgs/TFMessage' in transforms.way
    assert transforms.native == ('derived' not in transforms.way)


def test_yaw_survives_the_quaternion():
    from mecanum_base import messages
    for yaw in (-3.0, -0.1, 0.0, 1.0, math.pi):
        x, y, z, w = messages.quaternion_of_yaw(yaw)
        assert math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) == pytest.approx(
            yaw, abs=1e-12)


@pytest.mark.skipif(not os.environ.get('NATIVE_TF2'), reason='needs a compiled tf2_msgs: .ci/run')
def test_the_derived_class_and_a_compiled_tf2_msgs_understand_each_other():
    from tf2_msgs.msg import TFMessage

    from mecanum_base.ros.tf_message import derived_tf_message
    derived = derived_tf_message()
    assert Transforms().native and derived is not TFMessage
    rng = random.Random(7)
    first, second = transform(rng), transform(rng)
    with Script() as script:  # compiled to derived
        heard = []
        script._bench.create_subscription(
            derived, 'one', lambda raw: heard.extend(decode(bytes(raw))), 10, raw=True)
        script.publish(script.publisher(TFMessage, 'one'), TFMessage(transforms=[first, second]))
        assert [as_tuple(t) for t in heard] == [values(first), values(second)]
        sent = script._bench.create_publisher(derived, 'two', 10)  # derived to compiled
        messages = script.listen(TFMessage, 'two')
        script.publish(sent, encode([first, second]))
        assert messages == [TFMessage(transforms=[first, second])]
