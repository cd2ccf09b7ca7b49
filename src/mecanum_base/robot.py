"""One robot: all blocks of a robot file assembled, checked against each other.

The robot file is at once a ROS 2 parameter file and the ``--robot`` file of the command line; the
names of blocks, keys, dataclass fields and ROS 2 parameters are the same. Every node knows all
blocks. :func:`Robot.from_mapping` raises ConfigError; keys outside the known blocks come back as
``ignored`` (a shared Nav2 file may hold them) or, when ``strict``, as an error.
"""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Union

from mecanum_base.core.command.drive import DriveConfig
from mecanum_base.core.command.goal import GoalConfig
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.kinematics.mobility import require_mobile
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import Rule, convert, nearest, parameter, read_section, rules
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.sim.config import SimConfig

Base = Union[Wheels, Carriers]


@dataclass(frozen=True, slots=True, eq=False)
class FrameConfig:
    """Frame names and TF settings: the keys outside any block."""

    odom_frame_id: str = parameter('str', '', 'frame of the odometry', default='odom')
    base_frame_id: str = parameter('str', '', 'frame of the base', default='base_link')
    imu_frame_id: str = parameter('str', '', 'frame of the IMU', default='imu_link')
    enable_odom_tf: bool = parameter('bool', '', 'send the transform odom -> base', default=True)
    tf_frame_prefix: str = parameter('str', '', 'put before frame names', default='')


@dataclass(frozen=True, slots=True, eq=False)
class RecordConfig:
    """Settings of the record node."""

    output: str = parameter('str', '', 'folder of the bag; empty = a new folder by date',
                            default='')
    flush_period: float = parameter('float', 's', 'how often the bag is flushed to disk',
                                    default=0.5, low=0.01, high=60.0)


BLOCKS: dict[str, type[Any]] = {
    'wheels': Wheels,
    'carriers': Carriers,
    'encoder': EncoderConfig,
    'imu': ImuConfig,
    'estimator': EstimatorConfig,
    'drive': DriveConfig,
    'sim': SimConfig,
    'goal': GoalConfig,
    'record': RecordConfig,
}


SHORT_NAMES = ('cmd_vel_type', 'cmd_vel_reliability', 'command_type')
"""Keys of block ``drive`` that may also stand outside it, as the interface contract names them."""


@dataclass(frozen=True, slots=True, eq=False)
class Robot:
    """Everything the robot file says; ``base`` is the wheel or the carrier table."""

    base: Base
    encoder: EncoderConfig
    imu: ImuConfig = field(default_factory=ImuConfig)
    frames: FrameConfig = field(default_factory=FrameConfig)
    estimator: EstimatorConfig = field(default_factory=EstimatorConfig)
    drive: DriveConfig = field(default_factory=DriveConfig)
    sim: SimConfig = field(default_factory=SimConfig)
    goal: GoalConfig = field(default_factory=GoalConfig)
    record: RecordConfig = field(default_factory=RecordConfig)
    ignored: tuple[str, ...] = ()

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any], *, strict: bool = False) -> Robot:
        """Check and assemble; raises ConfigError (GeometryError for a base that cannot drive)."""
        mapping = _with_short_names(mapping)
        frame_rules = rules(FrameConfig)
        ignored = tuple(str(k) for k in mapping if k not in BLOCKS and k not in frame_rules)
        if ignored and strict:
            known = [*BLOCKS, *frame_rules]
            raise ConfigError(ignored[0], mapping[ignored[0]],
                              f'unknown key, {nearest(ignored[0], known)}')
        frames = FrameConfig(**{name: convert(mapping[name], rule, name)
                                for name, rule in frame_rules.items() if name in mapping})
        if 'wheels' in mapping and 'carriers' in mapping:
            raise ConfigError('carriers', '...', 'must not stand beside wheels: a robot has one '
                              'or the other')
        if 'wheels' not in mapping and 'carriers' not in mapping:
            raise _missing_block('wheels', 'the wheel table', ignored)
        if 'encoder' not in mapping:
            raise _missing_block('encoder', 'resolution and wiring of the encoders', ignored)
        kind = 'wheels' if 'wheels' in mapping else 'carriers'
        blocks = {name: read_section(section, mapping.get(name, {}), name)
                  for name, section in BLOCKS.items() if name not in ('wheels', 'carriers')}
        base: Base = read_section(BLOCKS[kind], mapping[kind], kind)
        if isinstance(base, Wheels):
            require_mobile(base)
        try:
            blocks['encoder'].for_wheels(base.count)
        except ConfigError as error:
            raise error.under('encoder') from None
        try:
            blocks['drive'].order_of(base.joint)
        except ConfigError as error:
            raise error.under('drive') from None
        return cls(base=base, frames=frames, ignored=ignored, **blocks)

    def replace(self, **changes: Any) -> Robot:
        """A copy with some blocks replaced."""
        return dataclasses.replace(self, **changes)


def _missing_block(name: str, meaning: str, ignored: tuple[str, ...]) -> ConfigError:
    """The error for a block that is not there; it points at a key that looks like it."""
    for wanted in (name, 'carriers') if name == 'wheels' else (name,):
        close = difflib.get_close_matches(wanted, ignored, n=1, cutoff=0.6)
        if close:
            return ConfigError(close[0], None, f'unknown block, and {wanted!r} is '
                               f'missing: did you mean {wanted!r}?')
    return ConfigError.missing(name, meaning)


def _with_short_names(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """``mapping`` with the short names moved into block ``drive``."""
    moved = {key: value for key, value in mapping.items() if key not in SHORT_NAMES}
    for name in SHORT_NAMES:
        if name in mapping:
            drive = moved.get('drive', {})
            if not isinstance(drive, Mapping) or name in drive:
                raise ConfigError(name, mapping[name], f'must not stand beside drive.{name}')
            moved['drive'] = {**drive, name: mapping[name]}
    return moved


def all_rules() -> dict[str, Rule]:
    """Rule of every parameter by its full name (``wheels.radius``), in the order of the file."""
    found = {f'{block}.{name}': rule for block, section in BLOCKS.items()
             for name, rule in rules(section).items()}
    return {**found, **rules(FrameConfig)}
