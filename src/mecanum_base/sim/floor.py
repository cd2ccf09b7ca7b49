"""The floor of a scenario: slope, patches of other friction, waves, ramps and walls.

The floor frame is the frame the run starts in: base_link at 0, 0, 0. A constant slope turns
gravity instead of the frame, so distances are measured along the floor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray, parameter
from mecanum_base.sim.randomness import stream


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A piece of floor with its own friction: a rectangle (x, y) or a disc (centre, radius)."""

    friction: float = parameter('float', '', 'sliding friction coefficient', low=0.0, high=5.0)
    name: str = parameter('str', '', 'what it is', default='')
    x: FloatArray = parameter('floats', 'm', 'from, to', default=())
    y: FloatArray = parameter('floats', 'm', 'from, to', default=())
    centre: FloatArray = parameter('floats', 'm', 'centre x, y of a disc', default=())
    radius: float = parameter('float', 'm', 'of a disc', default=0.0, low=0.0)
    static_ratio: float = parameter('float', '', 'static over sliding friction', default=1.1,
                                    low=1.0, high=3.0)
    drag: float = parameter('float', '', 'roller drag times this', default=1.0, low=0.0,
                            high=100.0)

    def __post_init__(self) -> None:
        disc = len(self.centre) > 0
        if disc and (len(self.x) or len(self.y)):
            raise ConfigError('centre', list(self.centre), 'must not stand beside x and y', 'm')
        for key, wanted in (('centre', 2 if disc else 0), ('x', 0 if disc else 2),
                            ('y', 0 if disc else 2)):
            value = getattr(self, key)
            if len(value) != wanted:
                raise ConfigError(key, [float(v) for v in value],
                                  'must have two entries: x and y = [from, to], or centre', 'm')
            if wanted and key != 'centre' and value[0] > value[1]:
                raise ConfigError(key, [float(v) for v in value], 'must run from low to high', 'm')
        if disc and not self.radius > 0.0:
            raise ConfigError('radius', self.radius, 'must be > 0 for a disc', 'm')

    def row(self) -> list[float]:
        """The patch for the kernel (ground.PATCH numbers)."""
        shape = ([1.0, *map(float, self.centre), self.radius, 0.0] if len(self.centre)
                 else [0.0, *map(float, self.x), *map(float, self.y)])
        return [*shape, self.friction * self.static_ratio, self.friction, self.drag]


@dataclass(frozen=True, slots=True, eq=False)
class Ramp:
    """A strip of constant grade: ``begin`` and ``end`` [m] along ``direction`` [rad]."""

    begin: float = parameter('float', 'm', 'where it begins along its direction')
    end: float = parameter('float', 'm', 'where it ends')
    grade: float = parameter('float', '', 'rise over run', low=-0.3, high=0.3)
    direction: float = parameter('float', 'rad', 'uphill direction in the floor', default=0.0)

    def __post_init__(self) -> None:
        if self.end <= self.begin:
            raise ConfigError('end', self.end, f'must be > begin = {self.begin:g}', 'm')

    def row(self) -> list[float]:
        """The ramp for the kernel (ground.RAMP numbers)."""
        return [math.cos(self.direction), math.sin(self.direction), self.begin, self.end,
                self.grade, 0.0]


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """A straight wall through ``point`` [m]; ``facing`` [rad] points into the free space."""

    point: FloatArray = parameter('floats', 'm', 'a point x, y of the wall')
    facing: float = parameter('float', 'rad', 'direction of the free space seen from the wall')

    def __post_init__(self) -> None:
        if len(self.point) != 2:
            raise ConfigError('point', [float(v) for v in self.point], 'must have two entries',
                              'm')

    def row(self) -> list[float]:
        """The wall for the kernel (layout.WALL numbers)."""
        nx, ny = math.cos(self.facing), math.sin(self.facing)
        return [nx, ny, nx * float(self.point[0]) + ny * float(self.point[1])]


@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """Everything below (and around) the robot; the default is level, even and bare."""

    slope: float = parameter('float', 'rad', 'constant slope', default=0.0, low=0.0, high=0.5)
    slope_direction: float = parameter('float', 'rad', 'uphill direction', default=0.0)
    warp: float = parameter('float', 'm', 'unevenness, standard deviation of the height',
                            default=0.0, low=0.0, high=0.05)
    warp_length: float = parameter('float', 'm', 'shortest wave of the unevenness', default=1.0,
                                   low=0.05)
    patches: tuple[Patch, ...] = ()
    ramps: tuple[Ramp, ...] = ()
    walls: tuple[Wall, ...] = ()
    waves: list[float] = field(default_factory=list)  # rows of ground.WAVE numbers, added to warp

    def wave_rows(self, seed: int) -> list[float]:
        """Waves for the kernel: those given, and four drawn from the seed for ``warp``."""
        rows = list(self.waves)
        if self.warp > 0.0:
            draw = stream(seed, 'floor warp')
            for k in range(4):
                length = self.warp_length * (1.0 + k)
                bearing = float(draw.random()) * 2.0 * math.pi
                number = 2.0 * math.pi / length
                rows += [self.warp * math.sqrt(0.5), number * math.cos(bearing),
                         number * math.sin(bearing), float(draw.random()) * 2.0 * math.pi]
        return rows
