"""Samples for the estimator from blocks of raw messages, in log order."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from mecanum_base import messages
from mecanum_base.bag.block import Block
from mecanum_base.bag.decode import (
    JOINT_STATE,
    Readings,
    imu_readings,
    message,
    tick_readings,
    wheel_readings,
)
from mecanum_base.bag.topics import HEADER, POSE, Topics
from mecanum_base.core.parameter import IntArray
from mecanum_base.core.records import (
    ImuSample,
    PoseSample,
    ResetSample,
    Sample,
    TickSample,
    WheelSample,
)

JOINTS, TICKS, IMU, SET_POSE, RESET = range(5)
NAMES = ('joint_states', 'wheel_ticks', 'imu', 'set_pose', 'odometry_reset')


@dataclass(slots=True, eq=False)
class Batch:
    """All samples of one block: ``readings`` by stream number, ``events`` by row.

    ``stream`` and ``index`` (N,) give the log order: sample k is row ``index[k]`` of
    ``readings[stream[k]]``, or ``events[index[k]]`` for set_pose and odometry_reset.
    """

    stream: IntArray
    index: IntArray
    readings: dict[int, Readings]
    events: list[Sample] = field(default_factory=list)

    def samples(self) -> Iterator[Sample]:
        """Every sample as a record, in log order."""
        make: dict[int, Callable[[int], Sample]] = {
            JOINTS: self._wheel, TICKS: self._tick, IMU: self._imu,
            SET_POSE: self.events.__getitem__, RESET: self.events.__getitem__}
        for stream, index in zip(self.stream.tolist(), self.index.tolist()):
            yield make[stream](index)

    def _wheel(self, index: int) -> WheelSample:
        part = self.readings[JOINTS]
        return WheelSample(int(part.stamp_ns[index]), part.values['position'][index],
                           part.values['velocity'][index])

    def _tick(self, index: int) -> TickSample:
        part = self.readings[TICKS]
        return TickSample(int(part.stamp_ns[index]), part.values['counts'][index])

    def _imu(self, index: int) -> ImuSample:
        part = self.readings[IMU]
        return ImuSample(int(part.stamp_ns[index]), part.values['gyro'][index],
                         part.values['accel'][index])


class SampleReader:
    """Turns blocks into batches and counts what is read, foreign or malformed."""

    def __init__(self, joints: tuple[str, ...], topics: Topics,
                 reject: Callable[[str, str], None]) -> None:
        """``reject(stream, reason)`` is called for every malformed message."""
        self.joints, self.topics, self.reject = joints, topics, reject
        self.read = dict.fromkeys(NAMES, 0)
        self.foreign = 0

    def batch(self, block: Block) -> Batch:
        """The samples of one block."""
        readings: dict[int, Readings] = {}
        events: list[Sample] = []
        rows: list[IntArray] = []
        streams: list[IntArray] = []
        indices: list[IntArray] = []
        for number, channel in enumerate(block.channels):
            name = self.topics.stream(channel)
            chosen = np.flatnonzero(block.channel == number)
            if name is None or not len(chosen):
                continue
            if channel.type in (POSE, HEADER):
                at = self._events(block, chosen, channel.type, events)
                code = SET_POSE if channel.type == POSE else RESET
                index = np.arange(len(events) - len(at), len(events))
            else:
                code, part = self._readings(block, chosen, channel.type)
                index = np.arange(len(part.row)) + _append(readings, code, part)
                at = part.row
            self.read[NAMES[code]] += len(chosen)
            rows.append(at)
            streams.append(np.full(len(at), code))
            indices.append(index)
        if not rows:
            empty = np.zeros(0, dtype=np.int64)
            return Batch(empty, empty, {}, [])
        order = np.argsort(np.concatenate(rows), kind='stable')
        return Batch(np.concatenate(streams)[order], np.concatenate(indices)[order], readings,
                     events)

    def _readings(self, block: Block, chosen: IntArray, kind: str) -> tuple[int, Readings]:
        if kind == JOINT_STATE:
            code, part = JOINTS, wheel_readings(block, chosen, self.joints)
        elif kind.startswith('std_msgs'):
            code, part = TICKS, tick_readings(block, chosen, len(self.joints), kind)
        else:
            code, part = IMU, imu_readings(block, chosen)
        self.foreign += part.foreign
        for reason in part.rejected:
            self.reject(NAMES[code], reason)
        return code, part

    def _events(self, block: Block, chosen: IntArray, kind: str,
                events: list[Sample]) -> IntArray:
        kept = []
        for row in chosen:
            try:
                msg = message(block.payload(int(row)), kind)
                event: PoseSample | ResetSample = (
                    messages.pose_sample(msg) if kind == POSE else messages.reset_sample(msg))
            except messages.MalformedMessage as error:
                self.reject('set_pose' if kind == POSE else 'odometry_reset', str(error))
                continue
            events.append(event)
            kept.append(int(row))
        return np.array(kept, dtype=np.int64)



def _append(readings: dict[int, Readings], code: int, part: Readings) -> int:
    """Put ``part`` behind what the stream already has; returns the index of its first sample."""
    if code not in readings:
        readings[code] = part
        return 0
    old = readings[code]
    first = len(old.row)
    readings[code] = Readings(
        np.concatenate([old.row, part.row]), np.concatenate([old.stamp_ns, part.stamp_ns]),
        {name: np.concatenate([old.values[name], part.values[name]]) for name in old.values})
    return first
