"""Records of an MCAP file: headers, chunks, and all messages of a stretch of bytes at once.

The layout follows the MCAP specification (opcode, length, content, little-endian). Reading with
numpy over a list of record positions is several times faster than one object per message.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mecanum_base.bag.block import Block, Channel
from mecanum_base.bag.piece import DamagedPiece

MAGIC = b'\x89MCAP0\r\n'
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS, DATA_END = 2, 3, 4, 5, 6, 11, 15
PRIVATE = 128  # opcodes from here on belong to whoever writes them
HEAD = struct.Struct('<BQ')
_CHUNK_HEAD = struct.Struct('<QQQII')
LARGEST_CHUNK = 1 << 30  # bytes; no known writer comes near, a damaged size does
COMPRESSIONS = ('', 'lz4', 'zstd')


def has_shape(opcode: int, length: int, content: bytes) -> bool:
    """Whether a record without messages has a length (and inner lengths) of its own kind.

    ``content`` are its first bytes, up to 64.
    """
    if opcode in _FIXED:
        return length == _FIXED[opcode]
    if opcode == _MESSAGE_INDEX:
        return len(content) >= 6 and struct.unpack_from('<I', content, 2)[0] == length - 6
    if opcode == STATISTICS:
        return len(content) >= 46 and struct.unpack_from('<I', content, 42)[0] == length - 46
    if opcode == _CHUNK_INDEX:
        return len(content) >= 36 and struct.unpack_from('<I', content, 32)[0] + 64 <= length
    if opcode == _ATTACHMENT:
        return len(content) >= 20 and struct.unpack_from('<I', content, 16)[0] + 36 <= length
    if opcode in (_HEADER, _METADATA, _METADATA_INDEX):
        at = 16 if opcode == _METADATA_INDEX else 0
        return (len(content) >= at + 4 and length < _LARGEST_TEXT
                and struct.unpack_from('<I', content, at)[0] + at + 4 <= length)
    return True


_HEADER, _MESSAGE_INDEX, _CHUNK_INDEX, _ATTACHMENT, _METADATA, _METADATA_INDEX = 1, 7, 8, 9, 12, 13
_FIXED = {FOOTER: 20, DATA_END: 4, 14: 17}  # 14 = summary offset
_LARGEST_TEXT = 1 << 24


@dataclass(frozen=True, slots=True)
class ChunkHeader:
    """Head of a chunk record: spanned log times, sizes in bytes, checksum (0 = none)."""

    start_ns: int
    end_ns: int
    raw_size: int
    checksum: int
    compression: str
    stored_size: int
    head_size: int

    @classmethod
    def read(cls, content: bytes) -> ChunkHeader | None:
        """From the first bytes of the record's content; None where they cannot be one."""
        if len(content) < _CHUNK_HEAD.size + 8:
            return None
        start, end, raw, checksum, length = _CHUNK_HEAD.unpack_from(content)
        at = _CHUNK_HEAD.size + length
        if length > 32 or len(content) < at + 8:
            return None
        compression = content[_CHUNK_HEAD.size:at].decode('ascii', 'replace')
        if compression not in COMPRESSIONS:
            return None
        stored = int.from_bytes(content[at:at + 8], 'little')
        return cls(start, end, raw, checksum, compression, stored, at + 8)

    def inflate(self, stored: bytes) -> bytes:
        """The records inside; raises DamagedPiece for wrong sizes, checksums or streams."""
        if self.raw_size > LARGEST_CHUNK:
            raise DamagedPiece(f'a chunk claims {self.raw_size} bytes, more than any writer uses')
        data: bytes = _INFLATE[self.compression](stored, self.raw_size)
        if len(data) != self.raw_size:
            raise DamagedPiece('a chunk does not unpack to the size it states')
        if self.checksum and zlib.crc32(data) != self.checksum:
            raise DamagedPiece('a chunk fails its checksum')
        return data


def _zstd(stored: bytes, size: int) -> bytes:
    import zstandard
    try:
        stated = zstandard.frame_content_size(stored)
        if stated not in (-1, size):
            raise DamagedPiece('a chunk does not unpack to the size it states')
        data: bytes = zstandard.ZstdDecompressor().decompress(stored, max_output_size=size)
    except zstandard.ZstdError as error:
        raise DamagedPiece(f'a chunk does not unpack (zstd: {error})') from None
    return data


