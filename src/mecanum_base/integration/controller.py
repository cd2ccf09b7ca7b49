"""Convert the YAML of ros2_controllers' mecanum_drive_controller into a robot file.

That controller knows one radius and the sum lx + ly of the half distances only. With rollers at 45
degrees this is all that odometry needs, so the conversion is exact for driving; what it cannot
know (lx and ly apart, rollers, counts, IMU) comes back as warnings, and what has no default is
left as a line to fill in. Its frame offset means: the twist at the wheels' centre is
R(theta) (vx, vy) + (offset_y w, -offset_x w).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mecanum_base.core.errors import ConfigError

ORDER = ('front_left', 'front_right', 'rear_left', 'rear_right')
SIDES = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0))  # signs of x, y in that order
_SUM = 'sum_of_robot_center_projection_on_X_Y_axis'


def find_controller(document: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """(name, parameters) of the mecanum drive controller in a controller_manager YAML.

    Raises ConfigError where no block holds wheel joint names and kinematics, or several do.
    """
    found = {}
    for name, block in document.items():
        parameters = block.get('ros__parameters') if isinstance(block, Mapping) else None
        if isinstance(parameters, Mapping) and 'kinematics' in parameters and any(
                f'{side}_wheel_command_joint_name' in parameters for side in ORDER):
            found[str(name)] = dict(parameters)
    if not found:
        raise ConfigError('controller file', sorted(str(k) for k in document),
                          'must have a block with front_left_wheel_command_joint_name and '
                          'kinematics (mecanum_drive_controller)')
    if len(found) > 1:
        raise ConfigError('controller file', sorted(found), 'must hold one mecanum controller')
    return next(iter(found.items()))


def robot_from_controller(parameters: Mapping[str, Any], *, counts_per_revolution: float | None
                          = None) -> tuple[dict[str, Any], list[str]]:
    """(robot mapping, warnings) for the parameters of a mecanum_drive_controller.

    Raises ConfigError for a missing joint name, radius or lx + ly, which that controller itself
    accepts as 0 and then divides by.
    """
    kinematics = parameters.get('kinematics')
    if not isinstance(kinematics, Mapping):
        raise ConfigError('kinematics', kinematics, 'must be a block of keys and values')
    radius = _positive(kinematics, 'wheels_radius')
    total = _positive(kinematics, _SUM)
    joints = [_joint(parameters, side) for side in ORDER]
    offset = kinematics.get('base_frame_offset') or {}
    x, y, axle = _columns(total / 2.0, [float(offset.get(k, 0.0)) for k in ('x', 'y', 'theta')])
    warnings = [
        f'only lx + ly = {total:g} m is known: lx = ly = {total / 2.0:g} m is assumed. Odometry '
        'of 45 degree rollers does not change with the split; loads and pictures do',
        'roller_count is unknown (0): sideways travel over-reads by 1 to 3 % until it is given',
        'the mount of the IMU is unknown: imu.xyz and imu.rpy are 0',
    ]
    if counts_per_revolution is None:
        warnings.append('encoder.counts_per_revolution is unknown and must be filled in')
    mapping: dict[str, Any] = {
        'wheels': {'joint': joints, 'x': x, 'y': y, 'axle': axle,
                   'roller': [math.pi / 4, -math.pi / 4, -math.pi / 4, math.pi / 4],
                   'radius': [radius] * 4, 'roller_count': [0] * 4},
        'encoder': {'source': 'joint_states', 'counts_per_revolution': counts_per_revolution},
        'imu': {'xyz': [0.0, 0.0, 0.0], 'rpy': [0.0, 0.0, 0.0]},
    }
    drive = _limits(parameters, warnings)
    if drive:
        mapping['drive'] = drive
    if float(parameters.get('reference_timeout', 0.0)) == 0.0:
        warnings.append('reference_timeout is 0, so that controller used each message once; '
                        'drive_node times out 0.5 s after the last message')
    for key in ('odom_frame_id', 'base_frame_id', 'enable_odom_tf'):
        if key in parameters:
            mapping[key] = parameters[key]
    if parameters.get('tf_frame_prefix_enable', True) and parameters.get('tf_frame_prefix'):
        mapping['tf_frame_prefix'] = str(parameters['tf_frame_prefix'])
    return mapping, warnings


def _columns(half: float, offset: list[float]) -> tuple[list[float], list[float], list[float]]:
    shift_x, shift_y, theta = offset
    cosine, sine = math.cos(theta), math.sin(theta)
    x, y = [], []
    for front, left in SIDES:  # wheel in the axes of the wheels' centre, turned back by theta
        along, across = front * half - shift_x, left * half - shift_y
        x.append(cosine * along + sine * across)
        y.append(-sine * along + cosine * across)
    return x, y, [math.pi / 2 - theta] * 4


def _positive(kinematics: Mapping[str, Any], key: str) -> float:
    value = kinematics.get(key)
    if value is None:
        raise ConfigError.missing(f'kinematics.{key}', 'the controller cannot drive without it',
                                  'm')
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value > 0.0:
        raise ConfigError(f'kinematics.{key}', value, 'must be > 0', 'm')
    return float(value)


def _joint(parameters: Mapping[str, Any], side: str) -> str:
    """The state joint where it is named apart from the command joint, as that controller does."""
    state = parameters.get(f'{side}_wheel_state_joint_name')
    name = state or parameters.get(f'{side}_wheel_command_joint_name')
    if not isinstance(name, str) or not name:
        raise ConfigError.missing(f'{side}_wheel_command_joint_name', 'joint name of the wheel')
    return name


LIMITS = {  # ours: theirs
    'max_velocity': 'max_velocity',
    'max_acceleration': 'max_acceleration',
    'max_deceleration': 'max_deceleration',
    'max_jerk': 'max_jerk',
}


def _limits(parameters: Mapping[str, Any], warnings: list[str]) -> dict[str, list[float]]:
    """Limits per axis [vx, vy, wz]; an axis without a limit leaves the whole row out."""
    found: dict[str, list[float]] = {}
    for ours, theirs in LIMITS.items():
        row = []
        for axis in (('linear', 'x'), ('linear', 'y'), ('angular', 'z')):
            block = parameters.get(axis[0])
            leaf = block.get(axis[1]) if isinstance(block, Mapping) else None
            value = leaf.get(theirs) if isinstance(leaf, Mapping) else None
            row.append(abs(float(value)) if isinstance(value, (int, float)) else math.nan)
        if all(math.isfinite(v) for v in row):
            found[ours] = row
        elif any(math.isfinite(v) for v in row):
            warnings.append(f'{theirs} is given for some axes only and was left out')
    return found
