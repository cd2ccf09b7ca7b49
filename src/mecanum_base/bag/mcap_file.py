"""Find every usable piece of an MCAP file, whole, cut or damaged.

The file is walked record by record; only heads are read. Where a record cannot be right, the walk
looks for the next chunk and goes on there; what lies between is stated as lost. The summary at
the end of a file is not needed; only its count of messages is held against what was read.
"""

from __future__ import annotations

import functools
import os
import re

import numpy as np

from mecanum_base.bag.block import NANOSECONDS, Block, Loss
from mecanum_base.bag.mcap_records import (
    CHANNEL,
    CHUNK,
    DATA_END,
    FOOTER,
    HEAD,
    MAGIC,
    MESSAGE,
    PRIVATE,
    SCHEMA,
    STATISTICS,
    ChunkHeader,
    Tables,
    block_of_records,
    has_shape,
)
from mecanum_base.bag.piece import DamagedPiece, Piece, Source
from mecanum_base.core.errors import BagError

_WINDOW = 1 << 16
_SEARCH = 1 << 22
_RUN = 1 << 20  # bytes of unchunked records loaded as one piece
_LIKELY_CHUNK = re.compile(  # opcode, length, start, end, size, checksum, name of the compression
    rb'\x06(?=.{36}(?:\x00\x00\x00\x00|\x03\x00\x00\x00lz4|\x04\x00\x00\x00zstd))', re.DOTALL)


def open_mcap(path: str) -> Source:
    """The pieces of an MCAP file; BagError where it is none or holds no readable piece at all."""
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, 'O_BINARY', 0))
    except OSError as error:
        raise BagError(f'{path}: cannot be read: {error.strerror}') from None
    try:
        walk = _Walk(handle, os.fstat(handle).st_size)
        head = walk.bytes_at(0, len(MAGIC))
        if head != MAGIC:
            reason = 'is empty' if not walk.size else 'is no MCAP file (wrong first bytes)'
            raise BagError(f'{path}: {reason}')
        walk.run()
    except BaseException:
        os.close(handle)
        raise
    return Source(path, walk.size, tuple(walk.pieces), walk.loss,
                  functools.partial(os.close, handle), walk.stated)


