"""A robot file with calibrated constants: only the numbers change, comments and order stay.

    rho = s_x:       radius * rho
    kappa = s_y/s_x: tan(roller) * kappa            (a + d stays the drive direction of the file)
    lambda = s_x/s_w: x, y scaled so that the yaw column of H becomes lambda times the old one
    imu.rpy:          the fitted turn put before the mount of the file
    imu.gyro_scale:   that of the file * the fitted one
    imu.late:         that of the file + the offset found, with the reorder wait it asks for
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import yaml

from mecanum_base.bag.analysis.calibration import GYRO_SCALE, Calibration
from mecanum_base.bag.analysis.fitted_value import Value
from mecanum_base.bag.analysis.wiring_signals import rpy_of
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.robot import Robot

_ROUNDS = 50


def calibrated_wheels(wheels: Wheels, found: Calibration, per_wheel: bool = False) -> Wheels:
    """The wheel table whose odometry is s * (B dphi) for the fitted scales s."""
    forward, sideways, turning = (found.scale(n) for n in ('forward', 'sideways', 'turning'))
    if not found.axes['forward'].given:
        forward = 1.0
    kappa = sideways / forward if found.axes['sideways'].given else 1.0
    radius = wheels.radius * forward
    if per_wheel and found.wheels and all(v.value is not None for v in found.wheels):
        radius = radius * np.array([v.value for v in found.wheels], dtype=float)
    roller = np.arctan2(np.sin(wheels.roller) * kappa, np.cos(wheels.roller))
    changed = dataclasses.replace(wheels, radius=radius, roller=roller)
    if not found.axes['turning'].given:
        return changed
    target = wheels_from_body(wheels)[:, 2] / turning
    lever = 1.0
    for _ in range(_ROUNDS):  # the yaw column is linear in x and y: one step is enough, two sure
        trial = dataclasses.replace(changed, x=wheels.x * lever, y=wheels.y * lever)
        column = wheels_from_body(trial)[:, 2]
        step = float(target @ column) / float(column @ column)
        lever *= step
        if abs(step - 1.0) < 1e-12:
            break
    return dataclasses.replace(changed, x=wheels.x * lever, y=wheels.y * lever)


def roller_text(found: Calibration, wheels: Wheels) -> str:
    """What the fitted lateral factor says about the number of rollers (contact correction)."""
    if not (found.axes['sideways'].given and found.axes['forward'].given):
        return ''
    kappa = found.scale('sideways') / found.scale('forward')
    known = sorted({int(k) for k in wheels.roller_count if k})
    if known:
        return (f'lateral factor {kappa:.4f} on top of the contact correction for '
                f'{known[0]} rollers, which is {_mean_contact(known[0]):.4f}')
    sigma = math.hypot(*(_half(found.axes[n]) for n in ('sideways', 'forward')))
    fitting = [k for k in range(4, 25) if abs(_mean_contact(k) - kappa) <= max(sigma, 0.003)]
    if not fitting:
        return f'lateral factor {kappa:.4f}: no number of rollers explains it alone'
    if len(fitting) > 1:
        return (f'lateral factor {kappa:.4f} +- {sigma:.4f}: the mean contact correction of '
                f'{fitting[0]} to {fitting[-1]} rollers; count them and set roller_count')
    return (f'lateral factor {kappa:.4f}: the mean contact correction of {fitting[0]} rollers is '
            f'{_mean_contact(fitting[0]):.4f}; if the wheels have that many, set roller_count '
            'instead')


def _half(value: Value) -> float:
    """Half the width of an interval."""
    return 0.0 if value.low is None or value.high is None else (value.high - value.low) / 2.0


def _mean_contact(count: int) -> float:
    return math.sin(math.pi / count) / (math.pi / count)


def mounting(found: Calibration, robot: Robot) -> tuple[float, float, float] | None:
    """``imu.rpy`` with the fitted turns; None where none is given or the mount is not the file's.

    Notes for the user are added to ``found``.
    """
    if not found.mount.given:
        return None
    roll, pitch, yaw = rpy_of(found.mount.applied(robot.imu.base_from_sensor()))
    if robot.imu.from_tf:
        found.notes.append(
            f'imu.from_tf is true: imu.rpy is not written; the transform to the IMU should have '
            f'the angles {roll:.4f}, {pitch:.4f}, {yaw:.4f} rad')
        return None
    return roll, pitch, yaw


def imu_keys(found: Calibration, robot: Robot) -> dict[str, str]:
    """Keys of the block ``imu`` that the fit changes, with their new values as YAML."""
    keys: dict[str, str] = {}
    rpy = mounting(found, robot)
    if rpy is not None:
        keys['rpy'] = listed(np.array(rpy))
    for value in found.constants:
        if value.name == GYRO_SCALE and value.value is not None:
            keys['gyro_scale'] = f'{robot.imu.gyro_scale * value.value:.6f}'
    if found.late is not None:
        keys['late'] = f'{found.late:.4f}'
    return keys


def estimator_keys(found: Calibration) -> dict[str, str]:
    """Keys of the block ``estimator`` that the fit changes, with their new values as YAML."""
    return {} if found.reorder_wait is None else {'reorder_wait': f'{found.reorder_wait:.3f}'}


def rewritten(text: str, name: str, changed: Wheels, comment: str,
              imu: dict[str, str] | None = None, estimator: dict[str, str] | None = None) -> str:
    """The robot file ``text`` with the columns of ``changed`` and the keys of the blocks ``imu``
    and ``estimator`` (texts)."""
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    block = _below(root, ('ros__parameters', 'wheels'))
    if block is None:
        raise ConfigError(name, None, 'has no block wheels')
    edits: list[tuple[int, int, str]] = []
    for key, node in block.value:
        if key.value in ('radius', 'roller', 'x', 'y'):
            edits.append(_replaced(text, key, node, listed(getattr(changed, key.value))))
    for other, keys in (('imu', imu), ('estimator', estimator)):
        if keys:
            edits += _block_edits(text, _below(root, ('ros__parameters',)), other, keys)
    for start, end, new in sorted(edits, reverse=True):
        tail = text[start:end]
        text = text[:start] + new + tail[len(tail.rstrip()):] + text[end:]
    return ''.join(f'# {line}\n' for line in comment.splitlines()) + text


def _replaced(text: str, key: Any, node: Any, new: str) -> tuple[int, int, str]:
    """The edit that puts a new value behind a key; a value on the same line keeps its place."""
    if getattr(node, 'flow_style', False):
        return node.start_mark.index, node.end_mark.index, new
    return text.index(':', key.end_mark.index) + 1, node.end_mark.index, ' ' + new


def _block_edits(text: str, parameters: Any, block: str,
                 keys: dict[str, str]) -> list[tuple[int, int, str]]:
    """The edits that set keys of a block: their values, new keys, or a new block."""
    lines = [f'{key}: {value}' for key, value in keys.items()]
    for key, node in parameters.value:
        if key.value != block:
            continue
        if not isinstance(node, yaml.MappingNode):  # `imu:` with nothing below
            return [_replaced(text, key, node, '{' + ', '.join(lines) + '}')]
        there = {inner.value: (inner, old) for inner, old in node.value}
        edits = [_replaced(text, *there[name], keys[name]) for name in keys if name in there]
        new = [f'{name}: {keys[name]}' for name in keys if name not in there]
        return edits + ([_inserted(node, new)] if new else [])
    return [_inserted(parameters, [f'{block}: {{' + ', '.join(lines) + '}'])]


def _inserted(block: Any, lines: list[str]) -> tuple[int, int, str]:
    """The edit that puts more keys first into a mapping."""
    if block.flow_style:
        at = block.start_mark.index + 1
        return at, at, ', '.join(lines) + (', ' if block.value else '')
    at = block.value[0][0].start_mark
    return at.index, at.index, ''.join(f'{line}\n{" " * at.column}' for line in lines)


def _below(root: Any, path: tuple[str, ...]) -> Any:
    """The mapping node at ``path`` below the top key (``/**``)."""
    if not isinstance(root, yaml.MappingNode):
        return None
    for key, value in root.value:
        if key.value in ('/**', '**'):
            node = value
            for name in path:
                node = next((v for k, v in node.value if k.value == name), None) \
                    if isinstance(node, yaml.MappingNode) else None
            return node
    return None


def listed(values: FloatArray) -> str:
    """A YAML list of floats (never whole numbers, which rcl would take for integers)."""
    return '[' + ', '.join(f'{float(v):.9f}'.rstrip('0') + ('0' if f'{float(v):.9f}'.rstrip(
        '0').endswith('.') else '') for v in values) + ']'
