"""Pieces of a rosbag2 file with sqlite3 storage (.db3): windows of log time."""

from __future__ import annotations

import functools
import os
import pathlib
import sqlite3

import numpy as np

from mecanum_base.bag.block import Block, Channel, Loss
from mecanum_base.bag.mcap_records import printable
from mecanum_base.bag.piece import DamagedPiece, Piece, Source
from mecanum_base.core.errors import BagError

_MAGIC = b'SQLite format 3\0'
_PER_PIECE = 8192
# damaged texts come back in the messages of sqlite3 itself
_UNREADABLE = (sqlite3.Error, UnicodeDecodeError, OverflowError, MemoryError)
_LARGEST = 1 << 30  # bytes of one window; a damaged length claims more


def open_sqlite(path: str) -> Source:
    """The pieces of a .db3 file; BagError where it is no rosbag2 database."""
    try:
        with open(path, 'rb') as file:
            head = file.read(len(_MAGIC))
        size = os.path.getsize(path)
    except OSError as error:
        raise BagError(f'{path}: cannot be read: {error.strerror}') from None
    if head != _MAGIC:
        raise BagError(f'{path}: is no sqlite3 bag (wrong first bytes)')
    base = sqlite3.connect(f'{pathlib.Path(path).resolve().as_uri()}?mode=ro&immutable=1',
                           uri=True, check_same_thread=False)  # one thread at a time
    base.text_factory = functools.partial(str, encoding='utf-8', errors='replace')
    try:
        rows = base.execute('SELECT id, name, type, serialization_format FROM topics').fetchall()
        low, high, count = base.execute(
            'SELECT min(timestamp), max(timestamp), count(*) FROM messages').fetchone()
    except _UNREADABLE as error:
        base.close()
        raise BagError(f'{path}: is no readable rosbag2 database: '
                       f'{printable(str(error))}') from None
    topics = {row[0]: Channel(*(printable(str(text)) for text in row[1:])) for row in rows}
    if not count or not isinstance(low, int) or not isinstance(high, int):
        return Source(path, size, (), Loss(), base.close)
    windows = max(1, -(-int(count) // _PER_PIECE))
    edges = [low + (high + 1 - low) * i // windows for i in range(windows + 1)]
    pieces = tuple(
        Piece(start, stop - 1, size * i // windows, size // windows,
              functools.partial(_load, base, start, stop, topics))
        for i, (start, stop) in enumerate(zip(edges[:-1], edges[1:])) if stop > start)
    return Source(path, size, pieces, Loss(), base.close)


def _load(base: sqlite3.Connection, start: int, stop: int, topics: dict[int, Channel]) -> Block:
    try:
        total, = base.execute('SELECT sum(length(data)) FROM messages WHERE timestamp >= ? '
                              'AND timestamp < ?', (start, stop)).fetchone()
        if (total or 0) > _LARGEST:
            raise DamagedPiece(f'a window of the database claims {total} bytes')
        rows = base.execute('SELECT topic_id, timestamp, data FROM messages WHERE timestamp >= ? '
                            'AND timestamp < ? ORDER BY timestamp, id', (start, stop)).fetchall()
    except _UNREADABLE as error:
        raise DamagedPiece(f'the database is damaged: {printable(str(error))}') from None
    order = {number: i for i, number in enumerate(topics)}
    good = [r for r in rows if r[0] in order and isinstance(r[1], int) and isinstance(r[2], bytes)]
    length = np.array([len(r[2]) for r in good], dtype=np.int64)
    return Block(b''.join(r[2] for r in good), np.cumsum(length) - length, length,
                 np.array([r[1] for r in good], dtype=np.int64),
                 np.array([order[r[0]] for r in good], dtype=np.int64), tuple(topics.values()))
