"""The wheel table: one column a wheel, as in block ``wheels`` of the robot file.

Every roller wheel is described by the same numbers, so mecanum, Swedish (omni) and mixed bases
need no class of their own (Gfrerrer, section 4.1, notation of equation 16):

    (x, y)   wheel centre in base_link [m]            axle    direction of the wheel axle [rad]
    roller   signed angle from the axle to the axis of the roller on the ground [rad]
    radius   height of the wheel axis [m]             positive rate = right hand about the axle

With axle = pi/2 (to the left) a positive rate drives forward. ``roller`` = +-pi/2 is a Swedish
wheel. ``roller`` and ``roller + pi`` are the same roller.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray, IntArray, frozen_floats, parameter

MIN_WHEELS = 3
_PARALLEL = 1e-3  # rad; rollers this parallel to the axle carry no drive at all


@dataclass(frozen=True, slots=True, eq=False)
class Wheels:
    """Columns of the wheel table; every array has shape (W,), W >= 1 here, >= 3 in a robot file.

    Raises ConfigError where a column has another length than ``joint``, a joint name is empty or
    repeated, a radius is not positive or a roller is parallel to its axle.
    """

    joint: tuple[str, ...] = parameter('strs', '', 'joint name of each wheel')
    x: FloatArray = parameter('floats', 'm', 'wheel centre in base_link, forward +')
    y: FloatArray = parameter('floats', 'm', 'wheel centre in base_link, left +')
    axle: FloatArray = parameter(
        'floats', 'rad', 'direction of the wheel axle; pi/2 points left: positive rate = forward')
    roller: FloatArray = parameter(
        'floats', 'rad', 'angle from the axle to the axis of the roller on the ground; '
        '+-pi/2 = Swedish wheel')
    radius: FloatArray = parameter(
        'floats', 'm', 'rolling radius over the rollers', low=0.0, open_low=True)
    roller_count: IntArray = parameter(
        'ints', '', 'rollers of each wheel; 0 = unknown, no contact correction',
        default=(), low=0)
    roller_pin_radius: FloatArray = parameter(
        'floats', 'm', 'distance wheel axis to roller axis; 0 = unknown', default=(), low=0.0)
    max_speed: FloatArray = parameter(
        'floats', 'rad/s', 'largest wheel rate', default=(), low=0.0, open_low=True)

    def __post_init__(self) -> None:
        count = len(self.joint)
        if count < 1:
            raise ConfigError('joint', list(self.joint), 'must name at least one wheel')
        for index, name in enumerate(self.joint):
            if not name:
                raise ConfigError(f'joint[{index}]', name, 'must not be empty')
            if name in self.joint[:index]:
                raise ConfigError(f'joint[{index}]', name, 'must be a name used only once')
        defaults = {'roller_count': 0, 'roller_pin_radius': 0.0, 'max_speed': math.inf}
        for key in ('x', 'y', 'axle', 'roller', 'radius', *defaults):
            column = getattr(self, key)
            if key in defaults and len(column) == 0:
                column = np.full(count, defaults[key])
            if len(column) != count:
                raise ConfigError(key, np.asarray(column).tolist(),
                                  f'must have one entry a wheel: {count} as in joint, '
                                  f'not {len(column)}')
            if key == 'roller_count':
                whole: IntArray = np.array(column, dtype=np.int64)
                whole.setflags(write=False)
                object.__setattr__(self, key, whole)
            else:
                object.__setattr__(self, key, frozen_floats(column))
        for index in range(count):
            self._check_wheel(index)

    def _check_wheel(self, index: int) -> None:
        if not self.radius[index] > 0.0:
            raise ConfigError(f'radius[{index}]', float(self.radius[index]), 'must be > 0', 'm')
        if abs(math.sin(self.roller[index])) < _PARALLEL:
            raise ConfigError(
                f'roller[{index}]', float(self.roller[index]),
                'must not be 0 or pi: rollers parallel to the axle cannot drive', 'rad')
        if self.roller_count[index] in (1, 2):
            raise ConfigError(f'roller_count[{index}]', int(self.roller_count[index]),
                              'must be 0 (unknown) or at least 3')
        pin, count = float(self.roller_pin_radius[index]), int(self.roller_count[index])
        if pin >= self.radius[index]:
            raise ConfigError(f'roller_pin_radius[{index}]', pin,
                              f'must be below the wheel radius {self.radius[index]:g}', 'm')
        if pin and count and pin >= self.radius[index] * math.cos(math.pi / count):
            raise ConfigError(
                f'roller_pin_radius[{index}]', pin,
                f'must be below radius*cos(pi/roller_count) = '
                f'{self.radius[index] * math.cos(math.pi / count):.6g}, else the roller ends in a '
                f'point before the next roller takes over', 'm')

    @property
    def count(self) -> int:
        """Number of wheels W."""
        return len(self.joint)
