"""The only file that knows ROS field names; duck-typed, so it imports no ROS.

The same lines read an rclpy message in a live node and a decoded message of a bag. Conversion
translates and does not judge values; a message whose shape is wrong raises
:class:`MalformedMessage`, which the intake counts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from mecanum_base.core.errors import MecanumBaseError
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.records import (
    CommandSample,
    Estimate,
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
    if len(msg.position) == 0 and len(msg.velocity) == 0:
        raise MalformedMessage('neither position nor velocity')
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
    found = wheel_sample(msg, joints)
    return None if found is None else CommandSample(found.stamp_ns, found.velocity)


def rates_of_array(msg: Any, order: tuple[str, ...], joints: tuple[str, ...]) -> FloatArray:
    """Wheel rates (W,) of a std_msgs/Float64MultiArray whose entries follow ``order``."""
    if len(msg.data) != len(order):
        raise MalformedMessage(f'wheel_commands has {len(msg.data)} entries instead of '
                               f'{len(order)}')
    by_name = {name: float(value) for name, value in zip(order, msg.data)}
    return np.array([by_name.get(joint, math.nan) for joint in joints])


def pose_sample(msg: Any) -> PoseSample:
    """Pose and covariance (x, y, yaw) of a geometry_msgs/PoseWithCovarianceStamped."""
    pose = msg.pose.pose
    grid = np.array([float(v) for v in msg.pose.covariance]).reshape(6, 6)
    axes = [0, 1, 5]
    return PoseSample(
        stamp_ns(msg.header.stamp),
        np.array([float(pose.position.x), float(pose.position.y), yaw_of(pose.orientation)]),
        grid[np.ix_(axes, axes)], frame_of(msg))


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


_USED = np.array([6 * i + j for i in (0, 1, 5) for j in (0, 1, 5)])  # of 36
_UNUSED = np.array([14, 21, 28])
UNUSED_VARIANCE = 1e6  # axes a planar base does not know: finite, so that filters stay finite
TRUTH_VARIANCE = 1e-9  # of ground truth; not 0, which other filters refuse


def write_stamp(stamp: int, time: Any) -> Any:
    """Fill a builtin_interfaces/Time from nanoseconds."""
    seconds, nanoseconds = divmod(int(stamp), NANOSECONDS)
    time.sec, time.nanosec = seconds, nanoseconds
    return time


def planar_covariance(covariance: FloatArray) -> FloatArray:
    """Covariance (36,) of (x, y, z, roll, pitch, yaw) from one (3, 3) of (x, y, yaw)."""
    whole = np.zeros(36)
    whole[_USED], whole[_UNUSED] = covariance.ravel(), UNUSED_VARIANCE
    return whole


def write_odometry(estimate: Estimate, msg: Any, odom_frame: str, base_frame: str) -> Any:
    """Fill a nav_msgs/Odometry: pose in ``odom_frame``, twist in ``base_frame``."""
    _write_motion(estimate, msg, odom_frame, base_frame)
    msg.pose.covariance = planar_covariance(estimate.pose_covariance)
    msg.twist.covariance = planar_covariance(estimate.twist_covariance)
    return msg


def write_transform(estimate: Estimate, msg: Any, odom_frame: str, base_frame: str) -> Any:
    """Fill a geometry_msgs/TransformStamped odom -> base."""
    _write_header(estimate.stamp_ns, odom_frame, msg.header)
    msg.child_frame_id = base_frame
    move, turn = msg.transform.translation, msg.transform.rotation
    move.x, move.y, move.z = float(estimate.pose[0]), float(estimate.pose[1]), 0.0
    turn.x, turn.y, turn.z, turn.w = quaternion_of_yaw(float(estimate.pose[2]))
    return msg


def write_slip_twist(estimate: Estimate, msg: Any, base_frame: str) -> Any:
    """Fill a geometry_msgs/TwistWithCovarianceStamped: wheel twist minus body twist."""
    _write_header(estimate.stamp_ns, base_frame, msg.header)
    _write_twist(estimate.slip.twist, msg.twist.twist)
    msg.twist.covariance = planar_covariance(estimate.slip.twist_covariance)
    return msg


def write_slip_wheels(stamp: int, rate: FloatArray, angle: FloatArray, msg: Any,
                      joints: tuple[str, ...]) -> Any:
    """Fill a sensor_msgs/JointState: slip rate [rad/s] in velocity, slip angle in position."""
    _write_header(stamp, '', msg.header)
    msg.name = list(joints)
    msg.position, msg.velocity = angle.tolist(), rate.tolist()
    return msg


def write_slip_probability(estimate: Estimate, msg: Any) -> Any:
    """Fill a std_msgs/Float64MultiArray: probability of slip a wheel, then of the body."""
    slip = estimate.slip
    msg.data = [*slip.probability.tolist(), float(slip.body_probability)]
    return msg


def write_slip_ratio(estimate: Estimate, msg: Any) -> Any:
    """Fill a std_msgs/Float64MultiArray: Tlale's s a wheel, then of the body; NaN = undefined."""
    msg.data = estimate.slip.ratio.tolist()
    return msg


