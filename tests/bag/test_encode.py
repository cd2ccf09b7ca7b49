"""Messages made without ROS: empty ones of any type, lists of numbers, equal bytes."""

from __future__ import annotations

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from mecanum_base.bag.encode import blank, encode

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = ['sensor_msgs/msg/JointState', 'sensor_msgs/msg/Imu', 'nav_msgs/msg/Odometry',
         'std_msgs/msg/Int64MultiArray', 'std_msgs/msg/Int32MultiArray', 'geometry_msgs/msg/Twist',
         'diagnostic_msgs/msg/DiagnosticArray', 'sensor_msgs/msg/LaserScan',
         'geometry_msgs/msg/PoseWithCovarianceStamped']


@pytest.mark.parametrize('kind', TYPES)
def test_a_blank_message_survives_the_way_to_bytes_and_back(kind):
    message = blank(kind)
    raw = encode(message)
    assert raw == encode(blank(kind))
    assert encode(STORE.deserialize_cdr(raw, kind)) == raw


def test_blanks_share_nothing():
    first, second = blank('sensor_msgs/msg/Imu'), blank('sensor_msgs/msg/Imu')
    first.angular_velocity.x, first.orientation_covariance[0] = 1.0, -1.0
    assert second.angular_velocity.x == 0.0 and second.orientation_covariance[0] == 0.0


def test_plain_lists_are_taken_as_numbers_of_the_right_kind():
    message = blank('std_msgs/msg/Int32MultiArray')
    message.data = [1, -2, 2**31 - 1]
    back = STORE.deserialize_cdr(encode(message), 'std_msgs/msg/Int32MultiArray')
    assert back.data.dtype == np.int32 and back.data.tolist() == [1, -2, 2**31 - 1]
    message = blank('sensor_msgs/msg/JointState')
    message.name, message.velocity = ['a', 'b'], [0.5, -1.5]
    back = STORE.deserialize_cdr(encode(message), 'sensor_msgs/msg/JointState')
    assert back.name == ['a', 'b'] and back.velocity.tolist() == [0.5, -1.5]
    assert len(back.position) == 0
