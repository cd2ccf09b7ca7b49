"""Wheel encoders: counts with their fractions carried, wrap, sign, and the faults of counters.

    counts = floor(sum of increments x counts_per_revolution / 2 pi + start)

A counter starts anywhere (drawn from the seed); a stuck one loses what it misses, a reversed one
counts backwards, a reset one starts again from zero.
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
        self._per_rad = [float(v) / _TURN for v in per_turn]
        self._sign = [int(v) for v in sign]
        self._span = 1 << config.counter_bits
        self._wrap_turn = config.position_wrap == 'two_pi'
        draw = stream(seed, 'encoder start')
        self._start = [float(v) for v in draw.uniform(-10.0, 10.0, count) * per_turn]
        self.restart([0.0] * count)

    def restart(self, angles: list[float]) -> None:
        """Start again at the true wheel angles (W,) rad."""
        self._last = list(angles)
        self._travel = list(self._start)
        self.counts = [math.floor(v) for v in self._travel]
        self._previous = list(self.counts)

    def update(self, angles: list[float], gains: list[float]) -> None:
        """Count up to the true angles (W,) rad; gain 1, 0 (stuck) or -1 (reversed) a wheel."""
        self._previous = self.counts
        counts = []
        for i, angle in enumerate(angles):
            self._travel[i] += gains[i] * (angle - self._last[i]) * self._per_rad[i]
            counts.append(math.floor(self._travel[i]))
        self._last = angles
        self.counts = counts

    def reset(self, wheel: int) -> None:
        """The counter of one wheel starts again from zero."""
        self._travel[wheel] = 0.0
        self.counts[wheel] = 0

    def position(self) -> FloatArray:
        """Joint positions (W,) rad in the joints' own sign, as a driver reports them."""
        values = [s * c / p for s, c, p in zip(self._sign, self.counts, self._per_rad)]
        if self._wrap_turn:
            values = [v % _TURN for v in values]
        return np.array(values)

    def velocity(self, period: float) -> FloatArray:
        """Joint velocities (W,) rad/s: difference of counts over the period [s]."""
        return np.array([s * (c - o) / (p * period) for s, c, o, p in zip(
            self._sign, self.counts, self._previous, self._per_rad)])

    def ticks(self) -> IntArray:
        """Counter values (W,) as the hardware reports them: signed, wrapped at its width."""
        half = self._span // 2
        return np.array([(s * c + half) % self._span - half
                         for s, c in zip(self._sign, self.counts)], dtype=np.int64)