def write_layout(msg: Any, dimension: Any, label: str) -> Any:
    """Give a std_msgs multi-array its one dimension (a std_msgs/MultiArrayDimension)."""
    dimension.label, dimension.size, dimension.stride = label, len(msg.data), len(msg.data)
    msg.layout.dim = [dimension]
    return msg


def write_reset(stamp: int, msg: Any, odom_frame: str) -> Any:
    """Fill the std_msgs/Header of ``odometry_reset``."""
    write_stamp(stamp, msg.stamp)
    msg.frame_id = odom_frame
    return msg


def write_wheel_angles(sample: WheelSample, msg: Any, joints: tuple[str, ...]) -> Any:
    """Fill a sensor_msgs/JointState as a joint state broadcaster does."""
    _write_header(sample.stamp_ns, '', msg.header)
    msg.name = list(joints)
    known = not bool(np.isnan(sample.velocity).any())
    msg.position = sample.position.tolist()
    msg.velocity = sample.velocity.tolist() if known else []
    return msg


def write_ticks(sample: TickSample, msg: Any) -> Any:
    """Fill a std_msgs/Int64MultiArray or Int32MultiArray with cumulative counts."""
    msg.data = [int(count) for count in sample.counts]
    return msg


def write_imu(sample: ImuSample, msg: Any, imu_frame: str) -> Any:
    """Fill a sensor_msgs/Imu without orientation and of unknown covariance (REP-145)."""
    _write_header(sample.stamp_ns, imu_frame, msg.header)
    for vector, values in ((msg.angular_velocity, sample.gyro),
                           (msg.linear_acceleration, sample.accel)):
        vector.x, vector.y, vector.z = (float(v) for v in values)
    absent = np.zeros(9)
    absent[0] = -1.0
    msg.orientation_covariance = absent
    msg.angular_velocity_covariance = msg.linear_acceleration_covariance = np.zeros(9)
    return msg


def write_truth(truth: Any, msg: Any, world_frame: str, base_frame: str) -> Any:
    """Fill a nav_msgs/Odometry from the simulator's ``Truth``."""
    _write_motion(truth, msg, world_frame, base_frame)
    certain = planar_covariance(TRUTH_VARIANCE * np.eye(3))
    msg.pose.covariance, msg.twist.covariance = certain, certain
    return msg


def write_diagnostics(stamp: int, statuses: Sequence[Any], msg: Any, status: Callable[[], Any],
                      key_value: Callable[[], Any]) -> Any:
    """Fill a diagnostic_msgs/DiagnosticArray from records with name, level, message, values.

    ``status`` and ``key_value`` make empty DiagnosticStatus and KeyValue messages.
    """
    write_stamp(stamp, msg.header.stamp)
    msg.status = []
    for record in statuses:
        item = status()
        item.level, item.name = bytes([record.level]), record.name
        item.message, item.hardware_id = record.message, record.hardware_id
        pairs = []
        for key, value in record.values.items():
            pair = key_value()
            pair.key, pair.value = str(key), str(value)
            pairs.append(pair)
        item.values = pairs
        msg.status.append(item)
    return msg


