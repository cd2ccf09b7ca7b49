"""Wheel encoders: counts with their fractions carried, wrap, sign, and the faults of counters.

    counts = floor(sum of increments x counts_per_revolution / 2 pi + start)

A counter starts anywhere (drawn from the seed); a stuck one loses what it misses, a reversed one
counts backwards, a reset one starts again from zero. Samples are taken in blocks of any length;
how a run is cut into blocks does not change a bit of the result.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.sim.randomness import stream

_TURN = 2.0 * math.pi


class Encoders:
    """Counters of W wheels; feed true angles in order of time."""

    def __init__(self, config: EncoderConfig, count: int, seed: int) -> None:
        per_turn, sign = config.for_wheels(count)
        self._per_rad = per_turn / _TURN
        self._sign = sign.astype(np.int64)
        self._span = 1 << config.counter_bits if config.counter_bits < 64 else 0
        self._wrap_turn = config.position_wrap == 'two_pi'
        self._start = stream(seed, 'encoder start').uniform(-10.0, 10.0, count) * per_turn
        self.restart(np.zeros(count))

    def restart(self, angles: FloatArray) -> None:
        """Start again at the true wheel angles (W,) rad."""
        self._last, self._travel = np.array(angles), self._start.copy()
        self._counts = np.floor(self._travel).astype(np.int64)

    def count(self, angles: FloatArray, gains: FloatArray) -> tuple[IntArray, IntArray]:
        """(counts, counts before) (N, W) at the true angles (N, W) rad.

        ``gains`` (W,) are 1, 0 (stuck) or -1 (reversed).
        """
        steps = np.diff(angles, axis=0, prepend=self._last[None, :]) * self._per_rad * gains
        travel = np.cumsum(np.vstack([self._travel[None, :], steps]), axis=0)[1:]
        counts = np.floor(travel).astype(np.int64)
        before = np.vstack([self._counts[None, :], counts[:-1]])
        self._last, self._travel, self._counts = angles[-1], travel[-1].copy(), counts[-1].copy()
        return counts, before

    def reset(self, wheel: int) -> None:
        """The counter of one wheel starts again from zero."""
        self._travel[wheel], self._counts[wheel] = 0.0, 0

    def position(self, counts: IntArray) -> FloatArray:
        """Joint positions rad in the joints' own sign, as a driver reports them."""
        angles: FloatArray = self._sign * counts / self._per_rad
        return angles % _TURN if self._wrap_turn else angles

    def velocity(self, counts: IntArray, before: IntArray, period: float) -> FloatArray:
        """Joint velocities rad/s: difference of counts over the period [s]."""
        rates: FloatArray = self._sign * (counts - before) / (self._per_rad * period)
        return rates

    def ticks(self, counts: IntArray) -> IntArray:
        """Counter values as the hardware reports them: signed, wrapped at its width."""
        signed: IntArray = self._sign * counts
        if not self._span:
            return signed
        return (signed + self._span // 2) % self._span - self._span // 2
