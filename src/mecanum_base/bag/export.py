"""Exports of a replay: a bag with the new odometry beside the old topics, Parquet tables.

The bag is a rosbag2 folder (MCAP), to be opened in Foxglove or played by ``ros2 bag play``. The
new topics are /replayed/odom, /replayed/slip/wheels and /replayed/slip/probability, logged at
their stamps.
"""

from __future__ import annotations

import pathlib
from collections.abc import Iterator
from typing import Any

from mecanum_base import messages
from mecanum_base.bag.block import Channel
from mecanum_base.bag.encode import blank, encode
from mecanum_base.bag.reader import Bag
from mecanum_base.bag.recorder import Recorder
from mecanum_base.bag.replay import Sink
from mecanum_base.bag.track import FILES, SMOOTHED
from mecanum_base.core.errors import BagError
from mecanum_base.core.records import Estimate
from mecanum_base.robot import Robot

PREFIX = '/replayed/'
TYPES = {'odom': 'nav_msgs/msg/Odometry', 'slip/wheels': 'sensor_msgs/msg/JointState',
         'slip/probability': 'std_msgs/msg/Float64MultiArray'}


class BagExport:
    """A sink that writes every estimate to a new bag, and hands it on to another sink."""

    def __init__(self, folder: pathlib.Path, robot: Robot, other: Sink) -> None:
        """Make the bag folder; BagError where it exists already."""
        self._recorder = Recorder(folder)
        self._other, self._robot = other, robot
        self._channel = {name: self._recorder.channel(PREFIX + name, kind)
                         for name, kind in TYPES.items()}
        self._blank = {name: blank(kind) for name, kind in TYPES.items()}

    def write(self, estimate: Estimate) -> None:
        """Write one estimate."""
        frames, joints = self._robot.frames, self._robot.base.joint
        slip, stamp = estimate.slip, estimate.stamp_ns
        self._put('odom', stamp, messages.write_odometry(
            estimate, self._blank['odom'], frames.tf_frame_prefix + frames.odom_frame_id,
            frames.tf_frame_prefix + frames.base_frame_id))
        self._put('slip/wheels', stamp, messages.write_slip_wheels(
            stamp, slip.rate, slip.angle, self._blank['slip/wheels'], joints))
        self._put('slip/probability', stamp, messages.write_slip_probability(
            estimate, self._blank['slip/probability']))
        self._other.write(estimate)

    def close(self) -> None:
        """The replay is over; the bag stays open for the original topics."""
        self._other.close()

    def complete(self, paths: list[str]) -> tuple[str, ...]:
        """Copy the original topics and complete the bag; returns the topics left out."""
        left_out = []
        try:
            with Bag(paths) as bag:
                numbers: dict[Channel, int | None] = {}
                for block in bag.blocks():
                    for channel in block.channels:
                        if channel not in numbers:
                            numbers[channel] = self._original(channel)
                            if numbers[channel] is None:
                                left_out.append(f'{channel.topic} ({channel.type})')
                    for index in range(len(block)):
                        number = numbers[block.channels[int(block.channel[index])]]
                        if number is not None:
                            log = int(block.log_ns[index])
                            self._recorder.write(number, log, log, block.payload(index))
        finally:
            self._recorder.close()
        return tuple(left_out)

    def _original(self, channel: Channel) -> int | None:
        """Channel of an original topic; None for a type whose definition is not known here."""
        if channel.encoding != 'cdr' or channel.topic.startswith(PREFIX):
            return None
        try:
            return self._recorder.channel(channel.topic, channel.type)
        except BagError:
            return None

    def _put(self, name: str, stamp: int, msg: Any) -> None:
        self._recorder.write(self._channel[name], stamp, stamp, encode(msg))


def write_parquet(folder: pathlib.Path) -> tuple[pathlib.Path, ...]:
    """A Parquet table of each csv file of a replay, batch by batch."""
    return tuple(_parquet(folder / name) for name in (*FILES[1:], *SMOOTHED[1:]))


def _parquet(source: pathlib.Path) -> pathlib.Path:
    import pyarrow
    from pyarrow import csv, parquet
    target = source.with_suffix('.parquet')
    with csv.open_csv(source, convert_options=_exact(source)) as reader:
        batches: Iterator[Any] = iter(reader)
        with parquet.ParquetWriter(target, reader.schema) as writer:
            for batch in batches:
                writer.write_table(pyarrow.Table.from_batches([batch]))
    return target


def _exact(source: pathlib.Path) -> Any:
    """Column types: stamps as decimals with nine digits, so that no nanosecond is lost."""
    import pyarrow
    from pyarrow import csv
    with source.open(encoding='utf-8') as file:
        names = next(iter(_header(file.readline())))
    types = {name: pyarrow.float64() for name in names}
    types['stamp'] = pyarrow.decimal128(19, 9)
    if 'source' in types:
        types['source'] = pyarrow.string()
    return csv.ConvertOptions(column_types=types)


def _header(line: str) -> Iterator[list[str]]:
    import csv
    return csv.reader([line])
