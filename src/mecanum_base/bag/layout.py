"""Where the fields of a serialized message lie, found once for all messages of the same shape.

Messages of one publisher usually differ only in numbers: lengths and texts stay. The layout of the
first message is walked field by field (CDR, little-endian, alignment from byte 4 on); the bytes
that decide the layout (texts and lengths) are listed as ``fixed``. Every other message with the
same length and the same fixed bytes has its numbers in the same places.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

LITTLE_ENDIAN = 1  # second byte of the CDR header


class NoLayout(Exception):
    """The bytes do not hold a message of the expected type; the text is the reason."""


@dataclass(slots=True)
class Layout:
    """Byte offsets of fields by name, array lengths by name, texts, and the fixed spans."""

    offset: dict[str, int] = field(default_factory=dict)
    count: dict[str, int] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    fixed: list[tuple[int, int]] = field(default_factory=list)
    size: int = 0


class _Cursor:
    """Walks one message; every length it reads becomes part of the fixed bytes."""

    def __init__(self, data: bytes) -> None:
        if len(data) < 4 or data[1] != LITTLE_ENDIAN or data[0] != 0:
            raise NoLayout('not plain little-endian CDR')
        self.data, self.at = data, 4
        self.layout = Layout(fixed=[(0, 2)])

    def _align(self, size: int) -> None:
        self.at += -(self.at - 4) % size

    def skip(self, size: int, count: int, name: str = '') -> None:
        """``count`` numbers of ``size`` bytes, their place kept under ``name``."""
        if count:
            self._align(size)
        if name:
            self.layout.offset[name], self.layout.count[name] = self.at, count
        self.at += size * count
        if self.at > len(self.data):
            raise NoLayout('shorter than its type')

    def length(self) -> int:
        """A sequence or text length."""
        self._align(4)
        if self.at + 4 > len(self.data):
            raise NoLayout('shorter than its type')
        value: int = struct.unpack_from('<I', self.data, self.at)[0]
        self.layout.fixed.append((self.at, self.at + 4))
        self.at += 4
        if value > len(self.data):
            raise NoLayout('a length exceeds the message')
        return value

    def text(self) -> str:
        """A string; its bytes are fixed."""
        size = self.length()
        start, self.at = self.at, self.at + size
        if self.at > len(self.data):
            raise NoLayout('shorter than its type')
        if size:
            self.layout.fixed.append((start, self.at))
        return self.data[start:start + max(size - 1, 0)].decode('utf-8', 'replace')

    def header(self) -> None:
        """std_msgs/Header."""
        self.skip(4, 2, 'stamp')
        self.text()

    def done(self) -> Layout:
        """The finished layout; bytes left over beyond padding are an error."""
        if len(self.data) - self.at > 4:  # rclpy leaves up to 4 bytes behind an empty array
            raise NoLayout('longer than its type')
        self.layout.size = self.at
        return self.layout


def joint_state_layout(data: bytes) -> Layout:
    """Layout of a sensor_msgs/JointState: stamp, position, velocity; ``names`` are the joints."""
    cursor = _Cursor(data)
    cursor.header()
    count = cursor.length()
    cursor.layout.names = tuple(cursor.text() for _ in range(count))
    for name in ('position', 'velocity', 'effort'):
        cursor.skip(8, cursor.length(), name)
    return cursor.done()


def imu_layout(data: bytes) -> Layout:
    """Layout of a sensor_msgs/Imu: stamp, gyro, gyro_covariance, accel, accel_covariance."""
    cursor = _Cursor(data)
    cursor.header()
    cursor.skip(8, 4, 'orientation')
    cursor.skip(8, 9, 'orientation_covariance')
    cursor.skip(8, 3, 'gyro')
    cursor.skip(8, 9, 'gyro_covariance')
    cursor.skip(8, 3, 'accel')
    cursor.skip(8, 9, 'accel_covariance')
    return cursor.done()


def multi_array_layout(data: bytes, item_size: int) -> Layout:
    """Layout of a std_msgs multi array with items of ``item_size`` bytes: data."""
    cursor = _Cursor(data)
    for _ in range(cursor.length()):
        cursor.text()
        cursor.skip(4, 2)
    cursor.skip(4, 1)
    cursor.skip(item_size, cursor.length(), 'data')
    return cursor.done()


def odometry_layout(data: bytes) -> Layout:
    """Layout of a nav_msgs/Odometry: stamp, pose (7), pose_covariance, twist (6)."""
    cursor = _Cursor(data)
    cursor.header()
    cursor.text()
    cursor.skip(8, 7, 'pose')
    cursor.skip(8, 36, 'pose_covariance')
    cursor.skip(8, 6, 'twist')
    cursor.skip(8, 36, 'twist_covariance')
    return cursor.done()
