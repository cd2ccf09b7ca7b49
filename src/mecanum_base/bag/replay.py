"""Run the estimator of the odometry node over a recording and write its tracks.

Recorded samples go to the estimator in log order, exactly as they reached the live node; it puts
them in the order of their stamps itself. The end of the recording flushes it. Reading runs ahead
of the estimator and writing behind it, each in a thread (:mod:`mecanum_base.bag.ahead`).
"""

from __future__ import annotations

import functools
import math
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mecanum_base.bag.ahead import Ahead, Behind
from mecanum_base.bag.block import NANOSECONDS
from mecanum_base.bag.reader import Bag
from mecanum_base.bag.stream import Batch, SampleReader, joined_stretch
from mecanum_base.bag.topics import STREAMS, Topics, advice
from mecanum_base.bag.track import TrackWriter
from mecanum_base.core.errors import BagError
from mecanum_base.core.estimation.acceleration import COMPILED
from mecanum_base.core.estimation.output import TWIST
from mecanum_base.core.estimation.stretch import Rows, Stretch, take
from mecanum_base.core.records import Estimate
from mecanum_base.intake import Intake
from mecanum_base.robot import Robot

_PORTION = 16384 if COMPILED else 1  # inputs at least in a portion: calls cost less, waits more
Step = Callable[[float, float], None]  # share of the bytes read, seconds of data done


@dataclass(slots=True)
class Course:
    """What is kept of the track while it is written: ends, path length, number of rows."""

    first_ns: int | None = None
    last: Estimate | None = None
    path: float = 0.0  # [m] integral of the speed
    rows: int = 0

    def add(self, estimate: Estimate) -> None:
        """Take in one estimate."""
        if self.last is None:
            self.first_ns = estimate.stamp_ns
        else:
            step = (estimate.stamp_ns - self.last.stamp_ns) / NANOSECONDS
            if step > 0.0:
                self.path += step * 0.5 * (_speed(self.last) + _speed(estimate))
        self.last = estimate
        self.rows += 1

    def add_rows(self, rows: Rows) -> None:
        """Take in many estimates."""
        count = len(rows.stamp_ns)
        if not count:
            return
        if self.last is None:
            self.first_ns = int(rows.stamp_ns[0])
        speed = np.hypot(rows.table[:, TWIST], rows.table[:, TWIST + 1])
        stamp = rows.stamp_ns
        if self.last is not None:
            speed = np.concatenate(([_speed(self.last)], speed))
            stamp = np.concatenate(([self.last.stamp_ns], stamp))
        step = np.maximum(np.diff(stamp) / NANOSECONDS, 0.0)
        self.path += float(np.sum(step * 0.5 * (speed[1:] + speed[:-1])))
        self.last = rows.at(count - 1)
        self.rows += count

    @property
    def seconds(self) -> float:
        """Time from the first to the last estimate."""
        if self.last is None or self.first_ns is None:
            return 0.0
        return (self.last.stamp_ns - self.first_ns) / NANOSECONDS


@dataclass(frozen=True, slots=True, eq=False)
class Replayed:
    """The outcome of one replay."""

    bag: Bag
    reader: SampleReader
    intake: Intake
    course: Course
    wall_seconds: float


class Sink(Protocol):
    """Takes the estimates of a replay."""

    def write(self, estimate: Estimate) -> None:
        """Take one estimate."""

    def close(self) -> None:
        """No more estimates come."""


@dataclass(frozen=True, slots=True, eq=False)
class _Portion:
    """Consecutive blocks of the recording; ``share`` (0..1) of the bytes is read with them.

    ``columns`` holds the inputs of all batches where all is plain.
    """

    batches: tuple[Batch, ...]
    columns: Stretch | None
    rejected: tuple[tuple[str, str], ...]
    share: float
    last: bool


def replay(paths: list[str], robot: Robot, out: str | os.PathLike[str], topics: Topics,
           step: Step | None = None) -> Replayed:
    """Replay the recording ``paths`` into files in the folder ``out``; see :func:`replay_into`."""
    return replay_into(paths, robot, lambda: TrackWriter(out, robot.base.joint), topics, step)


