"""Recordings for the tests, written by libraries that the reader under test does not use."""

from __future__ import annotations

import pathlib
import sys
import types

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from mecanum_base.cli.main import main

# driving, calibration_coverage and doctor_table are also campaigns of their own
sys.path.insert(0, str(pathlib.Path(__file__).parent))

STORE = get_typestore(Stores.ROS2_JAZZY)
T = STORE.types
WHEELS = ('front_left_wheel_joint', 'front_right_wheel_joint', 'rear_left_wheel_joint',
          'rear_right_wheel_joint')
T0 = 1_700_000_000_000_000_000
MS = 1_000_000


def header(stamp_ns, frame=''):
    return T['std_msgs/msg/Header'](
        stamp=T['builtin_interfaces/msg/Time'](sec=int(stamp_ns // 10**9),
                                               nanosec=int(stamp_ns % 10**9)), frame_id=frame)


def joint_state(stamp_ns, position, names=WHEELS, velocity=(), effort=(), frame=''):
    return T['sensor_msgs/msg/JointState'](
        header=header(stamp_ns, frame), name=list(names), position=np.array(position, float),
        velocity=np.array(velocity, float), effort=np.array(effort, float))


def imu(stamp_ns, gyro=(0, 0, 0), accel=(0, 0, 9.81), frame='imu_link', no_accel=False):
    vector, none = T['geometry_msgs/msg/Vector3'], np.array([-1.0] + 8 * [0.0])
    return T['sensor_msgs/msg/Imu'](
        header=header(stamp_ns, frame),
        orientation=T['geometry_msgs/msg/Quaternion'](x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=none,
        angular_velocity=vector(*(float(v) for v in gyro)),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector(*(float(v) for v in accel)),
        linear_acceleration_covariance=none if no_accel else np.zeros(9))


def ticks(counts, bits=64):
    dim = T['std_msgs/msg/MultiArrayDimension'](label='wheel', size=len(counts),
                                                stride=len(counts))
    return T[f'std_msgs/msg/Int{bits}MultiArray'](
        layout=T['std_msgs/msg/MultiArrayLayout'](dim=[dim], data_offset=0),
        data=np.array(counts, f'int{bits}'))


def quaternion(yaw):
    return T['geometry_msgs/msg/Quaternion'](x=0.0, y=0.0, z=float(np.sin(yaw / 2)),
                                             w=float(np.cos(yaw / 2)))


def odometry(stamp_ns, pose, frame='map', child='base_link'):
    x, y, yaw = (float(v) for v in pose)
    zero = T['geometry_msgs/msg/Vector3'](x=0.0, y=0.0, z=0.0)
    return T['nav_msgs/msg/Odometry'](
        header=header(stamp_ns, frame), child_frame_id=child,
        pose=T['geometry_msgs/msg/PoseWithCovariance'](
            pose=T['geometry_msgs/msg/Pose'](
                position=T['geometry_msgs/msg/Point'](x=x, y=y, z=0.0),
                orientation=quaternion(yaw)), covariance=np.zeros(36)),
        twist=T['geometry_msgs/msg/TwistWithCovariance'](
            twist=T['geometry_msgs/msg/Twist'](linear=zero, angular=zero),
            covariance=np.zeros(36)))


def set_pose(stamp_ns, pose):
    x, y, yaw = (float(v) for v in pose)
    return T['geometry_msgs/msg/PoseWithCovarianceStamped'](
        header=header(stamp_ns, 'odom'), pose=T['geometry_msgs/msg/PoseWithCovariance'](
            pose=T['geometry_msgs/msg/Pose'](
                position=T['geometry_msgs/msg/Point'](x=x, y=y, z=0.0),
                orientation=quaternion(yaw)), covariance=np.diag([1e-6] * 6).reshape(-1)))


def serialized(msg, little_endian=True):
    return bytes(STORE.serialize_cdr(msg, msg.__msgtype__, little_endian=little_endian))


def write_mcap(path, entries, compression='zstd', chunk_size=16384, chunked=True, crc=True):
    """``entries``: (topic, log_ns, message or (type name, bytes))."""
    with open(path, 'wb') as file:
        writer = Writer(file, chunk_size=chunk_size, use_chunking=chunked, enable_crcs=crc,
                        compression={'zstd': CompressionType.ZSTD, 'lz4': CompressionType.LZ4,
                                     'none': CompressionType.NONE}[compression])
        writer.start('ros2', 'tests')
        channels = {}
        for topic, log_ns, msg in entries:
            kind, data = msg if isinstance(msg, tuple) else (msg.__msgtype__, serialized(msg))
            if (topic, kind) not in channels:
                schema = writer.register_schema(kind, 'ros2msg', b'')
                channels[topic, kind] = writer.register_channel(topic, 'cdr', schema)
            writer.add_message(channels[topic, kind], int(log_ns), data, int(log_ns))
        writer.finish()
    return str(path)


def drive(seconds=2.0, wheel_hz=50, imu_hz=100, rate=4.0, start_ns=T0):
    """Straight driving: entries in log order."""
    entries = []
    for i in range(int(seconds * imu_hz)):
        stamp = start_ns + i * 1000 * MS // imu_hz
        entries.append(('/imu/data_raw', stamp + 50_000, imu(stamp)))
    for i in range(int(seconds * wheel_hz)):
        stamp = start_ns + i * 1000 * MS // wheel_hz
        angle = [rate * i / wheel_hz] * 4
        entries.append(('/joint_states', stamp + 60_000, joint_state(stamp, angle)))
        entries.append(('/wheel_ticks', stamp + 70_000,
                        ticks([round(a / (2 * np.pi) * 4096) for a in angle])))
    return sorted(entries, key=lambda e: e[1])


@pytest.fixture
def mecanum(capsys):
    """Runs `mecanum ...` in this process: returncode, stdout and stderr, as of one of its own."""
    def run(*words):
        capsys.readouterr()
        code = main([str(word) for word in words])
        told = capsys.readouterr()
        return types.SimpleNamespace(returncode=code, stdout=told.out, stderr=told.err)
    return run


@pytest.fixture
def make():
    """The functions of this file, as one object."""
    return types.SimpleNamespace(**{k: v for k, v in globals().items() if not k.startswith('_')})
