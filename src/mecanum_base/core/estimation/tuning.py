"""Block ``estimator`` of the robot file."""

from __future__ import annotations

from dataclasses import dataclass

from mecanum_base.core.parameter import parameter


@dataclass(frozen=True, slots=True, eq=False)
class EstimatorConfig:
    """Settings of the estimator; the defaults suit hobby to industrial bases."""

    reorder_wait: float = parameter(
        'float', 's', 'how long a sample may be late behind the newest stamp of any stream',
        default=0.02, low=0.0, high=1.0)
    min_rate: float = parameter(
        'float', 'Hz', 'rate of predicted odometry while the encoders are silent (data time)',
        default=20.0, low=0.1, high=1000.0)
