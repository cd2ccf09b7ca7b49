"""The way of a message from sensor to reader: stamp jitter, delay, loss, bursts, reordering."""

from __future__ import annotations

import math

from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.faults import NANOSECONDS, Event
from mecanum_base.sim.randomness import Normals, Uniforms

_SWAP = 1.5  # periods by which every second message is held back while messages are reordered


class Transport:
    """Decides for each message its stamp and when, if ever, it is published (ns, elapsed)."""

    def __init__(self, config: SimConfig) -> None:
        self._config = config
        self.restart()

    def restart(self) -> None:
        """Begin the random streams again."""
        seed = self._config.seed
        self._jitter, self._luck = Normals(seed, 'stamp jitter'), Uniforms(seed, 'transport')
        self._bursts = Uniforms(seed, 'bursts')
        self._burst_end = -1
        self._next_burst = self._draw_burst(0)

    def _draw_burst(self, after_ns: int) -> int:
        if self._config.burst_rate <= 0.0:
            return 1 << 62
        wait = -math.log(1.0 - self._bursts()) / self._config.burst_rate
        return after_ns + round(wait * NANOSECONDS)

    def encoder(self, elapsed_ns: int, index: int, active: dict[str, Event],
                ) -> tuple[int, int | None]:
        """(stamp, publication or None) of the encoder sample ``index`` taken at ``elapsed_ns``."""
        config = self._config
        stamp = elapsed_ns
        if config.stamp_jitter > 0.0:
            stamp += round(config.stamp_jitter * self._jitter() * NANOSECONDS)
        delay = config.encoder_delay
        if config.late_share > 0.0 and self._luck() < config.late_share:
            delay += config.late_time
        if config.missing_share > 0.0 and self._luck() < config.missing_share:
            return stamp, None
        if elapsed_ns >= self._next_burst:
            self._burst_end = self._next_burst + round(config.burst_time * NANOSECONDS)
            self._next_burst = self._draw_burst(self._burst_end)
        if elapsed_ns < self._burst_end or 'encoder_dropped' in active:
            return stamp, None
        if 'encoder_late' in active:
            delay += active['encoder_late'].value
        if 'reorder' in active and index % 2:
            delay += _SWAP / config.encoder_rate
        return stamp, max(elapsed_ns + round(delay * NANOSECONDS), stamp)

    def imu(self, elapsed_ns: int, index: int, active: dict[str, Event],
            ) -> tuple[int, int | None]:
        """(stamp, publication or None) of the IMU sample ``index``."""
        stamp, delay = elapsed_ns, self._config.imu_delay
        if 'imu_dropped' in active:
            return stamp, None
        if 'imu_clock_offset' in active:
            stamp += round(active['imu_clock_offset'].value * NANOSECONDS)
        if 'reorder' in active and index % 2:
            delay += _SWAP / self._config.imu_rate
        return stamp, elapsed_ns + round(delay * NANOSECONDS)
