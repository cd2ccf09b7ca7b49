"""Samples for the estimator from blocks of raw messages, in log order.

Encoder and IMU messages are decoded in bulk; the rare ones (set_pose, odometry_reset, /tf_static)
stay messages, which the intake converts as it does in the live node. Wheel commands, decoded in
bulk as well, stay beside all these: they do not go into the estimator.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mecanum_base import messages
from mecanum_base.bag.block import Block
from mecanum_base.bag.decode import (
    JOINT_STATE,
    Readings,
    command_readings,
    imu_readings,
    message,
    tick_readings,
    wheel_readings,
)
from mecanum_base.bag.topics import HEADER, POSE, TF, Topics
from mecanum_base.core.estimation.layout import FRAME as FRAME_KIND
from mecanum_base.core.estimation.layout import IMU as IMU_KIND
from mecanum_base.core.estimation.stretch import Stretch
from mecanum_base.core.parameter import IntArray
from mecanum_base.core.records import ImuSample, Sample, TickSample, WheelSample
from mecanum_base.intake import Estimates, Intake

JOINTS, TICKS, IMU, SET_POSE, RESET, MOUNT = range(6)
COMMANDS = 'wheel_commands'
NAMES = ('joint_states', 'wheel_ticks', 'imu', 'set_pose', 'odometry_reset', 'tf_static')
_RARE = {POSE: SET_POSE, HEADER: RESET, TF: MOUNT}


@dataclass(eq=False)
class Batch:
    """All inputs of a stretch of a recording: ``readings`` by stream number, rare messages as
    they are.

    ``stream`` and ``index`` (N,) give the log order: item k is row ``index[k]`` of
    ``readings[stream[k]]``, or the message ``rare[index[k]]``. ``commands`` are the wheel commands
    of the same stretch, a part for each channel of a block.
    """

    stream: IntArray
    index: IntArray
    readings: dict[int, Readings]
    rare: list[Any] = field(default_factory=list)
    commands: list[Readings] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.stream)

    def part(self, start: int, stop: int) -> Batch:
        """Items ``start`` to ``stop`` over the same readings."""
        return Batch(self.stream[start:stop], self.index[start:stop], self.readings, self.rare)

    @functools.cached_property
    def stamp_ns(self) -> IntArray:
        """Stamp of each item (N,); the smallest number for a rare message."""
        stamp = np.full(len(self), np.iinfo(np.int64).min)
        for code, part in self.readings.items():
            chosen = self.stream == code
            stamp[chosen] = part.stamp_ns[self.index[chosen]]
        return stamp

    @functools.cached_property
    def care(self) -> Any:
        """Which items (N,) are rare messages or wheel readings without every position."""
        care = self.stream >= SET_POSE
        if JOINTS in self.readings:
            chosen = np.flatnonzero(self.stream == JOINTS)
            position = self.readings[JOINTS].values['position'][self.index[chosen]]
            care[chosen] = ~np.isfinite(position).all(axis=1)
        return care

    def stretch(self) -> Stretch | None:
        """The same as columns; None where there is more than one encoder topic, anything rare, or
        no encoder at all."""
        two = JOINTS in self.readings and TICKS in self.readings
        ticks = TICKS in self.readings
        code = TICKS if ticks else JOINTS
        if two or code not in self.readings or self.stream.max(initial=0) >= SET_POSE:
            return None
        is_imu, is_frame = self.stream == IMU, self.stream == code
        of_imu, of_frame = self.index[is_imu], self.index[is_frame]
        frame, imu = self.readings[code], self.readings.get(IMU)
        none = np.zeros((0, 3))
        return Stretch(
            np.where(is_imu, IMU_KIND, FRAME_KIND),
            np.where(is_imu, np.cumsum(is_imu), np.cumsum(is_frame)) - 1,
            np.zeros(0, dtype=np.int64) if imu is None else imu.stamp_ns[of_imu],
            none if imu is None else imu.values['gyro'][of_imu],
            none if imu is None else imu.values['accel'][of_imu], frame.stamp_ns[of_frame],
            frame.values['counts' if ticks else 'position'][of_frame], ticks)

    def feed(self, intake: Intake) -> Iterator[Estimates]:
        """Hand everything to the intake, in log order; yields what becomes due."""
        make: dict[int, Callable[[int], Sample]] = {
            JOINTS: self._wheel, TICKS: self._tick, IMU: self._imu}
        handle = intake.handle
        for stream, index in zip(self.stream.tolist(), self.index.tolist()):
            if stream in make:
                found = handle(make[stream](index))
            else:
                found = _take_rare(intake, stream, self.rare[index])
            if found:
                yield found

    def tell_commands(self, intake: Intake) -> None:
        """Hand the wheel commands to the intake, and the encoder readings to compare them with."""
        for part in self.commands:
            intake.commanded(part.stamp_ns, part.values['rate'])
        watch = intake.command_watch
        if not watch.used:
            return
        for code, name in ((JOINTS, 'position'), (TICKS, 'counts')):
            if code in self.readings:
                part, row = self.readings[code], self.index[self.stream == code]
                watch.readings(part.stamp_ns[row], part.values[name][row])

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
                 reject: Callable[[str, str], None],
                 command_order: tuple[str, ...] = (), imu_late_ns: int = 0) -> None:
        """``reject(stream, reason)`` is called for every malformed message; ``command_order``
        names the wheels in commands without names (default: ``joints``); ``imu_late_ns`` is
        taken off the stamps of the IMU, as the intake does."""
        self.joints, self.topics, self.reject = joints, topics, reject
        self._order, self._imu_late_ns = command_order or joints, imu_late_ns
        self.read = dict.fromkeys((*NAMES, COMMANDS), 0)
        self.foreign = 0

    def batch(self, block: Block) -> Batch:
        """The inputs of one block."""
        readings: dict[int, Readings] = {}
        rare: list[Any] = []
        rows: list[IntArray] = []
        streams: list[IntArray] = []
        indices: list[IntArray] = []
        commands: list[Readings] = []
        for number, channel in enumerate(block.channels):
            name = self.topics.stream(channel)
            chosen = np.flatnonzero(block.channel == number)
            if name is None or not len(chosen):
                continue
            if name == COMMANDS:
                commands.append(self._commands(block, chosen, channel.type))
                continue
            if channel.type in _RARE:
                code = _RARE[channel.type]
                at = self._decoded(block, chosen, code, channel.type, rare)
                index = np.arange(len(rare) - len(at), len(rare))
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
            return Batch(empty, empty, {}, [], commands)
        order = np.argsort(np.concatenate(rows), kind='stable')
        return Batch(np.concatenate(streams)[order], np.concatenate(indices)[order], readings,
                     rare, commands)

    def _commands(self, block: Block, chosen: IntArray, kind: str) -> Readings:
        part = command_readings(block, chosen, self._order, self.joints, kind)
        self.read[COMMANDS] += len(chosen)
        for reason in part.rejected:
            self.reject(COMMANDS, reason)
        return part

    def _readings(self, block: Block, chosen: IntArray, kind: str) -> tuple[int, Readings]:
        if kind == JOINT_STATE:
            code, part = JOINTS, wheel_readings(block, chosen, self.joints)
        elif kind.startswith('std_msgs'):
            code, part = TICKS, tick_readings(block, chosen, len(self.joints), kind)
        else:
            code, part = IMU, imu_readings(block, chosen)
            part.stamp_ns = part.stamp_ns - self._imu_late_ns
        self.foreign += part.foreign
        for reason in part.rejected:
            self.reject(NAMES[code], reason)
        return code, part

    def _decoded(self, block: Block, chosen: IntArray, code: int, kind: str,
                 rare: list[Any]) -> IntArray:
        kept = []
        for row in chosen.tolist():
            try:
                rare.append(message(block.payload(row), kind))
            except messages.MalformedMessage as error:
                self.reject(NAMES[code], str(error))
                continue
            kept.append(row)
        return np.array(kept, dtype=np.int64)


def joined_batches(batches: list[Batch]) -> Batch:
    """Consecutive batches as one."""
    if len(batches) == 1:
        return batches[0]
    readings: dict[int, Readings] = {}
    rare: list[Any] = []
    indices = []
    for batch in batches:
        index = batch.index + np.where(batch.stream >= SET_POSE, len(rare), 0)
        for code in batch.readings:
            index[batch.stream == code] += len(readings[code].row) if code in readings else 0
        indices.append(index)
        rare += batch.rare
        for code, part in batch.readings.items():
            _append(readings, code, part)
    return Batch(np.concatenate([batch.stream for batch in batches]), np.concatenate(indices),
                 readings, rare, [part for batch in batches for part in batch.commands])


def _take_rare(intake: Intake, stream: int, msg: Any) -> Estimates:
    if stream == SET_POSE:
        return intake.set_pose(msg)
    if stream == RESET:
        return intake.odometry_reset(msg)
    found: Estimates = ()
    for item in msg.transforms:
        move = item.transform
        found += intake.static_transform(
            item.header.frame_id, item.child_frame_id,
            (move.translation.x, move.translation.y, move.translation.z),
            (move.rotation.x, move.rotation.y, move.rotation.z, move.rotation.w))
    return found


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