def command_twist(msg: Any) -> tuple[FloatArray, FloatArray]:
    """(linear (3,) m/s, angular (3,) rad/s) of a geometry_msgs/Twist or TwistStamped."""
    twist = getattr(msg, 'twist', msg)
    linear, angular = twist.linear, twist.angular
    return (np.array([float(linear.x), float(linear.y), float(linear.z)]),
            np.array([float(angular.x), float(angular.y), float(angular.z)]))


def write_wheel_rates(stamp: int, rates: FloatArray, msg: Any, joints: Sequence[str]) -> Any:
    """Fill a sensor_msgs/JointState with commanded rates [rad/s] by joint name."""
    write_stamp(stamp, msg.header.stamp)
    msg.name, msg.velocity = list(joints), rates.tolist()
    return msg


def write_rate_array(rates: FloatArray, msg: Any) -> Any:
    """Fill a std_msgs/Float64MultiArray with commanded rates [rad/s]."""
    msg.data = rates.tolist()
    return msg


def write_stamped_twist(stamp: int, twist: FloatArray, msg: Any, frame: str) -> Any:
    """Fill a geometry_msgs/TwistStamped with a twist (3,)."""
    _write_header(stamp, frame, msg.header)
    _write_twist(twist, msg.twist)
    return msg


def _write_header(stamp: int, frame: str, header: Any) -> None:
    write_stamp(stamp, header.stamp)
    header.frame_id = frame


def _write_motion(state: Any, msg: Any, frame: str, child: str) -> None:
    """Header, frames, pose and twist of a nav_msgs/Odometry from a record that has them."""
    _write_header(state.stamp_ns, frame, msg.header)
    msg.child_frame_id = child
    position, turn = msg.pose.pose.position, msg.pose.pose.orientation
    position.x, position.y, position.z = float(state.pose[0]), float(state.pose[1]), 0.0
    turn.x, turn.y, turn.z, turn.w = quaternion_of_yaw(float(state.pose[2]))
    _write_twist(state.twist, msg.twist.twist)


def _write_twist(twist: FloatArray, msg: Any) -> None:
    msg.linear.x, msg.linear.y, msg.linear.z = float(twist[0]), float(twist[1]), 0.0
    msg.angular.x, msg.angular.y, msg.angular.z = 0.0, 0.0, float(twist[2])


def frame_of(msg: Any) -> str:
    """Frame name of a stamped message, without a leading slash."""
    return str(msg.header.frame_id).lstrip('/')


def planar_pose(pose: Any) -> FloatArray:
    """Pose (3,) (x, y, yaw) of a geometry_msgs/Pose; raises MalformedMessage for NaN."""
    found = np.array([float(pose.position.x), float(pose.position.y), yaw_of(pose.orientation)])
    if not np.all(np.isfinite(found)):
        raise MalformedMessage('pose is not finite')
    return found


def obstacle_points(msg: Any) -> FloatArray:
    """Points (N, 2) of a geometry_msgs/PoseArray in its own frame; those not finite left out."""
    points = np.array([[float(p.position.x), float(p.position.y)] for p in msg.poses])
    points = points.reshape(-1, 2)
    return points[np.all(np.isfinite(points), axis=1)]


def scan_points(msg: Any) -> FloatArray:
    """Points (N, 2) that a sensor_msgs/LaserScan hit, in its own frame."""
    ranges = np.array(msg.ranges, dtype=np.float64)
    angles = float(msg.angle_min) + float(msg.angle_increment) * np.arange(len(ranges))
    with np.errstate(invalid='ignore'):
        hit = (ranges >= float(msg.range_min)) & (ranges <= float(msg.range_max))
    hit &= np.isfinite(ranges)
    return np.stack([ranges[hit] * np.cos(angles[hit]), ranges[hit] * np.sin(angles[hit])], axis=1)


def write_twist(twist: FloatArray, msg: Any) -> Any:
    """Fill a geometry_msgs/Twist from a twist (3,)."""
    _write_twist(twist, msg)
    return msg
