"""Block ``drive`` of the robot file: rates, limits and stopping of the drive node."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray, IntArray, frozen_floats, parameter

_AXES = '(vx, vy, yaw rate); empty = no limit'
_LIMITS = ('max_velocity', 'max_acceleration', 'max_deceleration', 'max_jerk')


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DriveConfig:
    """How commands arrive, what is allowed, and when the wheels stop.

    The limits are three numbers (vx, vy, yaw rate) each, stored as (3,) with inf for 'no limit';
    with ``limit_shape`` ellipse they are the half axes of an ellipsoid, with box the half sides.
    """

    rate: float = parameter('float', 'Hz', 'rate of wheel_commands, also when idle', default=50.0,
                            low=1.0, high=1000.0, live=True)
    start_enabled: bool = parameter('bool', '', 'drive at once, without a call of ~/enable',
                                    default=True)
    cmd_vel_type: str = parameter(
        'str', '', 'message type of cmd_vel; auto = what the publishers send',
        default='auto', choices=('auto', 'twist', 'twist_stamped'))
    cmd_vel_reliability: str = parameter(
        'str', '', 'how cmd_vel is subscribed; best_effort for micro-ROS publishers',
        default='reliable', choices=('reliable', 'best_effort'))
    command_type: str = parameter(
        'str', '', 'message type of wheel_commands', default='joint_state',
        choices=('joint_state', 'float64_multi_array'))
    command_joints: tuple[str, ...] = parameter(
        'strs', '', 'order of the wheels in wheel_commands, as in the controller\'s "joints"; '
        'empty = wheels.joint', default=())
    command_timeout: float = parameter(
        'float', 's', 'decelerate to standstill this long after the last cmd_vel arrived',
        default=0.5, low=0.02, high=10.0, live=True)
    clock_timeout: float = parameter(
        'float', 's', 'zeros when a simulated clock stands still for this long of real time; '
        '0 = never', default=1.0, low=0.0, high=60.0, live=True)
    max_velocity: FloatArray = parameter(
        'floats', 'm/s, m/s, rad/s', f'largest twist {_AXES} but that of the wheels',
        default=(), low=0.0, open_low=True, live=True)
    max_acceleration: FloatArray = parameter(
        'floats', 'm/s^2, m/s^2, rad/s^2', f'largest change of the twist {_AXES}',
        default=(2.0, 2.0, 4.0), low=0.0, open_low=True, live=True)
    max_deceleration: FloatArray = parameter(
        'floats', 'm/s^2, m/s^2, rad/s^2', f'the same while the base gets slower {_AXES}',
        default=(3.0, 3.0, 6.0), low=0.0, open_low=True, live=True)
    max_jerk: FloatArray = parameter(
        'floats', 'm/s^3, m/s^3, rad/s^3', f'largest change of the acceleration {_AXES}',
        default=(30.0, 30.0, 60.0), low=0.0, open_low=True, live=True)
    limit_shape: str = parameter(
        'str', '', 'whether diagonal motion may add up (box) or not (ellipse)',
        default='ellipse', choices=('ellipse', 'box'), live=True)
    keep_yaw: bool = parameter(
        'bool', '', 'when a wheel would be too fast, slow the translation down before the yaw',
        default=False, live=True)

    def __post_init__(self) -> None:
        for key in _LIMITS:
            value = getattr(self, key)
            if len(value) not in (0, 3):
                raise ConfigError(key, [float(v) for v in value], 'must have three entries '
                                  '(vx, vy, yaw rate), or none for no limit')
            object.__setattr__(self, key, frozen_floats(value if len(value) else [np.inf] * 3))

    def order_of(self, joints: tuple[str, ...]) -> IntArray:
        """Index (W,) of the wheels in ``joints`` in the order in which commands are sent.

        Raises ConfigError where ``command_joints`` does not name every wheel exactly once.
        """
        wanted = self.command_joints or joints
        if sorted(wanted) != sorted(joints):
            raise ConfigError('command_joints', list(wanted),
                              f'must name every wheel once: {", ".join(joints)}')
        return np.array([joints.index(name) for name in wanted], dtype=np.int64)
