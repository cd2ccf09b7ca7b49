"""The carrier table: one column a carrier robot, as in block ``carriers`` of the robot file.

Two differential robots are hinged under a platform (source D). Notation: hinge (x_i, y_i) in
base_link, axle midpoint at (e_i, 0) in the carrier frame (e_i < 0: the axle trails the hinge),
wheels at +-b_i, radius r_i. With e_i = 0 the steering rate drops out of the lateral constraint and
the platform is not omnidirectional, so 0 is refused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.errors import ConfigError, GeometryError
from mecanum_base.core.parameter import FloatArray, frozen_floats, parameter
from mecanum_base.core.platform.hinges import Hinges


@dataclass(frozen=True, slots=True, eq=False)
class Carriers:
    """Columns of the carrier table; every array has shape (C,), C = 2.

    Raises ConfigError on unequal lengths, GeometryError where an axle offset is 0 or the two
    hinges coincide (then yaw cannot be driven; D13-D20 in models.md section 4).
    """

    name: tuple[str, ...] = parameter('strs', '', 'name of each carrier robot')
    x: FloatArray = parameter('floats', 'm', 'hinge in base_link, forward +')
    y: FloatArray = parameter('floats', 'm', 'hinge in base_link, left +')
    axle_offset: FloatArray = parameter(
        'floats', 'm', 'axle midpoint in the carrier frame; < 0 trails the hinge; not 0')
    half_track: FloatArray = parameter(
        'floats', 'm', 'half the distance of the two wheels', low=0.0, open_low=True)
    wheel_radius: FloatArray = parameter('floats', 'm', 'wheel radius', low=0.0, open_low=True)
    left_joint: tuple[str, ...] = parameter('strs', '', 'joint of the left wheel')
    right_joint: tuple[str, ...] = parameter('strs', '', 'joint of the right wheel')
    hinge_joint: tuple[str, ...] = parameter(
        'strs', '', 'joint of the measured hinge angle; "" = not measured', default=())
    initial_angle: FloatArray = parameter(
        'floats', 'rad', 'hinge angle at the start', default=())
    max_speed: FloatArray = parameter(
        'floats', 'rad/s', 'largest wheel rate', default=(), low=0.0, open_low=True)

    def __post_init__(self) -> None:
        count = len(self.name)
        if count != 2:
            raise ConfigError('name', list(self.name), 'must name two carriers')
        for key in ('left_joint', 'right_joint', 'hinge_joint'):
            column = getattr(self, key) or (('',) * count if key == 'hinge_joint' else ())
            if len(column) != count:
                raise ConfigError(key, list(column), f'must have {count} entries as name')
            object.__setattr__(self, key, tuple(column))
        for key, default in (('x', None), ('y', None), ('axle_offset', None),
                             ('half_track', None), ('wheel_radius', None),
                             ('initial_angle', 0.0), ('max_speed', math.inf)):
            column = getattr(self, key)
            if default is not None and len(column) == 0:
                column = np.full(count, default)
            if len(column) != count:
                raise ConfigError(key, np.asarray(column).tolist(),
                                  f'must have {count} entries as name')
            object.__setattr__(self, key, frozen_floats(column))
        joints = [*self.left_joint, *self.right_joint, *(h for h in self.hinge_joint if h)]
        for index, joint in enumerate(joints):
            if not joint or joint in joints[:index]:
                raise ConfigError('left_joint/right_joint/hinge_joint', joint,
                                  'must be a name used only once')
        for index, offset in enumerate(self.axle_offset):
            if offset == 0.0:
                raise GeometryError(f'axle_offset[{index}]', 0.0,
                                    'must not be 0: the platform would not be omnidirectional '
                                    '(the axle must lie beside the hinge)', 'm')
        if math.hypot(self.x[1] - self.x[0], self.y[1] - self.y[0]) < 1e-6:
            raise GeometryError('x/y', [self.x.tolist(), self.y.tolist()],
                                'the hinges coincide: yaw cannot be driven', 'm')

    @property
    def joint(self) -> tuple[str, ...]:
        """Wheel joints left_0, right_0, left_1, right_1: the order of every wheel array."""
        return tuple(name for pair in zip(self.left_joint, self.right_joint) for name in pair)

    @property
    def count(self) -> int:
        """Number of wheels: two a carrier."""
        return 2 * len(self.name)

    @property
    def hinges(self) -> Hinges:
        """Hinge positions and axle offsets, for the model questions of source D."""
        return Hinges(self.x, self.y, self.axle_offset)
