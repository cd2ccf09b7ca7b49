"""Serialized messages to arrays of samples: in bulk where their layout repeats, else one by one.

The values are exactly those that :mod:`mecanum_base.messages` takes from a decoded message.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mecanum_base import messages
from mecanum_base.bag.block import NANOSECONDS, Block
from mecanum_base.bag.layout import (
    Layout,
    NoLayout,
    imu_layout,
    joint_state_layout,
    multi_array_layout,
)
from mecanum_base.bag.mcap_records import rows_at
from mecanum_base.core.parameter import FloatArray, IntArray

JOINT_STATE, IMU = 'sensor_msgs/msg/JointState', 'sensor_msgs/msg/Imu'
RATES = 'std_msgs/msg/Float64MultiArray'
TICKS = {'std_msgs/msg/Int64MultiArray': 8, 'std_msgs/msg/Int32MultiArray': 4}
_LAYOUTS_A_BLOCK = 16  # more shapes than this in one block: the rest is read one by one


@dataclass(slots=True, eq=False)
class Readings:
    """Samples of one stream in one block: ``row`` (N,) is their place in the block.

    ``stamp_ns`` (N,) header stamps (log times for ticks); ``values`` float64 or int64 arrays by
    name, each (N, ...); ``rejected``: reason of each message that was malformed; ``foreign``:
    messages that name no wheel at all.
    """

    row: IntArray
    stamp_ns: IntArray
    values: dict[str, Any]
    rejected: list[str] = field(default_factory=list)
    foreign: int = 0


Shape = tuple[IntArray, IntArray, dict[str, Any]]


def wheel_readings(block: Block, rows: IntArray, joints: tuple[str, ...]) -> Readings:
    """JointState messages at ``rows``: position and velocity (N, W), NaN where not given."""

    def take(part: Block, layout: Layout) -> dict[str, Any] | None:
        wanted = [layout.names.index(j) if j in layout.names else None for j in joints]
        if all(i is None for i in wanted):
            return None
        if any(layout.names.count(joint) > 1 for joint in joints):
            raise messages.MalformedMessage('joint named twice')
        if any(layout.count[name] not in (0, len(layout.names))
               for name in ('position', 'velocity')):
            raise messages.MalformedMessage('array length differs from name')
        if layout.count['position'] == 0 and layout.count['velocity'] == 0:
            raise messages.MalformedMessage('neither position nor velocity')
        columns = {}
        for name in ('position', 'velocity'):
            grid = np.full((len(part), len(joints)), np.nan)
            if layout.count[name]:
                every = _floats(part, layout, name)
                for wheel, index in enumerate(wanted):
                    if index is not None:
                        grid[:, wheel] = every[:, index]
            columns[name] = grid
        return columns

    def single(msg: Any, log_ns: int) -> tuple[int, dict[str, Any]] | None:
        sample = messages.wheel_sample(msg, joints)
        return None if sample is None else (
            sample.stamp_ns, {'position': sample.position, 'velocity': sample.velocity})

    empty = {'position': np.zeros((0, len(joints))), 'velocity': np.zeros((0, len(joints)))}
    return _read(block, rows, joint_state_layout, take, single, JOINT_STATE, empty)


def imu_readings(block: Block, rows: IntArray) -> Readings:
    """Imu messages at ``rows``: gyro and accel (N, 3), NaN where the message says it has none."""

    def take(part: Block, layout: Layout) -> dict[str, Any]:
        columns = {}
        for name in ('gyro', 'accel'):
            grid = _floats(part, layout, name)
            absent = _floats(part, layout, f'{name}_covariance')[:, 0] == -1.0
            if absent.any():
                grid[absent] = np.nan
            columns[name] = grid
        return columns

    def single(msg: Any, log_ns: int) -> tuple[int, dict[str, Any]]:
        sample = messages.imu_sample(msg)
        return sample.stamp_ns, {'gyro': sample.gyro, 'accel': sample.accel}

    empty = {'gyro': np.zeros((0, 3)), 'accel': np.zeros((0, 3))}
    return _read(block, rows, imu_layout, take, single, IMU, empty)


def tick_readings(block: Block, rows: IntArray, count: int, type_name: str) -> Readings:
    """Int64MultiArray or Int32MultiArray at ``rows``: counts (N, W); stamped by their log time."""
    size = TICKS[type_name]

    def take(part: Block, layout: Layout) -> dict[str, Any]:
        if layout.count['data'] != count:
            raise messages.MalformedMessage('wheel_ticks length differs from wheels')
        raw = _bytes(part, layout.offset['data'], size * count)
        return {'counts': raw.view(f'<i{size}').astype(np.int64)}

    def single(msg: Any, log_ns: int) -> tuple[int, dict[str, Any]]:
        sample = messages.tick_sample(msg, count, log_ns)
        return sample.stamp_ns, {'counts': sample.counts}

    find = functools.partial(multi_array_layout, item_size=size)
    empty = {'counts': np.zeros((0, count), dtype=np.int64)}
    return _read(block, rows, find, take, single, type_name, empty, stamped=False)


def command_readings(block: Block, rows: IntArray, order: tuple[str, ...],
                     joints: tuple[str, ...], type_name: str) -> Readings:
    """Wheel commands at ``rows``, JointState or Float64MultiArray in ``order``: rate (N, W).

    NaN where not given; the log time stands for a stamp of 0.
    """
    if type_name == JOINT_STATE:
        found = wheel_readings(block, rows, joints)
        stamp = np.where(found.stamp_ns == 0, block.log_ns[found.row], found.stamp_ns)
        return Readings(found.row, stamp, {'rate': found.values['velocity']}, found.rejected)
    columns = [order.index(joint) for joint in joints]

    def take(part: Block, layout: Layout) -> dict[str, Any] | None:
        if layout.count['data'] != len(order):
            raise messages.MalformedMessage(f'wheel_commands has {layout.count["data"]} entries '
                                            f'instead of {len(order)}')
        return {'rate': _floats(part, layout, 'data')[:, columns]}

    def single(msg: Any, log_ns: int) -> tuple[int, dict[str, Any]]:
        return log_ns, {'rate': messages.rates_of_array(msg, order, joints)}

    find = functools.partial(multi_array_layout, item_size=8)
    empty = {'rate': np.zeros((0, len(joints)))}
    return _read(block, rows, find, take, single, RATES, empty, stamped=False)


def message(data: bytes, type_name: str) -> Any:
    """One decoded message of a standard type; MalformedMessage where the bytes do not fit."""
    store = _typestore()
    if type_name not in store.types:
        raise messages.MalformedMessage(f'unknown type {type_name}')
    try:
        return store.deserialize_cdr(data, type_name)
    except MemoryError:
        raise messages.MalformedMessage('the bytes do not fit the type') from None
    except Exception as error:  # rosbags raises many kinds on damaged bytes
        raise messages.MalformedMessage('the bytes do not fit the type') from error


@functools.lru_cache(maxsize=1)
def _typestore() -> Any:
    from rosbags.typesys import Stores, get_typestore
    return get_typestore(Stores.ROS2_JAZZY)


def _read(block: Block, rows: IntArray, find: Callable[[bytes], Layout],
          take: Callable[[Block, Layout], dict[str, Any] | None], single: Callable[..., Any],
          type_name: str, empty: dict[str, Any], *, stamped: bool = True) -> Readings:
    result = Readings(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), empty)
    parts: list[Shape] = []
    for layout, chosen in _same_layout(block, rows, find):
        part = block.take(chosen)
        if layout is None:
            _one_by_one(part, chosen, single, type_name, result, parts)
            continue
        try:
            columns = take(part, layout)
        except messages.MalformedMessage as error:
            result.rejected += [str(error)] * len(chosen)
            continue
        if columns is None:
            result.foreign += len(chosen)
            continue
        parts.append((chosen, _stamps(part, layout) if stamped else part.log_ns, columns))
    if parts:
        result.row = np.concatenate([p[0] for p in parts])
        result.stamp_ns = np.concatenate([p[1] for p in parts])
        result.values = {name: np.concatenate([p[2][name] for p in parts]) for name in empty}
        if len(parts) > 1:
            order = np.argsort(result.row, kind='stable')
            result.row, result.stamp_ns = result.row[order], result.stamp_ns[order]
            result.values = {name: array[order] for name, array in result.values.items()}
    return result


def _one_by_one(part: Block, chosen: IntArray, single: Callable[..., Any], type_name: str,
                result: Readings, parts: list[Shape]) -> None:
    for index in range(len(part)):
        try:
            found = single(message(part.payload(index), type_name), int(part.log_ns[index]))
        except messages.MalformedMessage as error:
            result.rejected.append(str(error))
            continue
        if found is None:
            result.foreign += 1
            continue
        parts.append((chosen[index:index + 1], np.array([found[0]], dtype=np.int64),
                      {name: value[None] for name, value in found[1].items()}))


def _same_layout(block: Block, rows: IntArray,
                 find: Callable[[bytes], Layout]) -> Iterator[tuple[Layout | None, IntArray]]:
    """Groups of rows that share a layout; None for those to be read one by one."""
    rest, tries = rows, 0
    while len(rest):
        tries += 1
        first = int(rest[0])
        try:
            layout = find(block.payload(first)) if tries <= _LAYOUTS_A_BLOCK else None
        except NoLayout:
            layout = None
        if layout is None and tries > _LAYOUTS_A_BLOCK:
            yield None, rest
            return
        alike = block.length[rest] == block.length[first]
        if layout is None:
            alike[:] = False
            alike[0] = True
            yield None, rest[:1]
        else:
            alike[alike] = _matches(block, rest[alike], layout)
            yield layout, rest[alike]
        rest = rest[~alike]


def _matches(block: Block, rows: IntArray, layout: Layout) -> Any:
    """Which rows have the same fixed bytes as the first row."""
    same = np.ones(len(rows), dtype=bool)
    for start, stop in _merged(layout.fixed):
        found = rows_at(block.data, block.offset[rows] + start, stop - start)
        same &= (found == found[0]).all(axis=1)
    return same


def _merged(spans: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Adjacent spans joined (gaps up to 3 bytes are padding, not compared)."""
    joined: list[tuple[int, int]] = []
    for start, stop in spans:
        if joined and joined[-1][1] == start:
            joined[-1] = (joined[-1][0], stop)
        else:
            joined.append((start, stop))
    return joined


def _bytes(part: Block, offset: int, width: int) -> Any:
    return rows_at(part.data, part.offset + offset, width)


def _floats(part: Block, layout: Layout, name: str) -> FloatArray:
    count = layout.count[name]
    grid: FloatArray = _bytes(part, layout.offset[name], 8 * count).view('<f8').reshape(-1, count)
    return grid


def _stamps(part: Block, layout: Layout) -> IntArray:
    pair = _bytes(part, layout.offset['stamp'], 8)
    seconds = np.ascontiguousarray(pair[:, :4]).view('<i4').reshape(-1).astype(np.int64)
    fraction = np.ascontiguousarray(pair[:, 4:]).view('<u4').reshape(-1).astype(np.int64)
    return seconds * NANOSECONDS + fraction


def header_stamps(block: Block, rows: IntArray) -> IntArray | None:
    """Header stamps [ns] (N,) of messages that begin with a std_msgs/Header.

    None where a message is too short or not little-endian.
    """
    if len(rows) == 0 or int(block.length[rows].min()) < 12:
        return None
    if (rows_at(block.data, block.offset[rows], 2)[:, 1] != 1).any():
        return None
    return _stamps(block.take(rows), Layout(offset={'stamp': 4}))
