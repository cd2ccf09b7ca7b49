"""Block ``driver`` of a scenario file: what the base is told to do."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray, nearest, parameter, read_section
from mecanum_base.sim import curves
from mecanum_base.sim.driver import Driver, Follower, Idle, Script, Twist
from mecanum_base.sim.randomness import stream


@dataclass(frozen=True, slots=True, eq=False)
class Follow:
    """Settings all kinds of closed-loop driving share."""

    speed: float = parameter('float', 'm/s', 'largest speed along the path', default=0.5,
                             low=0.0, open_low=True)
    turn_speed: float = parameter('float', 'rad/s', 'largest yaw rate on the path', default=0.8,
                                  low=0.0, open_low=True)
    accel: float = parameter('float', 'm/s2', 'largest acceleration on the path', default=0.5,
                             low=0.0, open_low=True)
    wait: float = parameter('float', 's', 'standing still first', default=1.5, low=0.0)
    gain: float = parameter('float', '1/s', 'feedback of the true pose', default=1.5, low=0.0,
                            high=20.0)
    repeat: bool = parameter('bool', '', 'start again when the path is done', default=False)
    spin: float = parameter('float', 'rad/s', 'yaw rate on circle and figure8', default=0.0)
    radius: float = parameter('float', 'm', 'of the circle', default=1.0, low=0.0, open_low=True)
    length: float = parameter('float', 'm', 'of the figure8', default=4.0, low=0.0,
                              open_low=True)
    width: float = parameter('float', 'm', 'of the figure8', default=2.0, low=0.0, open_low=True)
    ramp: float = parameter('float', 's', 'to full speed on circle and figure8', default=2.0,
                            low=0.0, open_low=True)
    area: FloatArray = parameter('floats', 'm', 'wander within x from, to, y from, to',
                                 default=(-3.0, 3.0, -3.0, 3.0))
    pause: float = parameter('float', 's', 'longest pause at a point of wander', default=2.0,
                             low=0.0)

    def __post_init__(self) -> None:
        if len(self.area) != 4 or self.area[0] > self.area[1] or self.area[2] > self.area[3]:
            raise ConfigError('area', [float(v) for v in self.area],
                              'must be [x from, x to, y from, y to]', 'm')


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """One line of a script."""

    seconds: float = parameter('float', 's', 'how long', low=0.0)
    twist: FloatArray = parameter('floats', 'm/s, m/s, rad/s', 'vx, vy, wz in base_link')
    name: str = parameter('str', '', 'name of the phase that begins here, for reports',
                          default='')

    def __post_init__(self) -> None:
        if len(self.twist) != 3:
            raise ConfigError('twist', [float(v) for v in self.twist], 'must have three entries',
                              'm/s, m/s, rad/s')


@dataclass(frozen=True, slots=True, eq=False)
class ScriptLimits:
    """Keys of ``driver`` beside ``script``."""

    accel: FloatArray = parameter('floats', 'm/s2, m/s2, rad/s2', 'largest change of the twist; '
                                  '0 = jump', default=(1.0, 1.0, 2.0), low=0.0)
    repeat: bool = parameter('bool', '', 'start again when the script is done', default=False)

    def __post_init__(self) -> None:
        if len(self.accel) != 3:
            raise ConfigError('accel', [float(v) for v in self.accel], 'must have three entries',
                              'm/s2, m/s2, rad/s2')


KINDS = ('script', 'points', 'circle', 'figure8', 'wander')
_WANDER = 400  # points drawn, enough for an hour


@dataclass(frozen=True, slots=True, eq=False)
class Driving:
    """A checked block ``driver``; :meth:`driver` makes a fresh driver of it."""

    kind: str = 'idle'
    script: tuple[Segment, ...] = ()
    limits: ScriptLimits | None = None
    points: tuple[tuple[float, float, float, float], ...] = ()
    follow: Follow | None = None

    def driver(self, seed: int) -> Driver:
        """A driver that starts from the beginning; ``seed`` draws the points of wander."""
        if self.kind == 'script' and self.limits is not None:
            ax, ay, aw = (float(v) for v in self.limits.accel)
            return Script([(s.seconds, _three(s.twist)) for s in self.script], (ax, ay, aw),
                          repeat=self.limits.repeat)
        follow = self.follow
        if follow is None:
            return Idle()
        if self.kind == 'circle':
            curve = curves.circle(follow.radius, follow.speed, follow.spin, follow.ramp)
        elif self.kind == 'figure8':
            curve = curves.figure8(follow.length, follow.width, follow.speed, follow.spin,
                                   follow.ramp)
        else:
            points = _wander(follow, seed) if self.kind == 'wander' else list(self.points)
            curve = curves.legs(points, follow.speed, follow.turn_speed, follow.accel,
                                repeat=follow.repeat)
        fast = 1.3 * follow.speed + 0.2
        turn = 1.3 * max(follow.turn_speed, abs(follow.spin)) + 0.2
        return Follower(curve, follow.wait, follow.gain, (fast, fast, turn))


def _three(values: FloatArray) -> Twist:
    return float(values[0]), float(values[1]), float(values[2])


def _wander(follow: Follow, seed: int) -> list[tuple[float, float, float, float]]:
    draw, points, yaw = stream(seed, 'wander'), [], 0.0
    for _ in range(_WANDER):
        yaw += float(draw.uniform(-math.pi, math.pi))
        points.append((float(draw.uniform(follow.area[0], follow.area[1])),
                       float(draw.uniform(follow.area[2], follow.area[3])), yaw,
                       float(draw.uniform(0.0, follow.pause))))
    return points


def read_driving(block: object, path: str) -> Driving:
    """The block ``driver`` of a scenario file; ConfigError where it breaks a rule."""
    if not isinstance(block, Mapping):
        raise ConfigError(path, block, 'must be a block of keys and values')
    kinds = [key for key in block if key in KINDS]
    if len(kinds) != 1:
        hint = next((f' ({key}: {nearest(str(key), list(KINDS))})' for key in block
                     if key not in KINDS and key not in {f.name for f in fields(Follow)}), '')
        raise ConfigError(path, sorted(map(str, block)),
                          f'must name exactly one of {", ".join(KINDS)}{hint}')
    kind = kinds[0]
    rest = {key: value for key, value in block.items() if key != kind}
    if kind == 'script':
        lines = _lines(block[kind], f'{path}.script')
        return Driving('script', tuple(read_section(Segment, line, f'{path}.script[{i}]')
                                       for i, line in enumerate(lines)),
                       read_section(ScriptLimits, rest, path))
    if kind == 'points':
        lines = _lines(block[kind], f'{path}.points')
        points = tuple(_point(line, f'{path}.points[{i}]') for i, line in enumerate(lines))
        return Driving('points', points=points, follow=read_section(Follow, rest, path))
    own = block[kind]
    if not isinstance(own, Mapping):
        raise ConfigError(f'{path}.{kind}', own, 'must be a block of keys and values')
    return Driving(kind, follow=read_section(Follow, {**rest, **own}, f'{path}.{kind}'))


def _lines(value: object, path: str) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise ConfigError(path, value, 'must be a list with at least one entry')
    return value


def _point(value: object, path: str) -> tuple[float, float, float, float]:
    numbers = value if isinstance(value, list) else []
    good = all(isinstance(v, (int, float)) and not isinstance(v, bool) and math.isfinite(v)
               for v in numbers)
    if len(numbers) not in (3, 4) or not good:
        raise ConfigError(path, value, 'must be [x, y, yaw] or [x, y, yaw, pause]',
                          'm, m, rad, s')
    x, y, yaw, pause = (*map(float, numbers), 0.0)[:4]
    if pause < 0.0:
        raise ConfigError(f'{path}[3]', pause, 'must be >= 0', 's')
    return x, y, yaw, pause
