"""Messages without ROS: empty ones of any type, and their CDR bytes.

:mod:`mecanum_base.messages` fills such messages just as it fills those of rclpy.
"""

from __future__ import annotations

import copy
import functools
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore


@functools.lru_cache(maxsize=1)
def _store() -> Any:
    return get_typestore(Stores.ROS2_JAZZY)


def blank(message_type: str) -> Any:
    """A new message of that type (``sensor_msgs/msg/Imu``) with every field zero or empty."""
    return copy.deepcopy(_template(message_type))


@functools.cache
def _template(message_type: str) -> Any:
    constants, fields = _store().fielddefs[message_type]
    values = {name: _zero(*kind) for name, kind in fields}
    return _store().types[message_type](**values)


def _zero(kind: Any, what: Any) -> Any:
    if kind is Nodetype.NAME:
        return blank(what)
    if kind is Nodetype.BASE:
        return {'string': '', 'bool': False}.get(what[0], 0.0 if 'float' in what[0] else 0)
    (inner, name), length = what
    if inner is Nodetype.BASE and name[0] != 'string':
        return np.zeros(length, dtype=name[0])
    return [_zero(inner, name) for _ in range(length)]


@functools.cache
def _number_lists(message_type: str) -> tuple[tuple[str, str], ...]:
    """Fields that hold lists of numbers, with their dtype."""
    found = []
    for name, (kind, what) in _store().fielddefs[message_type][1]:
        if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE) and what[0][0] is Nodetype.BASE:
            if what[0][1][0] != 'string':
                found.append((name, what[0][1][0]))
    return tuple(found)


def encode(message: Any) -> bytes:
    """CDR bytes of a message; the same message gives the same bytes."""
    kind = message.__msgtype__
    for name, dtype in _number_lists(kind):
        value = getattr(message, name)
        if not isinstance(value, np.ndarray):
            setattr(message, name, np.array(value, dtype=dtype))
    return bytes(_store().serialize_cdr(message, kind))
