"""Transforms on /tf and /tf_static, with tf2_msgs or without it.

Where ``tf2_msgs`` is importable (every ROS installation) it is used. The wheels on PyPI have none:
there :mod:`mecanum_base.ros.tf_message` derives a message class of the same name and type hash,
which a compiled tf2_msgs understands. :attr:`Transforms.way` says in words which one is in use.
Received transforms come as the bytes of the message (CDR), so that both ways share one reader.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mecanum_base.core.errors import MecanumBaseError
from mecanum_base.ros.tf_message import TransformsUnavailable, derived_tf_message

_PLAIN_CDR = (b'\x00\x01', b'\x00\x00')  # little endian, big endian


@dataclass(frozen=True, slots=True)
class Transform:
    """One transform as received: names, translation [m] and rotation (x, y, z, w)."""

    stamp_ns: int
    parent: str
    child: str
    xyz: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]


class MalformedTransform(MecanumBaseError):
    """Bytes that are no TFMessage."""


class Transforms:
    """The way transforms are sent and received here; ``available`` is False if there is none."""

    def __init__(self) -> None:
        self.native = True
        self.message: Any = None
        try:
            from tf2_msgs.msg import TFMessage
            self.message, self.way = TFMessage, 'sent as tf2_msgs/TFMessage'
        except ImportError:
            self.native = False
            try:
                self.message = derived_tf_message()
                self.way = ('sent as tf2_msgs/TFMessage, derived from geometry_msgs '
                            '(tf2_msgs is not installed)')
            except TransformsUnavailable as error:
                self.way = f'no transform is sent: {error}'

    @property
    def available(self) -> bool:
        """Whether transforms can be sent and received at all."""
        return self.message is not None

    def sender(self, node: Any, topic: str, qos: Any) -> Callable[[Any], None]:
        """A function that publishes one geometry_msgs/TransformStamped on ``topic``."""
        if not self.available:
            return lambda transform: None
        publisher = node.create_publisher(self.message, topic, qos)
        if self.native:
            return lambda transform: publisher.publish(self.message(transforms=[transform]))
        return lambda transform: publisher.publish(encode([transform]))

    def listen(self, node: Any, topic: str, qos: Any,
               callback: Callable[[list[Transform]], None]) -> Any:
        """Subscribe to a transform topic; None where transforms are not available.

        A message that cannot be read is skipped, with a warning in the log.
        """
        if not self.available:
            return None

        def receive(raw: Any) -> None:
            try:
                transforms = decode(bytes(raw))
            except MalformedTransform as error:
                node.get_logger().warning(f'{topic}: {error}', throttle_duration_sec=10.0)
                return
            callback(transforms)
        return node.create_subscription(self.message, topic, receive, qos, raw=True)


def encode(transforms: list[Any]) -> bytes:
    """CDR bytes (little endian) of a TFMessage holding geometry_msgs/TransformStamped."""
    out = bytearray(struct.pack('<I', len(transforms)))
    for item in transforms:
        stamp = item.header.stamp
        _pad(out, 4)
        out += struct.pack('<iI', stamp.sec, stamp.nanosec)
        for name in (item.header.frame_id, item.child_frame_id):
            text = name.encode() + b'\0'
            _pad(out, 4)
            out += struct.pack('<I', len(text)) + text
        _pad(out, 8)
        move, turn = item.transform.translation, item.transform.rotation
        out += struct.pack('<7d', move.x, move.y, move.z, turn.x, turn.y, turn.z, turn.w)
    return b'\0\1\0\0' + bytes(out)


def _pad(out: bytearray, size: int) -> None:
    out.extend(b'\0' * (-len(out) % size))


def decode(raw: bytes) -> list[Transform]:
    """Transforms in the CDR bytes of a TFMessage; raises MalformedTransform."""
    if raw[:2] not in _PLAIN_CDR:
        raise MalformedTransform('not plain CDR')
    order = '<' if raw[:2] == _PLAIN_CDR[0] else '>'
    reader = _Reader(raw[4:], order)
    try:
        return [_transform(reader) for _ in range(reader.take('I', 4)[0])]
    except (struct.error, UnicodeDecodeError, ValueError) as error:
        raise MalformedTransform(f'not a TFMessage: {error}') from None


class _Reader:
    """Walks through aligned CDR values."""

    def __init__(self, buffer: bytes, order: str) -> None:
        self._buffer, self._order, self._at = buffer, order, 0

    def take(self, kinds: str, align: int) -> tuple[Any, ...]:
        self._at += -self._at % align
        values = struct.unpack_from(self._order + kinds, self._buffer, self._at)
        self._at += struct.calcsize(self._order + kinds)
        return values

    def text(self) -> str:
        size = self.take('I', 4)[0]
        raw = self._buffer[self._at:self._at + size]
        if size < 1 or len(raw) < size:
            raise ValueError('text runs past the end')
        self._at += size
        return raw[:-1].decode()


def _transform(reader: _Reader) -> Transform:
    seconds, nanoseconds = reader.take('iI', 4)
    parent, child = reader.text(), reader.text()
    x, y, z, qx, qy, qz, qw = reader.take('7d', 8)
    return Transform(seconds * 1_000_000_000 + nanoseconds, parent, child, (x, y, z),
                     (qx, qy, qz, qw))
