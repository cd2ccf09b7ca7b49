"""The metadata.yaml that makes a folder with MCAP files a rosbag2 bag (version 9)."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

from mecanum_base import __version__

METADATA = 'metadata.yaml'


@dataclass(slots=True)
class TopicCount:
    """One topic of a bag: name, type (``pkg/msg/Type``), type hash, offered QoS, messages."""

    name: str
    type: str
    type_hash: str = ''
    qos: Sequence[Mapping[str, Any]] = ()
    messages: int = 0


@dataclass(slots=True)
class FileCount:
    """One MCAP file of a bag: its name in the folder, log times it spans, messages."""

    name: str
    start_ns: int = 0
    end_ns: int = 0
    messages: int = 0
    topics: list[TopicCount] = field(default_factory=list)

    def count(self, topic: TopicCount, log_ns: int) -> None:
        """One more message of ``topic``."""
        self.start_ns = min(self.start_ns, log_ns) if self.messages else log_ns
        self.end_ns = max(self.end_ns, log_ns) if self.messages else log_ns
        self.messages += 1
        topic.messages += 1


def write_metadata(folder: pathlib.Path, files: Sequence[FileCount]) -> pathlib.Path:
    """Write metadata.yaml at once or not at all; returns its path."""
    path = folder / METADATA
    part = folder / (METADATA + '.part')
    with part.open('w', encoding='utf-8') as stream:
        yaml.safe_dump(_document(files), stream, sort_keys=False)
        stream.flush()
        os.fsync(stream.fileno())
    part.replace(path)
    return path


def _document(files: Sequence[FileCount]) -> dict[str, Any]:
    filled = [file for file in files if file.messages]
    start = min((file.start_ns for file in filled), default=0)
    end = max((file.end_ns for file in filled), default=0)
    topics: dict[tuple[str, str], TopicCount] = {}
    for file in files:
        for topic in file.topics:
            whole = topics.setdefault((topic.name, topic.type), TopicCount(
                topic.name, topic.type, topic.type_hash, topic.qos))
            whole.messages += topic.messages
    return {'rosbag2_bagfile_information': {
        'version': 9,
        'storage_identifier': 'mcap',
        'duration': {'nanoseconds': end - start},
        'starting_time': {'nanoseconds_since_epoch': start},
        'message_count': sum(file.messages for file in files),
        'topics_with_message_count': [{
            'topic_metadata': {
                'name': topic.name, 'type': topic.type, 'serialization_format': 'cdr',
                'offered_qos_profiles': [dict(qos) for qos in topic.qos],
                'type_description_hash': topic.type_hash,
            },
            'message_count': topic.messages,
        } for topic in topics.values()],
        'compression_format': '',
        'compression_mode': '',
        'relative_file_paths': [file.name for file in files],
        'files': [{
            'path': file.name,
            'starting_time': {'nanoseconds_since_epoch': file.start_ns},
            'duration': {'nanoseconds': file.end_ns - file.start_ns},
            'message_count': file.messages,
        } for file in files],
        'custom_data': {'recorder': f'mecanum_base {__version__}'},
        'ros_distro': 'jazzy',
    }}
