"""Block ``drive`` of the robot file."""

from __future__ import annotations

from dataclasses import dataclass

from mecanum_base.core.parameter import parameter


@dataclass(frozen=True, slots=True, eq=False)
class DriveConfig:
    """Rates, limits and stopping of the drive node."""

    rate: float = parameter('float', 'Hz', 'rate of wheel_commands, also when idle', default=50.0,
                            low=1.0, high=1000.0)
    start_enabled: bool = parameter('bool', '', 'drive at once, without a call of ~/enable',
                                    default=True)
