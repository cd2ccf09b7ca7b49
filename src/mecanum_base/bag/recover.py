"""Complete a recording whose recorder was killed, so that rosbag2 can open it.

Every complete chunk is copied, record by record, into a new file that gets a summary; then that
file takes the place of the old one, and metadata.yaml is written. Messages keep their bytes, log
times, publish times and sequence numbers.
"""

from __future__ import annotations

import fcntl
import io
import os
import pathlib
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import yaml
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Chunk, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import Writer

from mecanum_base.bag.bag_folder import METADATA, FileCount, TopicCount, write_metadata
from mecanum_base.bag.mcap_file import open_mcap
from mecanum_base.bag.piece import DamagedPiece, Source
from mecanum_base.bag.recorder import HASH_KEY, PROFILE, QOS_KEY
from mecanum_base.core.errors import BagError

_MAGIC_SIZE = 8


@dataclass(frozen=True, slots=True)
class Recovery:
    """What was done: files of the bag, messages they hold, and what was lost in words."""

    files: tuple[FileCount, ...]
    losses: tuple[str, ...]
    metadata: pathlib.Path | None

    @property
    def messages(self) -> int:
        """Messages in the completed bag."""
        return sum(file.messages for file in self.files)


def recover(bag: str | os.PathLike[str]) -> Recovery:
    """Complete one MCAP file or every MCAP file of a bag folder; BagError if there is none.

    metadata.yaml is written beside the files; for a single file only if it is alone in its
    folder, because it would hide the others.
    """
    path = pathlib.Path(bag)
    paths = sorted(path.glob('*.mcap')) if path.is_dir() else [path]
    if not paths:
        raise BagError(f'{path}: holds no .mcap file')
    files: list[FileCount] = []
    losses: list[str] = []
    for item in paths:
        count, lost = _complete(item)
        files.append(count)
        losses.extend(f'{item.name}: {text}' for text in lost)
    folder = paths[0].parent
    alone = {item.name for item in folder.glob('*.mcap')} == {item.name for item in paths}
    metadata = write_metadata(folder, files) if alone else None
    if metadata is None:
        losses.append(f'{METADATA} was not written: {folder} holds other recordings too')
    return Recovery(tuple(files), tuple(losses), metadata)


def _complete(path: pathlib.Path) -> tuple[FileCount, list[str]]:
    """Rewrite the file with a summary; returns what it holds and what was lost."""
    source = open_mcap(str(path))
    lost: list[str] = []
    part = path.with_name(path.name + '.part')
    try:
        with path.open('rb') as stream, part.open('wb') as output:
            _require_unused(stream, path)
            copy = _Copy(output, path.name)
            for record in _records(stream, source, lost):
                copy.add(record)
            copy.writer.finish()
            output.flush()
            os.fsync(output.fileno())
        part.replace(path)
    except OSError as error:
        raise BagError(f'{path}: cannot be completed: {error.strerror or error}') from None
    finally:
        source.close()
        part.unlink(missing_ok=True)
    return copy.file, lost + list(source.loss.reasons)


def _require_unused(stream: Any, path: pathlib.Path) -> None:
    try:
        fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        raise BagError(f'{path}: is being recorded at this moment') from None


def _records(stream: Any, source: Source, lost: list[str]) -> Iterator[Any]:
    """Records of the complete pieces of the file and of what stands between them."""
    at = _MAGIC_SIZE
    for piece in source.pieces:
        yield from _between(stream, at, piece.position - at)
        stream.seek(piece.position)
        try:
            piece.load()
        except DamagedPiece as error:
            lost.append(f'{piece.size} bytes at {piece.position}: {error}')
        else:
            yield from _read(stream.read(piece.size))
        at = piece.position + piece.size
    yield from _between(stream, at, source.size - at)


def _between(stream: Any, at: int, size: int) -> Iterator[Any]:
    """Schemas, channels, attachments and metadata outside chunks, up to the first damage."""
    stream.seek(at)
    try:
        for record in _read(stream.read(max(size, 0))):
            if not isinstance(record, Message):
                yield record
    except (McapError, ValueError, struct.error):  # the end of what was written
        return


def _read(data: bytes) -> Iterator[Any]:
    stream = io.BytesIO(data)
    reader = StreamReader(stream, skip_magic=True, emit_chunks=True,
                          record_size_limit=len(data)).records
    while stream.tell() < len(data) and (record := next(reader, None)) is not None:
        yield from breakup_chunk(record) if isinstance(record, Chunk) else (record,)


class _Copy:
    """Writes records into a new file, giving schemas and channels new numbers."""

    def __init__(self, output: Any, name: str) -> None:
        self.writer: Any = Writer(output)
        self.writer.start(profile=PROFILE, library='mecanum_base')
        self.file = FileCount(name)
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._schema_of: dict[int, tuple[int, str]] = {}
        self._channels: dict[tuple[Any, ...], tuple[int, TopicCount]] = {}
        self._channel_of: dict[int, tuple[int, TopicCount]] = {}

    def add(self, record: Any) -> None:
        """Copy one record; those that only index others are made anew by the writer."""
        if isinstance(record, Schema):
            key = (record.name, record.encoding, bytes(record.data))
            if key not in self._schemas:
                self._schemas[key] = self.writer.register_schema(*key)
            self._schema_of[record.id] = self._schemas[key], record.name
        elif isinstance(record, Channel):
            self._channel(record)
        elif isinstance(record, Message) and record.channel_id in self._channel_of:
            number, topic = self._channel_of[record.channel_id]
            self.writer.add_message(number, record.log_time, record.data, record.publish_time,
                                    record.sequence)
            self.file.count(topic, record.log_time)
        elif isinstance(record, Metadata):
            self.writer.add_metadata(record.name, record.metadata)
        elif isinstance(record, Attachment):
            self.writer.add_attachment(record.create_time, record.log_time, record.name,
                                       record.media_type, record.data)

    def _channel(self, record: Channel) -> None:
        schema, type_name = self._schema_of.get(record.schema_id, (0, ''))
        key = (record.topic, record.message_encoding, schema,
               tuple(sorted(record.metadata.items())))
        if key not in self._channels:
            number = self.writer.register_channel(record.topic, record.message_encoding, schema,
                                                  record.metadata)
            topic = TopicCount(record.topic, type_name, record.metadata.get(HASH_KEY, ''),
                               _qos(record.metadata.get(QOS_KEY, '')))
            self.file.topics.append(topic)
            self._channels[key] = number, topic
        self._channel_of[record.id] = self._channels[key]


def _qos(text: str) -> tuple[Any, ...]:
    try:
        found = yaml.safe_load(text) if text else []
    except yaml.YAMLError:
        return ()
    return tuple(found) if isinstance(found, list) else ()
