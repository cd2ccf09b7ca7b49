"""Record node: every topic of the robot into an MCAP bag that survives a kill.

Every topic is subscribed, those that may have several types with the one that is published, and
written as the bytes that came. The log time is the node's clock at arrival. Every
record.flush_period seconds everything is on disk; at the end summary and metadata.yaml make the
folder a rosbag2 bag. A robot file is not needed.
"""

from __future__ import annotations

import functools
import sys
import time
from collections.abc import Sequence
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from mecanum_base.bag.recorder import Recorder
from mecanum_base.core.errors import BagError, ConfigError
from mecanum_base.core.parameter import read_section, rules
from mecanum_base.robot import RecordConfig
from mecanum_base.ros import process
from mecanum_base.ros.arrivals import Arrivals
from mecanum_base.ros.contract_topics import contract_topics
from mecanum_base.ros.diagnostics import ERROR, OK, STALE, Diagnostics, Status
from mecanum_base.ros.followed_topic import FollowedTopic, look_often
from mecanum_base.ros.parameters import declare, descriptor, nested
from mecanum_base.ros.transforms import Transforms

DEPTH = 1000
LATCHED = ('tf_static',)  # topics whose last messages are wanted also if sent before
HELD = 1000  # messages kept while simulated time has not begun


class RecordNode(Node):
    """Records until it is destroyed. Keyword arguments are those of rclpy's Node."""

    def __init__(self, **options: Any) -> None:
        super().__init__('record_node', **options)
        config = self._config()
        folder = config.output or time.strftime('mecanum_%Y%m%d_%H%M%S')
        try:
            self.recorder = Recorder(folder)
        except BagError as error:
            raise ConfigError('record.output', folder, str(error)) from None
        self._failure = ''
        self._held: list[tuple[int, bytes]] = []
        self._channels: dict[tuple[str, str], int] = {}
        self._counts: dict[str, int] = {}
        arrivals = Arrivals(self)
        self._topics = {
            topic: FollowedTopic(
                self, topic, types, functools.partial(self._on_message, topic),
                functools.partial(_profile, latched=topic in LATCHED), raw=True,
                arrivals=arrivals, default=next(iter(types)) if len(types) == 1 else '')
            for topic, types in contract_topics(Transforms()).items()}
        look_often(self, self.look)
        self.create_timer(config.flush_period, self._flush,
                          clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._diagnostics = Diagnostics(self, self._statuses)
        self.get_logger().info(f'recording into {self.recorder.path}')

    def destroy_node(self) -> None:
        """Complete the bag, then end the node."""
        self._write_held(self.get_clock().now().nanoseconds or time.time_ns())
        self._guarded(self.recorder.close)
        self.get_logger().info(f'{self.recorder.messages} messages in {self.recorder.folder}')
        super().destroy_node()

    def _config(self) -> RecordConfig:
        """The record block; the whole robot is checked where one is given."""
        given = nested({name: p.value for name, p in self._parameter_overrides.items()})
        if 'wheels' in given or 'carriers' in given:
            return declare(self).record
        config = read_section(RecordConfig, given.get('record', {}), 'record')
        for name, rule in rules(RecordConfig).items():
            self.declare_parameter(f'record.{name}', getattr(config, name), descriptor(rule),
                                   ignore_override=True)
        return config

    def look(self) -> None:
        """Look for new publishers now."""
        for topic in self._topics.values():
            topic.look()

    def _on_message(self, topic: str, raw: Any, now: int) -> None:
        channel = self._channel(topic)
        self._counts[topic] = self._counts.get(topic, 0) + 1
        if now == 0 and len(self._held) < HELD:  # simulated time that has not begun
            self._held.append((channel, bytes(raw)))
            return
        self._write_held(now)
        self._guarded(self.recorder.write, channel, now, now, bytes(raw))

    def _channel(self, topic: str) -> int:
        key = topic, self._topics[topic].type
        if key not in self._channels:
            name = self.resolve_topic_name(topic)
            qos = [_words(info.qos_profile) for info in self.get_publishers_info_by_topic(topic)]
            self._channels[key] = self.recorder.channel(name, key[1], qos)
            self.get_logger().info(f'recording {name} [{key[1]}]')
        return self._channels[key]

    def _write_held(self, now: int) -> None:
        held, self._held = self._held, []
        for channel, raw in held:
            self._guarded(self.recorder.write, channel, now, now, raw)

    def _flush(self) -> None:
        self._guarded(self.recorder.flush)

    def _guarded(self, call: Any, *arguments: Any) -> None:
        """Do what may fail on a full or lost disk; after the first failure do nothing more."""
        if self._failure:
            return
        try:
            call(*arguments)
        except BagError as error:
            self._failure = str(error)
            self.get_logger().error(f'recording has ended: {error}')

    def _statuses(self) -> list[Status]:
        values: dict[str, object] = {
            'folder': self.recorder.folder, 'messages': self.recorder.messages,
            **{f'{topic}: messages': n for topic, n in sorted(self._counts.items())}}
        topics = self._topics.values()
        conflicts = [f'{t.topic} also as {t.conflict}' for t in topics if t.conflict]
        strange = [f'{t.topic} as {t.unknown}' for t in topics if t.unknown]
        if self._failure:
            return [Status('recording', ERROR, self._failure, values)]
        if conflicts or strange:
            return [Status('recording', ERROR, 'not recorded: ' + ', '.join(conflicts + strange),
                           values)]
        if not self.recorder.messages:
            return [Status('recording', STALE, 'nothing to record yet', values)]
        return [Status('recording', OK, f'{self.recorder.messages} messages', values)]


def _profile(infos: list[Any], latched: bool) -> QoSProfile:
    """The strictest profile that hears every publisher; without any, that of our own nodes."""
    offers = [info.qos_profile for info in infos]
    reliable = all(q.reliability == ReliabilityPolicy.RELIABLE for q in offers)
    latched = latched and all(q.durability == DurabilityPolicy.TRANSIENT_LOCAL for q in offers)
    return QoSProfile(
        depth=DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE)


def _words(profile: Any) -> dict[str, Any]:
    """An offered QoS profile as rosbag2 writes it (version 9)."""
    def duration(value: Any) -> dict[str, int]:
        seconds, nanoseconds = divmod(value.nanoseconds, 1_000_000_000)
        return {'sec': seconds, 'nsec': nanoseconds}
    return {
        'history': profile.history.name.lower(), 'depth': int(profile.depth),
        'reliability': profile.reliability.name.lower(),
        'durability': profile.durability.name.lower(),
        'deadline': duration(profile.deadline), 'lifespan': duration(profile.lifespan),
        'liveliness': profile.liveliness.name.lower(),
        'liveliness_lease_duration': duration(profile.liveliness_lease_duration),
        'avoid_ros_namespace_conventions': bool(profile.avoid_ros_namespace_conventions),
    }


def main(args: Sequence[str] | None = None) -> int:
    """Record until told to end; the exit code."""
    return process.run(RecordNode, args)


if __name__ == '__main__':
    sys.exit(main())