class _Walk:
    """Walks the records of one open file and collects its pieces."""

    def __init__(self, handle: int, size: int) -> None:
        self.handle, self.size = handle, size
        self.tables, self.loss = Tables(), Loss()
        self.pieces: list[Piece] = []
        self._cache, self._cache_at = b'', 0
        self._run_start: int | None = None
        self._run_times: list[int] = []
        self.stated: int | None = None
        self._chunked = False
        self._data_end: int | None = None

    def bytes_at(self, at: int, count: int) -> bytes:
        """Up to ``count`` bytes from position ``at``."""
        start = at - self._cache_at
        if start < 0 or start + count > len(self._cache):
            self._cache, self._cache_at = os.pread(self.handle, max(count, _WINDOW), at), at
            start = 0
        return self._cache[start:start + count]

    def run(self) -> None:
        """Walk to the end of the file."""
        at, before = len(MAGIC), len(MAGIC)
        while at < self.size:
            head = self.bytes_at(at, 9)
            opcode, length = HEAD.unpack(head) if len(head) == 9 else (0, 0)
            end = at + 9 + length
            if opcode == FOOTER and length == 20 and end + len(MAGIC) >= self.size:
                self._close_run(at)
                if int.from_bytes(self.bytes_at(at + 9, 8), 'little') not in (0, self._data_end):
                    self.loss.add('the summary is not where the end of the file says: bytes are '
                                  'missing or were added', 0, None)
                return
            if not self._accept(opcode, at, length, end):
                self._close_run(at)
                found = self._resume(at, before)
                if found is None:
                    return
                at = before = found
                continue
            before, at = at, end
        self._close_run(self.size)
        self.loss.add('the file has no end mark: its recorder was stopped hard', 0, None)

    def _accept(self, opcode: int, at: int, length: int, end: int) -> bool:
        if opcode in (0, FOOTER) or 15 < opcode < PRIVATE or end > self.size:
            return False
        if opcode >= PRIVATE:
            self.loss.add(f'a record of an unknown kind at {at} was skipped', 9 + length, None)
        elif not has_shape(opcode, length, self.bytes_at(at + 9, min(length, 64))):
            return False  # damage that looks like a harmless record would hide what it covers
        if opcode == CHUNK:
            return self._chunk(at, length)
        if opcode in (SCHEMA, CHANNEL):
            try:
                if length > _SEARCH:
                    return False
                self.tables.add(opcode, self.bytes_at(at + 9, length))
            except DamagedPiece:
                return False
        elif opcode == DATA_END:
            self._data_end = end
        elif opcode == STATISTICS:
            self.stated = int.from_bytes(self.bytes_at(at + 9, 8), 'little')
        elif opcode == MESSAGE:
            if length < 22 or self._chunked:  # writers use chunks for all messages or for none
                return False
            if self._run_start is None:
                self._run_start = at
            self._run_times.append(int.from_bytes(self.bytes_at(at + 15, 8), 'little'))
        if self._run_start is not None and (
                opcode not in (SCHEMA, CHANNEL, MESSAGE) or end - self._run_start > _RUN):
            self._close_run(end if opcode in (SCHEMA, CHANNEL, MESSAGE) else at)
        return True

    def _chunk(self, at: int, length: int) -> bool:
        header = ChunkHeader.read(self.bytes_at(at + 9, min(length, 80)))
        if header is None or header.head_size + header.stored_size != length:
            return False
        self._close_run(at)
        self._chunked = True
        load = functools.partial(self._load_chunk, header, at + 9 + header.head_size)
        self.pieces.append(Piece(header.start_ns, header.end_ns, at, 9 + length, load))
        return True

    def _load_chunk(self, header: ChunkHeader, at: int) -> Block:
        stored = os.pread(self.handle, header.stored_size, at)
        return block_of_records(header.inflate(stored), self.tables)

    def _close_run(self, end: int) -> None:
        if self._run_start is not None:
            start = self._run_start
            load = functools.partial(self._load_run, start, end - start)
            times = np.array(self._run_times, dtype=np.uint64)
            self.pieces.append(Piece(int(times.min()), int(times.max()), start, end - start, load))
        self._run_start, self._run_times = None, []

    def _load_run(self, at: int, count: int) -> Block:
        return block_of_records(os.pread(self.handle, count, at), self.tables)

    def _resume(self, at: int, before: int) -> int | None:
        """Position of the next chunk behind damage at ``at``; None at the end. States the loss."""
        position = min(before, at) + 1
        while position < self.size:
            text = os.pread(self.handle, _SEARCH, position)
            for match in _LIKELY_CHUNK.finditer(text):
                found = position + match.start()
                if found > before and self._is_chunk(found):
                    header = ChunkHeader.read(self.bytes_at(found + 9, 80))
                    assert header is not None
                    seconds = ((header.start_ns - self.pieces[-1].end_ns) / NANOSECONDS
                               if self.pieces else None)
                    self.loss.add(f'damaged bytes at {at}', found - at, seconds)
                    return found
            if len(text) < _SEARCH:
                break
            position += _SEARCH - 64
        self._state_cut(at)
        return None

    def _is_chunk(self, at: int) -> bool:
        opcode, length = HEAD.unpack(self.bytes_at(at, 9).ljust(9, b'\0'))
        header = ChunkHeader.read(self.bytes_at(at + 9, 80))
        return (opcode == CHUNK and at + 9 + length <= self.size and header is not None
                and header.head_size + header.stored_size == length)

    def _state_cut(self, at: int) -> None:
        head = self.bytes_at(at, 9)
        seconds = None
        if len(head) == 9 and head[0] == CHUNK:
            header = ChunkHeader.read(self.bytes_at(at + 9, 80))
            if header is not None and self.pieces and header.end_ns >= header.start_ns:
                seconds = (header.end_ns - min(self.pieces[-1].end_ns, header.start_ns)) \
                    / NANOSECONDS
        self.loss.add(f'the file is cut or damaged from byte {at} on', self.size - at, seconds)
