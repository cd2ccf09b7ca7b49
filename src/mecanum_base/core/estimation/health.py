"""What the estimator says about itself: counters, biases and what it cannot see."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

STREAMS = ('joint_states', 'wheel_ticks', 'imu', 'wheel_commands', 'set_pose', 'odometry_reset')


@dataclass(frozen=True, slots=True)
class Health:
    """State of the estimator at one moment, for diagnostics and summaries.

    ``received`` and ``used`` count samples by stream, ``rejected`` by (stream, reason). ``imu`` is
    one of none, gyro, gyro + accelerometer, lost. Biases in rad/s and m/s^2 with their standard
    deviations. ``restarts`` counts new beginnings after clock jumps or broken numbers.
    """

    received: dict[str, int]
    used: dict[str, int]
    rejected: dict[tuple[str, str], int]
    imu: str
    gyro_bias: float
    gyro_bias_sigma: float
    accel_bias: tuple[float, float]
    accel_bias_sigma: tuple[float, float]
    standstill: bool
    stamp_jitter: float
    restarts: int
    notes: tuple[str, ...]


class Counters:
    """Counts of samples received, used and rejected."""

    def __init__(self) -> None:
        self.received: Counter[str] = Counter()
        self.used: Counter[str] = Counter()
        self.rejected: Counter[tuple[str, str]] = Counter()

    def receive(self, stream: str) -> None:
        """One more sample of ``stream`` arrived."""
        self.received[stream] += 1

    def use(self, stream: str) -> None:
        """One more sample of ``stream`` was used."""
        self.used[stream] += 1

    def reject(self, stream: str, reason: str) -> None:
        """One more sample of ``stream`` was rejected for ``reason``."""
        self.rejected[stream, reason] += 1
