"""Block ``goal`` of the robot file."""

from __future__ import annotations

from dataclasses import dataclass

from mecanum_base.core.parameter import parameter


@dataclass(frozen=True, slots=True, eq=False)
class GoalConfig:
    """Settings of the goal node (potential field, source D)."""

    max_speed: float = parameter('float', 'm/s', 'speed far from the goal', default=0.3, low=0.0,
                                 open_low=True)