def _lz4(stored: bytes, size: int) -> bytes:
    import lz4.frame  # type: ignore[import-untyped]
    try:
        stated = lz4.frame.get_frame_info(stored)['content_size']
        if stated not in (0, size):
            raise DamagedPiece('a chunk does not unpack to the size it states')
        unpacker = lz4.frame.LZ4FrameDecompressor()
        data: bytes = unpacker.decompress(stored, max_length=size + 1)
    except (RuntimeError, EOFError) as error:
        raise DamagedPiece(f'a chunk does not unpack (lz4: {error})') from None
    return data


_INFLATE: dict[str, Any] = {'': lambda stored, size: stored, 'zstd': _zstd, 'lz4': _lz4}


@dataclass(slots=True)
class Tables:
    """Schemas and channels of one file, filled while its records are read."""

    schemas: dict[int, str] = field(default_factory=dict)
    channels: dict[int, tuple[int, str, str]] = field(default_factory=dict)

    def add(self, opcode: int, content: bytes) -> None:
        """Take over a schema or channel record; raises DamagedPiece where it is cut."""
        try:
            if opcode == SCHEMA:
                number, = struct.unpack_from('<H', content)
                self.schemas[number] = _text(content, 2)[0]
            elif opcode == CHANNEL:
                number, schema = struct.unpack_from('<HH', content)
                topic, at = _text(content, 4)
                self.channels[number] = (schema, topic, _text(content, at)[0])
        except (struct.error, UnicodeDecodeError):
            raise DamagedPiece('a schema or channel record is damaged') from None

    def channel(self, number: int) -> Channel | None:
        """The channel of that number; None while it is unknown."""
        if number not in self.channels:
            return None
        schema, topic, encoding = self.channels[number]
        return Channel(topic, self.schemas.get(schema, ''), encoding)

    def all(self) -> tuple[Channel, ...]:
        """Every channel seen so far."""
        return tuple(c for c in map(self.channel, self.channels) if c is not None)


def _text(content: bytes, at: int) -> tuple[str, int]:
    length, = struct.unpack_from('<I', content, at)
    end = at + 4 + length
    if end > len(content):
        raise struct.error
    return printable(content[at + 4:end].decode()), end


def printable(text: str) -> str:
    """A name from a file without control characters, which have no place on a terminal."""
    return text if text.isprintable() else ''.join(c if c.isprintable() else '?' for c in text)


def block_of_records(data: bytes, tables: Tables) -> Block:
    """All messages in a run of records, sorted by log time (stable).

    Raises DamagedPiece where a record reaches past the end or a message names no known channel.
    """
    found: list[int] = []
    unpack, add, end, at = HEAD.unpack_from, found.append, len(data), 0
    while at + 9 <= end:
        opcode, length = unpack(data, at)
        if opcode == MESSAGE:
            add(at)
        elif opcode in (SCHEMA, CHANNEL):
            tables.add(opcode, data[at + 9:at + 9 + length])
        at += 9 + length
    if at != end:
        raise DamagedPiece('a record reaches past the end of its chunk')
    if not found:
        empty = np.zeros(0, dtype=np.int64)
        return Block(data, empty, empty, empty, empty, ())
    position = np.array(found, dtype=np.int64)
    if len(data) < int(position[-1]) + 31:
        raise DamagedPiece('a message record is too short')
    head = rows_at(data, position, _MESSAGE_HEAD.itemsize).view(_MESSAGE_HEAD).reshape(-1)
    length = head['length'].astype(np.int64) - 22
    if np.any(length < 0):
        raise DamagedPiece('a message record is too short')
    numbers, channel = np.unique(head['channel'], return_inverse=True)
    channels = [tables.channel(int(number)) for number in numbers]
    if None in channels:
        raise DamagedPiece('a message names a channel that is not described')
    block = Block(data, position + 31, length, head['log'].astype(np.int64),
                  channel.astype(np.int64), tuple(c for c in channels if c is not None))
    if np.all(block.log_ns[1:] >= block.log_ns[:-1]):
        return block
    return block.take(np.argsort(block.log_ns, kind='stable'))


_MESSAGE_HEAD = np.dtype([('opcode', 'u1'), ('length', '<u8'), ('channel', '<u2'),
                          ('sequence', '<u4'), ('log', '<u8'), ('publish', '<u8')])


def rows_at(data: bytes, offset: Any, width: int) -> Any:
    """``width`` bytes at each offset (N,) as an array (N, width) uint8; offsets must fit."""
    if len(offset) == 0 or width == 0:
        return np.zeros((len(offset), width), dtype=np.uint8)
    every = np.ndarray(shape=(len(data) - width + 1,), dtype=np.dtype((np.void, width)),
                       buffer=data, strides=(1,))
    return every[offset].view(np.uint8).reshape(len(offset), width)
