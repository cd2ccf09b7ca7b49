"""What a reader hands on: blocks of raw messages in log order, and what was lost on the way."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mecanum_base.core.parameter import FloatArray, IntArray

NANOSECONDS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Channel:
    """One topic of one file: its name, its type as ``pkg/msg/Type`` and its encoding."""

    topic: str
    type: str
    encoding: str = 'cdr'


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Messages of one stretch of a bag in log order.

    ``data`` holds the payloads; message i is ``data[offset[i]:offset[i] + length[i]]``, was logged
    at ``log_ns[i]`` on ``channels[channel[i]]``. All arrays have shape (N,).
    """

    data: bytes
    offset: IntArray
    length: IntArray
    log_ns: IntArray
    channel: IntArray
    channels: tuple[Channel, ...]

    def __len__(self) -> int:
        return len(self.offset)

    def payload(self, index: int) -> bytes:
        """Bytes of message ``index``."""
        start = int(self.offset[index])
        return self.data[start:start + int(self.length[index])]

    def take(self, chosen: IntArray) -> Block:
        """The messages ``chosen`` (indices), in that order, over the same payloads."""
        return Block(self.data, self.offset[chosen], self.length[chosen], self.log_ns[chosen],
                     self.channel[chosen], self.channels)


def joined(blocks: list[Block]) -> Block:
    """One block over copies of the payloads of several, sorted by log time (stable)."""
    if len(blocks) == 1:
        return blocks[0]
    channels: dict[Channel, int] = {}
    parts, offsets, lengths, logs, indices = [], [], [], [], []
    position = 0
    for block in blocks:
        table = np.array([channels.setdefault(c, len(channels)) for c in block.channels] or [0])
        total = int(block.length.sum())
        if 2 * total > len(block.data):
            parts.append(block.data)
            offsets.append(position + block.offset)
            position += len(block.data)
        else:  # a few left over from much: the rest is not carried on
            parts.extend(block.payload(i) for i in range(len(block)))
            offsets.append(position + np.cumsum(block.length) - block.length)
            position += total
        lengths.append(block.length)
        logs.append(block.log_ns)
        indices.append(table[block.channel])
    log = np.concatenate(logs)
    whole = Block(b''.join(parts), np.concatenate(offsets), np.concatenate(lengths), log,
                  np.concatenate(indices), tuple(channels))
    return whole.take(np.argsort(log, kind='stable'))


@dataclass(slots=True)
class Loss:
    """What could not be read: bytes, seconds of recording, and why (one line a place)."""

    bytes: int = 0
    seconds: float = 0.0
    seconds_known: bool = True
    reasons: list[str] = field(default_factory=list)

    def add(self, reason: str, count: int, seconds: float | None) -> None:
        """Count ``count`` bytes lost; ``seconds`` is None where nothing tells the time span."""
        self.bytes += max(int(count), 0)
        if seconds is None:
            self.seconds_known = False
        else:
            self.seconds += max(seconds, 0.0)
        if len(self.reasons) < 20:
            self.reasons.append(reason)

    def plus(self, other: Loss) -> Loss:
        """Both losses together, as a new one."""
        return Loss(self.bytes + other.bytes, self.seconds + other.seconds,
                    self.seconds_known and other.seconds_known, self.reasons + other.reasons)

    def __bool__(self) -> bool:
        return bool(self.reasons)

    def text(self) -> str:
        """One line for a user."""
        span = f'{self.seconds:.3f} s' if self.seconds_known else (
            f'at least {self.seconds:.3f} s' if self.seconds else 'an unknown time span')
        return f'lost {self.bytes} bytes ({span}): ' + '; '.join(self.reasons[:3]) + (
            f'; and {len(self.reasons) - 3} more' if len(self.reasons) > 3 else '')


def seconds_of(stamp_ns: IntArray, origin_ns: int) -> FloatArray:
    """Seconds since ``origin_ns``; exact to far below a nanosecond for any recording."""
    seconds: FloatArray = (stamp_ns - origin_ns) / NANOSECONDS
    return seconds
