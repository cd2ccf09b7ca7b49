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
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from mecanum_base.bag.ahead import Ahead, Behind
from mecanum_base.bag.block import NANOSECONDS
from mecanum_base.bag.portion import feed, portions
from mecanum_base.bag.reader import Bag
from mecanum_base.bag.stream import SampleReader
from mecanum_base.bag.topics import STREAMS, Topics, advice
from mecanum_base.bag.track import SMOOTHED, TrackWriter
from mecanum_base.core.errors import BagError
from mecanum_base.core.estimation.acceleration import COMPILED
from mecanum_base.core.estimation.output import TWIST
from mecanum_base.core.estimation.smoother import Piece
from mecanum_base.core.estimation.stretch import Rows
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.records import Estimate
from mecanum_base.intake import Intake
from mecanum_base.robot import Robot

_GATHERED = 256  # single estimates handed over at once
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


@runtime_checkable
class RowSink(Sink, Protocol):
    """A sink that takes many estimates at once, as rows; see TrackWriter."""

    def write_rows(self, stamp_ns: IntArray, track: FloatArray, slip: FloatArray,
                   predicted: IntArray) -> None:
        """Take rows: (N,), (N, 12), (N, 2 W + 1), (N,)."""


def replay(paths: list[str], robot: Robot, out: str | os.PathLike[str], topics: Topics,
           step: Step | None = None) -> Replayed:
    """Replay the recording ``paths`` into files in the folder ``out``; see :func:`replay_into`."""
    joints = robot.base.joint
    return replay_into(paths, robot, lambda: TrackWriter(out, joints, compiled=COMPILED), topics,
                       step, lambda: TrackWriter(out, joints, SMOOTHED, COMPILED))


def replay_into(paths: list[str], robot: Robot, sink: Callable[[], Sink], topics: Topics,
                step: Step | None = None,
                smoothed: Callable[[], TrackWriter] | None = None) -> Replayed:
    """Replay the recording ``paths`` into what ``sink`` makes once the first block is read.

    What ``smoothed`` makes takes every frame as it looks once later readings are known. Both are
    used in a thread of their own. Raises BagError where the recording cannot be read or
    holds no encoder messages.
    """
    begin = time.perf_counter()
    with Bag(paths) as bag:
        intake = Intake(robot, smoothed is not None)
        rejected: list[tuple[str, str]] = []
        reader = SampleReader(robot.base.joint, topics,
                              lambda stream, reason: rejected.append((stream, reason)),
                              robot.drive.command_joints, robot.imu.late_ns)
        course = Course()
        output: _Output | None = None
        try:
            with Ahead(portions(bag, reader, topics, rejected)) as read:
                for portion in read:
                    if output is None:
                        output = _Output(sink(), smoothed and smoothed())
                    for found in feed(portion, intake):
                        output.take(found, course)
                    output.look_back(intake.past())
                    if step is not None:
                        step(portion.share, course.seconds)
            require_encoder(bag, reader, topics)
            if output is not None:
                output.take(intake.flush(), course)
                output.look_back(intake.past(last=True))
        finally:
            if output is not None:
                output.close()
        return Replayed(bag, reader, intake, course, time.perf_counter() - begin)


class _Output:
    """Hands what the estimator gives to a sink, in a thread behind the caller."""

    def __init__(self, sink: Sink, smoothed: TrackWriter | None) -> None:
        self._sink, self._smoothed, self._behind = sink, smoothed, Behind()
        self._held: list[Estimate] = []

    def take(self, found: Rows | tuple[Estimate, ...], course: Course) -> None:
        """Take estimates, as rows or one by one."""
        estimates: tuple[Estimate, ...] = ()
        if not isinstance(found, Rows):
            estimates = found
        elif isinstance(self._sink, RowSink):
            self._flush()
            self._behind.do(functools.partial(
                self._sink.write_rows, found.stamp_ns, found.track(), found.slip(),
                found.predicted))
            course.add_rows(found)
            estimates = found.rest
        else:
            estimates = found.estimates()
        for estimate in estimates:
            course.add(estimate)
        self._held += estimates
        if len(self._held) >= _GATHERED:
            self._flush()

    def look_back(self, past: tuple[Piece, ...]) -> None:
        """Take frames to be smoothed."""
        for piece in past:
            if self._smoothed is not None:
                self._behind.do(functools.partial(_smooth, self._smoothed, piece))

    def _flush(self) -> None:
        if self._held:
            self._behind.do(functools.partial(_write, self._sink, self._held))
            self._held = []

    def close(self) -> None:
        """Everything is written; raises what went wrong."""
        try:
            self._flush()
        finally:
            try:
                self._behind.close()
            finally:
                try:
                    self._sink.close()
                finally:
                    if self._smoothed is not None:
                        self._smoothed.close()


def _smooth(writer: TrackWriter, piece: Piece) -> None:
    found = piece.smoothed()
    writer.write_rows(found.stamp_ns, found.track, found.slip,
                      np.zeros(len(found.stamp_ns), dtype=np.int64))


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


def _speed(estimate: Estimate) -> float:
    return math.hypot(float(estimate.twist[0]), float(estimate.twist[1]))
