"""Block ``sim`` of the robot file."""

from __future__ import annotations

from dataclasses import dataclass

from mecanum_base.core.parameter import parameter


@dataclass(frozen=True, slots=True, eq=False)
class SimConfig:
    """Settings of the simulated hardware."""

    seed: int = parameter('int', '', 'seed of every random number of the simulation', default=1,
                          low=0)
    publish_clock: bool = parameter('bool', '', 'publish /clock', default=False)
    rate_factor: float = parameter('float', '', 'speed of simulated time over real time',
                                   default=1.0, low=0.0, open_low=True)
    command_timeout: float = parameter(
        'float', 's', 'wheels stop this long after the last wheel_commands', default=0.25,
        low=0.0, open_low=True)
