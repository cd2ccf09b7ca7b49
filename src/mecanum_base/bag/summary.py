"""summary.json of a replay: counts, distances, slip episodes, biases, versions."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import os
import pathlib
import platform
from typing import Any

import numpy as np

from mecanum_base import __version__
from mecanum_base.bag.block import NANOSECONDS
from mecanum_base.bag.replay import Replayed, absent_streams
from mecanum_base.bag.topics import Topics
from mecanum_base.core.errors import BagError


def summary_of(done: Replayed, topics: Topics, robot_file: str) -> dict[str, Any]:
    """Everything worth knowing about one replay, as plain JSON values."""
    estimator, known = done.intake.estimator, done.intake.health
    health = plain(known)
    course, last = done.course, done.course.last
    rejected: dict[str, dict[str, int]] = {}
    for (stream, reason), count in known.rejected.items():
        rejected.setdefault(stream, {})[reason] = int(count)
    used = dict(known.used)
    streams = {name: {'read': count, 'used': int(used.get(name, 0)),
                      'rejected': rejected.get(name, {})}
               for name, count in done.reader.read.items()}
    return {
        'bag': {'files': done.bag.paths, 'loss': loss_of(done), 'notes': done.bag.notes},
        'messages': streams,
        'messages_without_wheels': done.reader.foreign,
        'duration': course.seconds,
        'distance': course.path,
        'rows': course.rows,
        'final_pose': None if last is None else [float(v) for v in last.pose],
        'slip_episodes': [episode_of(e, done.reader.joints) for e in estimator.episodes],
        'health': health,
        'notes': [*estimator.health.notes, *command_notes(done),
                  *absent_streams(done.bag, topics)],
        'run': {'seconds': done.wall_seconds,
                'times_real_time': course.seconds / max(done.wall_seconds, 1e-9)},
        'versions': {'mecanum_base': __version__, 'python': platform.python_version(),
                     'numpy': np.__version__},
        'robot_file': {'path': str(robot_file), 'sha256': sha256_of(robot_file)},
    }


def loss_of(done: Replayed) -> dict[str, Any] | None:
    """What the recording lost; None where it is whole."""
    loss = done.bag.loss
    if not loss:
        return None
    return {'bytes': loss.bytes, 'seconds': loss.seconds if loss.seconds_known else None,
            'at_least_seconds': loss.seconds, 'reasons': loss.reasons}


def command_notes(done: Replayed) -> list[str]:
    """A sentence for each wheel that did not follow its command at some time."""
    begin = done.course.first_ns or 0
    return [f'wheel {joint} does not follow its command: {seconds:.1f} s in all, first '
            f'{(first - begin) / NANOSECONDS:.1f} s after the start'
            for joint, first, seconds in done.intake.command_watch.strayed]


def episode_of(episode: Any, joints: tuple[str, ...]) -> dict[str, Any]:
    """A slip episode with stamps in seconds and wheels by joint name."""
    names = [joints[w] if isinstance(w, (int, np.integer)) else str(w) for w in episode.wheels]
    return {'start': episode.start_ns / NANOSECONDS, 'end': episode.end_ns / NANOSECONDS,
            'wheels': names, 'kind': str(episode.kind),
            'probability': float(episode.probability),
            'slip_distance': float(episode.distance), 'peak': float(episode.peak)}


def sha256_of(path: str | os.PathLike[str]) -> str:
    """Hex digest of a file."""
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def plain(value: Any) -> Any:
    """JSON values of a record: dataclasses by field, arrays as lists, NaN as null."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {'/'.join(map(str, k)) if isinstance(k, tuple) else str(k): plain(v)
                for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else None
    return value if value is None else str(value)


def write_json(path: str | os.PathLike[str], document: Any) -> None:
    """Write a JSON file; BagError where it cannot be written."""
    try:
        pathlib.Path(path).write_text(json.dumps(document, indent=1, allow_nan=False) + '\n',
                                      encoding='utf-8')
    except OSError as error:
        raise BagError(f'{path}: cannot be written: {error.strerror}') from None
