"""Read recordings: MCAP files, rosbag2 folders (MCAP or sqlite3), several files as one.

Messages come in blocks, in the order of their log time over all files together. Only as much is
in memory as overlaps in time, so memory does not grow with the length of a recording. A damaged
or cut file gives every complete chunk; what is lost is stated in :attr:`Bag.loss`.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from types import TracebackType
from typing import BinaryIO

import numpy as np

from mecanum_base.bag.block import NANOSECONDS, Block, Channel, Loss, joined
from mecanum_base.bag.folder import BagFiles, files_of
from mecanum_base.bag.mcap_file import open_mcap
from mecanum_base.bag.piece import DamagedPiece, Piece, Source
from mecanum_base.bag.sqlite_file import open_sqlite
from mecanum_base.core.errors import BagError


class Bag:
    """One recording, opened for reading; a context manager."""

    def __init__(self, paths: str | os.PathLike[str] | Sequence[str | os.PathLike[str]]) -> None:
        """Open ``paths`` as one recording; BagError says which file cannot be used and why."""
        self.paths = [os.fspath(paths)] if isinstance(paths, (str, os.PathLike)) else [
            os.fspath(p) for p in paths]
        self.loss = Loss()
        self.notes: list[str] = []
        self.counts: dict[Channel, int] = {}
        self.read_bytes = 0
        self._sources: list[Source] = []
        self._closing = contextlib.ExitStack()
        try:
            for path in self.paths:
                self._open(files_of(path))
        except BaseException:
            self.close()
            raise
        self._pieces = sorted(
            ((piece, source) for source in self._sources for piece in source.pieces),
            key=lambda item: (item[0].start_ns, item[0].end_ns))
        if not self._pieces:
            reasons = f' ({self.loss.text()})' if self.loss else ''
            name = ', '.join(self.paths)
            self.close()
            raise BagError(f'{name}: holds no readable message{reasons}')

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return sum(source.size for source in self._sources)

    @property
    def piece_bytes(self) -> int:
        """Bytes of all pieces: what :attr:`read_bytes` reaches at the end."""
        return sum(piece.size for piece, _ in self._pieces)

    @property
    def start_ns(self) -> int:
        """Smallest log time, as the index of the files states it."""
        return min(piece.start_ns for piece, _ in self._pieces)

    @property
    def end_ns(self) -> int:
        """Largest log time, as the index of the files states it."""
        return max(piece.end_ns for piece, _ in self._pieces)

    def blocks(self, wanted: Callable[[Channel], bool] = lambda channel: True) -> Iterator[Block]:
        """Blocks in log order with the messages of the wanted channels; may be called again."""
        self.counts, self.read_bytes = {}, 0
        damaged = Loss()
        earlier = self._index_loss
        held: list[Block] = []
        for index, (piece, source) in enumerate(self._pieces):
            block = self._loaded(piece, source, damaged)
            self.loss = earlier.plus(damaged)
            self.read_bytes += piece.size
            if block is not None:
                held.append(self._chosen(block, wanted))
            following = (self._pieces[index + 1][0].start_ns if index + 1 < len(self._pieces)
                         else None)
            whole = joined([b for b in held if len(b)]) if any(len(b) for b in held) else None
            held = []
            if whole is None:
                continue
            if following is not None and int(whole.log_ns[-1]) >= following:
                ready = int(np.searchsorted(whole.log_ns, following, side='left'))
                held = [whole.take(np.arange(ready, len(whole)))]
                whole = whole.take(np.arange(ready))
            if len(whole):
                yield whole
        self._compare_counts()

    def close(self) -> None:
        """Close all files."""
        for source in self._sources:
            source.close()
        self._sources = []
        self._closing.close()

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    def _open(self, files: BagFiles) -> None:
        self._packed = files.packed_messages
        self.notes += files.notes
        for name in files.missing:
            self.loss.add(f'{name}, named in metadata.yaml, is missing', 0, None)
        failures: list[str] = []
        for path in files.paths:
            try:
                source = self._source(path)
            except BagError as error:
                if len(files.paths) == 1:
                    raise
                failures.append(str(error))
                self.loss.add(str(error), _size(path), None)
                continue
            self._sources.append(source)
            self.loss = self.loss.plus(source.loss)
        if failures and len(failures) == len(files.paths):
            raise BagError('; '.join(failures))
        self._index_loss = self.loss

    def _source(self, path: str) -> Source:
        if path.endswith('.zstd'):
            path = self._unpacked(path)
        with open_or_fail(path) as file:
            sqlite = file.read(6) == b'SQLite'
        return open_sqlite(path) if sqlite else open_mcap(path)

    def _unpacked(self, path: str) -> str:
        import zstandard
        folder = self._closing.enter_context(tempfile.TemporaryDirectory())
        target = os.path.join(folder, os.path.basename(path)[:-len('.zstd')])
        with open_or_fail(path) as packed, open(target, 'wb') as plain:
            try:
                with zstandard.ZstdDecompressor().stream_reader(packed) as stream:
                    shutil.copyfileobj(stream, plain, 1 << 20)
            except zstandard.ZstdError as error:
                self.loss.add(f'{os.path.basename(path)} does not unpack to its end (zstd: '
                              f'{error})', 0, None)
        return target

    def _compare_counts(self) -> None:
        """State a loss that left no other trace."""
        stated = [source.stated for source in self._sources]
        total = sum(self.counts.values())
        wanted = sum(count or 0 for count in stated)
        if None not in stated and total < wanted and not self.loss:
            self.loss = self.loss.plus(Loss())
            self.loss.add(f'{total} messages could be read of {wanted} that were written', 0, None)

    def _loaded(self, piece: Piece, source: Source, damaged: Loss) -> Block | None:
        try:
            block = piece.load()
            return _unpack_messages(block) if self._packed and len(block) else block
        except DamagedPiece as error:
            span = (piece.end_ns - piece.start_ns) / NANOSECONDS
            where = os.path.basename(source.name)
            damaged.add(f'{where}, byte {piece.position}: {error}', piece.size,
                        span if span >= 0 else None)
            return None

    def _chosen(self, block: Block, wanted: Callable[[Channel], bool]) -> Block:
        numbers = np.bincount(block.channel, minlength=len(block.channels))
        keep = np.zeros(max(len(block.channels), 1), dtype=bool)
        for index, channel in enumerate(block.channels):
            self.counts[channel] = self.counts.get(channel, 0) + int(numbers[index])
            keep[index] = wanted(channel)
        if len(block) == 0 or keep.all():
            return block
        return block.take(np.flatnonzero(keep[block.channel]))


def open_or_fail(path: str) -> BinaryIO:
    """The file opened for reading bytes; BagError in one line where it cannot be."""
    try:
        return open(path, 'rb')
    except OSError as error:
        raise BagError(f'{path}: cannot be read: {error.strerror}') from None


def _size(path: str) -> int:
    try:
        return os.path.getsize(path)
    except OSError:
        return 0


def _unpack_messages(block: Block) -> Block:
    """The block with each payload unpacked (rosbag2 compression mode MESSAGE)."""
    import zstandard
    unpacker = zstandard.ZstdDecompressor()
    try:
        payloads = [unpacker.decompress(block.payload(i), max_output_size=1 << 26)
                    for i in range(len(block))]
    except zstandard.ZstdError as error:
        raise DamagedPiece(f'a packed message does not unpack (zstd: {error})') from None
    length = np.array([len(p) for p in payloads], dtype=np.int64)
    return Block(b''.join(payloads), np.cumsum(length) - length, length, block.log_ns,
                 block.channel, block.channels)