def replay_into(paths: list[str], robot: Robot, sink: Callable[[], Sink], topics: Topics,
                step: Step | None = None) -> Replayed:
    """Replay the recording ``paths`` into what ``sink`` makes once the first block is read.

    The sink is used in a thread of its own. Raises BagError where the recording cannot be read or
    holds no encoder messages.
    """
    begin = time.perf_counter()
    with Bag(paths) as bag:
        intake = Intake(robot)
        rejected: list[tuple[str, str]] = []
        reader = SampleReader(robot.base.joint, topics,
                              lambda stream, reason: rejected.append((stream, reason)))
        course = Course()
        output: _Output | None = None
        try:
            with Ahead(_portions(bag, reader, topics, rejected)) as portions:
                for portion in portions:
                    for stream, reason in portion.rejected:
                        intake.estimator.reject(stream, reason)
                    if output is None:
                        output = _Output(sink())
                    _feed(portion, intake, output, course)
                    if step is not None:
                        step(portion.share, course.seconds)
            require_encoder(bag, reader, topics)
            if output is not None:
                output.take(list(intake.flush()), course)
        finally:
            if output is not None:
                output.close()
        return Replayed(bag, reader, intake, course, time.perf_counter() - begin)


def _portions(bag: Bag, reader: SampleReader, topics: Topics,
              rejected: list[tuple[str, str]]) -> Iterator[_Portion]:
    """The inputs in portions worth a call of the estimator; the last one is marked."""

    def portion(last: bool) -> _Portion:
        whole = _Portion(tuple(held), joined_stretch([one.stretch() for one in held]),
                         tuple(rejected), bag.read_bytes / max(bag.piece_bytes, 1), last)
        held.clear()
        rejected.clear()
        return whole

    held: list[Batch] = []
    for block in bag.blocks(lambda channel: topics.stream(channel) is not None):
        if sum(len(one.stream) for one in held) >= _PORTION:
            yield portion(False)
        held.append(reader.batch(block))
    if held:
        yield portion(True)


class _Output:
    """Hands what the estimator gives to a sink, in a thread behind the caller."""

    def __init__(self, sink: Sink) -> None:
        self._sink, self._behind = sink, Behind()

    def take(self, estimates: list[Estimate], course: Course) -> None:
        """Take estimates one by one."""
        for estimate in estimates:
            course.add(estimate)
        if estimates:
            self._behind.do(functools.partial(_write, self._sink, estimates))

    def take_rows(self, rows: Rows, course: Course) -> None:
        """Take a stretch of estimates at once."""
        if isinstance(self._sink, TrackWriter):
            self._behind.do(functools.partial(
                self._sink.write_rows, rows.stamp_ns, rows.track(), rows.slip(), rows.predicted))
            course.add_rows(rows)
            self.take(list(rows.rest), course)
        else:
            self.take(list(rows.estimates()), course)

    def close(self) -> None:
        """Everything is written; raises what went wrong."""
        try:
            self._behind.close()
        finally:
            self._sink.close()


def _write(sink: Sink, estimates: list[Estimate]) -> None:
    for estimate in estimates:
        sink.write(estimate)


def require_encoder(bag: Bag, reader: SampleReader, topics: Topics) -> None:
    """BagError with advice where no encoder message was read or none names a wheel."""
    count = reader.read['joint_states'] + reader.read['wheel_ticks']
    name = ', '.join(bag.paths)
    if not count:
        assert topics.encoder is not None
        raise BagError(f'{name}: {advice("encoder", topics.encoder, bag.counts)}')
    if reader.foreign == count:
        raise BagError(f'{name}: none of {count} messages on {topics.encoder} names a wheel of '
                       f'the robot file ({", ".join(reader.joints)})')


def absent_streams(bag: Bag, topics: Topics) -> list[str]:
    """Advice for each optional sensor stream that the recording does not have."""
    heard = {topics.stream(channel) for channel, count in bag.counts.items() if count}
    return [advice(name, wanted, bag.counts) for name in STREAMS
            if name == 'imu' and (wanted := getattr(topics, name)) and name not in heard]


def _feed(portion: _Portion, intake: Intake, output: _Output, course: Course) -> None:
    """Hand a portion to the intake: at once where all is plain, else batch by batch."""
    if portion.columns is not None and intake.direct:
        rows = take(intake.estimator, portion.columns, portion.last)
        if rows is not None:
            output.take_rows(rows, course)
            return
    for batch in portion.batches:
        columns = batch.stretch() if intake.direct and len(portion.batches) > 1 else None
        rows = None if columns is None else take(intake.estimator, columns, False)
        if rows is not None:
            output.take_rows(rows, course)
        else:
            output.take([one for some in batch.feed(intake) for one in some], course)


def _speed(estimate: Estimate) -> float:
    return math.hypot(float(estimate.twist[0]), float(estimate.twist[1]))
