"""Block ``goal`` of the robot file: potential field, tolerances and obstacles of the goal node."""

from __future__ import annotations

from dataclasses import dataclass

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import parameter


@dataclass(frozen=True, slots=True, eq=False)
class GoalConfig:
    """Settings of the potential field (source D eq. 21-23) and of the node that runs it.

    ``slow_radius`` is K_r and ``stop_radius`` K_stop of models.md section 4. Everything about
    obstacles is our extension: the source names a repulsion and gives no law.
    """

    max_speed: float = parameter('float', 'm/s', 'speed far from the goal (v_max)', default=0.3,
                                 low=0.0, open_low=True, live=True)
    max_yaw_rate: float = parameter('float', 'rad/s', 'largest turning rate (w_max)', default=1.0,
                                    low=0.0, open_low=True, live=True)
    slow_radius: float = parameter(
        'float', 'm', 'distance below which the speed falls with the distance (K_r)', default=0.2,
        low=0.0, open_low=True, live=True)
    stop_radius: float = parameter(
        'float', 'm', 'distance below which the base stands (K_stop), below slow_radius',
        default=0.0, low=0.0, live=True)
    feed_forward: bool = parameter(
        'bool', '', 'add the velocity of a moving goal, so that it is followed without lag',
        default=False, live=True)
    keep_out_radius: float = parameter(
        'float', 'm', 'the centre of the base stays this far from obstacle points', default=0.4,
        low=0.0, open_low=True, live=True)
    influence_radius: float = parameter(
        'float', 'm', 'obstacles repel within this distance, above keep_out_radius', default=0.8,
        low=0.0, open_low=True, live=True)
    repulsion: float = parameter(
        'float', '', 'repulsive speed at the keep-out radius over max_speed', default=1.0, low=0.0,
        high=10.0, live=True)
    position_tolerance: float = parameter('float', 'm', 'goal reached within this distance',
                                          default=0.02, low=0.0, open_low=True, live=True)
    yaw_tolerance: float = parameter('float', 'rad', 'goal reached within this heading error',
                                     default=0.02, low=0.0, open_low=True, live=True)
    rate: float = parameter('float', 'Hz', 'rate of cmd_vel while a goal is pursued', default=20.0,
                            low=1.0, high=1000.0)
    odom_timeout: float = parameter('float', 's', 'odom older than this stops the base',
                                    default=0.5, low=0.0, open_low=True)

    def __post_init__(self) -> None:
        if self.stop_radius >= self.slow_radius:
            raise ConfigError('stop_radius', self.stop_radius,
                              f'must be below slow_radius = {self.slow_radius:g}', 'm')
        if self.influence_radius <= self.keep_out_radius:
            raise ConfigError('influence_radius', self.influence_radius,
                              f'must be above keep_out_radius = {self.keep_out_radius:g}', 'm')
