"""The only file that knows ROS field names; duck-typed, so it imports no ROS.

The same lines read an rclpy message in a live node and a decoded message of a bag. Conversion
translates and does not judge values; a message whose shape is wrong raises
:class:`MalformedMessage`, which the intake counts.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mecanum_base.core.errors import MecanumBaseError
from mecanum_base.core.records import (
    CommandSample,
    ImuSample,
    PoseSample,
    ResetSample,
    TickSample,
    WheelSample,
)

NANOSECONDS = 1_000_000_000


class MalformedMessage(MecanumBaseError):
    """A message that breaks the rules of its own type; the text is the reason that is counted."""


def stamp_ns(stamp: Any) -> int:
    """Nanoseconds of a builtin_interfaces/Time."""
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)


def wheel_sample(msg: Any, joints: tuple[str, ...]) -> WheelSample | None:
    """Wheel angles of a sensor_msgs/JointState by joint name; None if it names no wheel.

    Raises MalformedMessage for a wheel named twice or arrays whose length is neither 0 nor that
    of ``name``.
    """
    names = list(msg.name)
    index = {name: i for i, name in enumerate(names)}
    wanted = [index.get(joint) for joint in joints]
    if all(i is None for i in wanted):
        return None
    if any(names.count(joint) > 1 for joint in joints):
        raise MalformedMessage('joint named twice')
    for field in (msg.position, msg.velocity):
        if len(field) not in (0, len(names)):
            raise MalformedMessage('array length differs from name')
    return WheelSample(stamp_ns(msg.header.stamp), _pick(msg.position, wanted),
                       _pick(msg.velocity, wanted))


def _pick(values: Any, wanted: list[int | None]) -> np.ndarray:
    if len(values) == 0:
        return np.full(len(wanted), np.nan)
    return np.array([math.nan if i is None else float(values[i]) for i in wanted])


def tick_sample(msg: Any, count: int, arrival_ns: int) -> TickSample:
    """Counts of a std_msgs/Int64MultiArray or Int32MultiArray; stamped by its arrival."""
    if len(msg.data) != count:
        raise MalformedMessage('wheel_ticks length differs from wheels')
    return TickSample(arrival_ns, np.array([int(v) for v in msg.data], dtype=np.int64))


def imu_sample(msg: Any) -> ImuSample:
    """Gyro and accelerometer of a sensor_msgs/Imu in its own frame; NaN where it has none."""
    gyro, accel = msg.angular_velocity, msg.linear_acceleration
    has_gyro = float(msg.angular_velocity_covariance[0]) != -1.0
    has_accel = float(msg.linear_acceleration_covariance[0]) != -1.0
    return ImuSample(
        stamp_ns(msg.header.stamp),
        np.array([gyro.x, gyro.y, gyro.z]) if has_gyro else np.full(3, np.nan),
        np.array([accel.x, accel.y, accel.z]) if has_accel else np.full(3, np.nan))


def command_sample(msg: Any, joints: tuple[str, ...]) -> CommandSample | None:
    """Commanded wheel rates of a sensor_msgs/JointState (wheel_commands)."""
    sample = wheel_sample(msg, joints)
    return None if sample is None else CommandSample(sample.stamp_ns, sample.velocity)


def pose_sample(msg: Any) -> PoseSample:
    """Pose and covariance (x, y, yaw) of a geometry_msgs/PoseWithCovarianceStamped."""
    pose = msg.pose.pose
    grid = np.array([float(v) for v in msg.pose.covariance]).reshape(6, 6)
    axes = [0, 1, 5]
    return PoseSample(
        stamp_ns(msg.header.stamp),
        np.array([float(pose.position.x), float(pose.position.y), yaw_of(pose.orientation)]),
        grid[np.ix_(axes, axes)])


def reset_sample(msg: Any) -> ResetSample:
    """A reset request published as std_msgs/Header (odometry_reset)."""
    return ResetSample(stamp_ns(msg.stamp))


def yaw_of(quaternion: Any) -> float:
    """Yaw [rad] of a geometry_msgs/Quaternion."""
    x, y, z, w = (float(v) for v in (quaternion.x, quaternion.y, quaternion.z, quaternion.w))
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def quaternion_of_yaw(yaw: float) -> tuple[float, float, float, float]:
    """(x, y, z, w) of a rotation by ``yaw`` [rad] about z."""
    return 0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)
