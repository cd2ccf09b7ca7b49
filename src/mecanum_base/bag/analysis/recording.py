"""A whole recording as columns: for every topic its times, and the numbers of the known types."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mecanum_base import messages
from mecanum_base.bag.block import Block, Channel, Loss
from mecanum_base.bag.decode import (
    IMU,
    JOINT_STATE,
    TICKS,
    header_stamps,
    imu_readings,
    message,
    tick_readings,
    wheel_readings,
)
from mecanum_base.bag.layout import NoLayout, joint_state_layout, multi_array_layout
from mecanum_base.bag.reader import Bag
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.se2 import wrap_angle

ODOMETRY, TF = 'nav_msgs/msg/Odometry', 'tf2_msgs/msg/TFMessage'
POSE_TYPES = (ODOMETRY, 'geometry_msgs/msg/PoseStamped',
              'geometry_msgs/msg/PoseWithCovarianceStamped',
              'geometry_msgs/msg/TransformStamped', TF)
TWIST, TWIST_STAMPED = 'geometry_msgs/msg/Twist', 'geometry_msgs/msg/TwistStamped'
_HEADED = (JOINT_STATE, IMU, *POSE_TYPES[:4], TWIST_STAMPED, 'sensor_msgs/msg/LaserScan',
           'sensor_msgs/msg/MagneticField', 'sensor_msgs/msg/BatteryState')
BASE_FRAMES = ('base_link', 'base_footprint', 'base')


@dataclass(slots=True, eq=False)
class Series:
    """One topic: log times (N,), header stamps (N,) where it has any, numbers by name (N, ...).

    ``names``: joint names of a JointState; ``rejected``: messages that could not be read.
    """

    channel: Channel
    log_ns: IntArray
    stamp_ns: IntArray
    stamped: bool
    values: dict[str, Any] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    rejected: list[str] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.log_ns)

    def seconds(self, origin_ns: int) -> FloatArray:
        """Stamps in seconds since ``origin_ns``."""
        found: FloatArray = (self.stamp_ns - origin_ns) / 1e9
        return found


@dataclass(slots=True, eq=False)
class Recording:
    """All topics of one recording by name, its loss and its time span."""

    paths: list[str]
    series: dict[str, Series]
    loss: Loss
    notes: list[str]
    origin_ns: int
    end_ns: int

    @property
    def seconds(self) -> float:
        """Time from the first to the last message, by log time."""
        return (self.end_ns - self.origin_ns) / 1e9

    def find(self, name: str | None, types: tuple[str, ...] = ()) -> Series | None:
        """The topic of that name (leading slash or not) and one of the types; None if absent."""
        if name is None:
            return None
        for topic, series in self.series.items():
            if topic.lstrip('/') == name.lstrip('/') and (
                    not types or series.channel.type in types):
                return series
        return None

    def of_type(self, *types: str) -> list[Series]:
        """All topics of the types, in the order of their names."""
        return [s for _, s in sorted(self.series.items()) if s.channel.type in types]


def load(paths: str | list[str], joints: tuple[str, ...] = (),
         step: Callable[[float], None] | None = None) -> Recording:
    """Read a recording as a whole; ``joints`` choose the columns of JointState topics.

    Raises BagError where it cannot be read.
    """
    with Bag(paths) as bag:
        parts: dict[Channel, list[Series]] = {}
        names: dict[Channel, tuple[str, ...]] = {}
        origin, end = None, 0
        for block in bag.blocks():
            origin = int(block.log_ns[0]) if origin is None else min(origin, int(block.log_ns[0]))
            end = max(end, int(block.log_ns[-1]))
            for number, channel in enumerate(block.channels):
                rows = np.flatnonzero(block.channel == number)
                if len(rows):
                    parts.setdefault(channel, []).append(
                        _read(block, rows, channel, joints, names))
            if step is not None:
                step(bag.read_bytes / max(bag.piece_bytes, 1))
        series: dict[str, Series] = {}
        for channel, pieces in parts.items():
            whole = _joined(channel, pieces)
            if channel.topic not in series or len(whole) > len(series[channel.topic]):
                series[channel.topic] = whole
        return Recording(bag.paths, series, bag.loss, bag.notes, origin or 0, end)


def _read(block: Block, rows: IntArray, channel: Channel, joints: tuple[str, ...],
          names: dict[Channel, tuple[str, ...]]) -> Series:
    log = block.log_ns[rows]
    if channel.encoding != 'cdr':
        return Series(channel, log, log, False)
    kind = channel.type
    if kind == JOINT_STATE:
        chosen = names.setdefault(channel, _names(block, rows, joints))
        if chosen:
            found = wheel_readings(block, rows, chosen)
            return Series(channel, block.log_ns[found.row], found.stamp_ns, True, found.values,
                          chosen, found.rejected)
    elif kind == IMU:
        found = imu_readings(block, rows)
        return Series(channel, block.log_ns[found.row], found.stamp_ns, True, found.values,
                      rejected=found.rejected)
    elif kind in TICKS:
        try:
            count = multi_array_layout(block.payload(int(rows[0])), TICKS[kind]).count['data']
        except NoLayout:
            return Series(channel, log, log, False, rejected=['damaged'] * len(rows))
        found = tick_readings(block, rows, count, kind)
        return Series(channel, block.log_ns[found.row], found.stamp_ns, False, found.values,
                      rejected=found.rejected)
    elif kind in POSE_TYPES or kind in (TWIST, TWIST_STAMPED):
        return _decoded(block, rows, channel)
    if kind in _HEADED:
        stamps = header_stamps(block, rows)
        if stamps is not None:
            return Series(channel, log, stamps, True)
    return Series(channel, log, log, False)


def _names(block: Block, rows: IntArray, joints: tuple[str, ...]) -> tuple[str, ...]:
    if joints:
        return joints
    try:
        return tuple(dict.fromkeys(joint_state_layout(block.payload(int(rows[0]))).names))
    except NoLayout:
        return ()


def _decoded(block: Block, rows: IntArray, channel: Channel) -> Series:
    """Poses and twists: few enough to be read one by one."""
    log, stamps, numbers, frames, rejected = [], [], [], [], []
    for row in rows.tolist():
        try:
            msg = message(block.payload(row), channel.type)
            found = _numbers(msg, channel.type)
        except messages.MalformedMessage as error:
            rejected.append(str(error))
            continue
        for stamp, values, frame in found:
            log.append(int(block.log_ns[row]))
            stamps.append(log[-1] if stamp is None else stamp)
            numbers.append(values)
            frames.append(frame)
    grid = np.array(numbers, dtype=np.float64).reshape(len(numbers), 3)
    key = 'twist' if channel.type in (TWIST, TWIST_STAMPED) else 'pose'
    return Series(channel, np.array(log, dtype=np.int64), np.array(stamps, dtype=np.int64),
                  channel.type != TWIST, {key: grid, 'frame': np.array(frames, dtype=object)},
                  rejected=rejected)


def _numbers(msg: Any, kind: str) -> list[tuple[int | None, tuple[float, ...], str]]:
    if kind in (TWIST, TWIST_STAMPED):
        twist = msg.twist if kind == TWIST_STAMPED else msg
        stamp = messages.stamp_ns(msg.header.stamp) if kind == TWIST_STAMPED else None
        return [(stamp, (float(twist.linear.x), float(twist.linear.y), float(twist.angular.z)),
                 '')]
    if kind == TF:
        return [_transform(t) for t in msg.transforms
                if t.child_frame_id.lstrip('/') in BASE_FRAMES]
    if kind == 'geometry_msgs/msg/TransformStamped':
        return [_transform(msg)]
    pose = msg.pose if kind == 'geometry_msgs/msg/PoseStamped' else msg.pose.pose
    return [(messages.stamp_ns(msg.header.stamp),
             (float(pose.position.x), float(pose.position.y), messages.yaw_of(pose.orientation)),
             str(msg.header.frame_id))]


def _transform(item: Any) -> tuple[int, tuple[float, float, float], str]:
    move = item.transform
    return (messages.stamp_ns(item.header.stamp),
            (float(move.translation.x), float(move.translation.y),
             messages.yaw_of(move.rotation)), str(item.header.frame_id))


def _joined(channel: Channel, parts: list[Series]) -> Series:
    keys = {key for part in parts for key in part.values}
    full = [part for part in parts if keys <= set(part.values)] if keys else parts
    values = {key: np.concatenate([part.values[key] for part in full]) for key in keys
              if len({part.values[key].shape[1:] for part in full if len(part)}) <= 1
              or key == 'frame'}
    return Series(channel, np.concatenate([part.log_ns for part in full]),
                  np.concatenate([part.stamp_ns for part in full]), full[0].stamped, values,
                  full[0].names, [reason for part in parts for reason in part.rejected])


def unwrapped(yaw: FloatArray) -> FloatArray:
    """Yaw (N,) rad without jumps of a full turn; not-finite values are bridged."""
    good = np.isfinite(yaw)
    if not good.any():
        return np.zeros(len(yaw))
    filled = np.interp(np.arange(len(yaw)), np.flatnonzero(good), np.unwrap(yaw[good]))
    found: FloatArray = filled
    return found


def difference(first: float, second: float) -> float:
    """first - second, moved into [-pi, pi)."""
    return wrap_angle(math.remainder(first - second, 2.0 * math.pi))
