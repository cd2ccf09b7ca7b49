"""Record messages into a rosbag2 folder with one MCAP file, safe against a hard stop.

Messages are collected in chunks. :meth:`Recorder.flush` ends the chunk and waits until it is on
disk; called every ``record.flush_period``, a recorder that is killed loses what came after the
last flush and nothing else. :meth:`Recorder.close` adds summary and metadata.yaml.
"""

from __future__ import annotations

import fcntl
import functools
import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import yaml
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from mecanum_base.bag.bag_folder import FileCount, TopicCount, write_metadata
from mecanum_base.core.errors import BagError

QOS_KEY, HASH_KEY = 'offered_qos_profiles', 'topic_type_hash'
PROFILE = 'ros2'


class Recorder:
    """Writes one bag folder, which must not exist; raises BagError where that is impossible."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = pathlib.Path(folder)
        try:
            self.folder.mkdir(parents=True)
        except FileExistsError:
            raise BagError(f'{self.folder}: exists already and is not overwritten') from None
        except OSError as error:
            raise BagError(f'{self.folder}: cannot be made: {error.strerror}') from None
        self.path = self.folder / f'{self.folder.name}_0.mcap'
        self._stream = self.path.open('xb')
        fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)  # recover() keeps off
        self._writer: Any = Writer(self._stream, compression=CompressionType.ZSTD)
        self._writer.start(profile=PROFILE, library='mecanum_base')
        self._file = FileCount(self.path.name)
        self._channels: dict[int, TopicCount] = {}
        self._schemas: dict[str, int] = {}
        self.flush()

    @property
    def messages(self) -> int:
        """Number of messages written so far."""
        return self._file.messages

    def channel(self, topic: str, message_type: str,
                qos: Sequence[Mapping[str, Any]] = ()) -> int:
        """A new channel for ``topic``; BagError for a type that is not one of ROS 2 Jazzy's."""
        schema, type_hash = description(message_type)
        if message_type not in self._schemas:
            self._schemas[message_type] = self._writer.register_schema(
                message_type, 'ros2msg', schema.encode())
        metadata = {QOS_KEY: yaml.safe_dump([dict(q) for q in qos]) if qos else '',
                    HASH_KEY: type_hash}
        number: int = self._writer.register_channel(topic, 'cdr', self._schemas[message_type],
                                                    metadata)
        count = TopicCount(topic, message_type, type_hash, tuple(qos))
        self._file.topics.append(count)
        self._channels[number] = count
        return number

    def write(self, channel: int, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Add one serialized message (CDR)."""
        count = self._channels[channel]
        try:
            self._writer.add_message(channel, log_ns, data, publish_ns, count.messages)
        except OSError as error:
            raise BagError(f'{self.path}: cannot be written: {error.strerror}') from None
        self._file.count(count, log_ns)

    def flush(self) -> None:
        """End the chunk and wait until everything written so far is on disk."""
        try:
            self._writer.flush()
            os.fsync(self._stream.fileno())
        except OSError as error:
            raise BagError(f'{self.path}: cannot be written: {error.strerror}') from None

    def close(self) -> None:
        """Complete the file with its summary and write metadata.yaml; again: nothing."""
        if self._stream.closed:
            return
        try:
            self._writer.finish()
            self._stream.flush()
            os.fsync(self._stream.fileno())
            write_metadata(self.folder, [self._file])
        except OSError as error:
            raise BagError(f'{self.path}: cannot be completed: {error.strerror}') from None
        finally:
            self._stream.close()


@functools.cache
def description(message_type: str) -> tuple[str, str]:
    """(definition with all its parts, type hash) of a message type of ROS 2 Jazzy."""
    store = _store()
    if message_type not in store.types:
        raise BagError(f'{message_type}: is no message type of ROS 2 Jazzy')
    return store.generate_msgdef(message_type, ros_version=2)[0], store.hash_rihs01(message_type)


@functools.lru_cache(maxsize=1)
def _store() -> Any:
    return get_typestore(Stores.ROS2_JAZZY)
