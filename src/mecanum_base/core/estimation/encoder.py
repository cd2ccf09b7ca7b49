"""Encoder readings to unwrapped wheel angles, whatever the counter does.

    counts      difference modulo 2^bits, taken as the smaller of both ways round
    positions   difference modulo 2 pi where the source wraps there, else as it is
    velocity    integrated where there is no position: warned of, with inflated uncertainty

The angle of each wheel is a sum of such steps, so a wrap never shows. A step faster than any
wheel could turn re-anchors that wheel (the step is dropped and counted), and so does the first
reading after a wheel was missing for long: nothing is invented.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.records import TickSample, WheelSample

TWO_PI = 2.0 * math.pi
MARGIN = 3.0  # a wheel may show up this many times its top speed over one step
SLACK = 0.02  # s added to the step: stamps jitter
DEFAULT_SPEED = 200.0  # rad/s where the robot file gives no top speed


class Reading(NamedTuple):
    """One frame: ``angle`` (W,) rad since arming, ``valid`` (W,) 1 where it is known.

    ``jumped``: wheels re-anchored in this frame; ``integrated``: speed stood for position.
    """

    stamp_ns: int
    angle: FloatArray
    valid: FloatArray
    jumped: tuple[int, ...]
    integrated: bool


class WheelAngles:
    """Unwraps the readings of W wheels; feed it samples in the order of their stamps."""

    def __init__(self, encoder: EncoderConfig, count: int, max_speed: FloatArray) -> None:
        counts, self._sign = encoder.for_wheels(count)
        self._radian = TWO_PI / counts
        self._span = 2 ** int(encoder.counter_bits)
        self._two_pi = encoder.position_wrap == 'two_pi'
        speed = np.where(np.isfinite(max_speed), max_speed, DEFAULT_SPEED)
        self._fastest = MARGIN * np.maximum(speed, 5.0)
        self._slack = 4.0 * self._radian
        self._least_fast = float(self._fastest.min())
        self._least_slack = float(self._slack.min())
        self._count = count
        self._full = np.ones(count)
        self.restart()

    def restart(self) -> None:
        """Arm again with the next reading; angles go on from where they are."""
        self._angle = np.zeros(self._count)
        self._last = np.full(self._count, math.nan)
        self._ticks: list[int] | None = None
        self._seen = [-1] * self._count
        self._stamp: int | None = None

    @property
    def angle(self) -> FloatArray:
        """Angles (W,) rad since arming."""
        return self._angle

    @property
    def stamp_ns(self) -> int | None:
        """Stamp of the last reading used."""
        return self._stamp

    def absent(self) -> tuple[int, ...]:
        """Indices of wheels that have never been read, while others have."""
        if all(seen < 0 for seen in self._seen):
            return ()
        return tuple(i for i, seen in enumerate(self._seen) if seen < 0)

    def read(self, sample: WheelSample | TickSample) -> Reading | str:
        """The next frame, or why the sample cannot be used."""
        stamp = sample.stamp_ns
        if self._stamp is not None and stamp <= self._stamp:
            return 'duplicate stamp' if stamp == self._stamp else 'stamp before the last'
        if self._plain_step(sample):
            return Reading(stamp, self._angle, self._full, (), False)
        first = self._stamp is None
        dt = 0.0 if first else (stamp - self._stamp) * 1e-9  # type: ignore[operator]
        integrated = False
        if isinstance(sample, TickSample):
            if len(sample.counts) != self._count:
                return 'wrong number of wheels'
            step, valid = self._tick_step(sample)
        else:
            if len(sample.position) != self._count or len(sample.velocity) != self._count:
                return 'wrong number of wheels'
            step, valid, integrated = self._position_step(sample, dt)
            if not valid.any():
                return 'no finite wheel reading'
        jumped: tuple[int, ...] = ()
        if not first:
            size = np.abs(step)
            if valid.all() and (size <= self._fastest * (dt + SLACK) + self._slack).all():
                self._angle = self._angle + step
                self._seen = [stamp] * self._count
                self._stamp = stamp
                return Reading(stamp, self._angle, self._full, (), integrated)
            found = []
            for i in range(self._count):
                if not valid[i]:
                    continue
                gap = dt if self._seen[i] < 0 else (stamp - self._seen[i]) * 1e-9
                if size[i] > self._fastest[i] * (gap + SLACK) + self._slack[i]:
                    step[i] = 0.0
                    found.append(i)
            jumped = tuple(found)
        self._angle = self._angle + np.where(valid, step, 0.0)
        self._seen = [stamp if ok else seen for ok, seen in zip(valid, self._seen)]
        self._stamp = stamp
        return Reading(stamp, self._angle, valid.astype(np.float64), jumped, integrated)

    def _plain_step(self, sample: WheelSample | TickSample) -> bool:
        """The frequent case: positions of all wheels, none further than any wheel can turn."""
        if self._stamp is None or self._two_pi or not isinstance(sample, WheelSample):
            return False
        position, stamp = sample.position, sample.stamp_ns
        if len(position) != self._count or len(sample.velocity) != self._count:
            return False
        step = (position - self._last) * self._sign
        dt = (stamp - self._stamp) * 1e-9
        limit = self._least_fast * (dt + SLACK) + self._least_slack
        for size in step.tolist():
            if not -limit <= size <= limit:  # NaN is none of both
                return False
        self._last = position
        self._angle = self._angle + step
        self._seen = [stamp] * self._count
        self._stamp = stamp
        return True

    def _tick_step(self, sample: TickSample) -> tuple[FloatArray, FloatArray]:
        ticks = sample.counts.tolist()
        last, self._ticks = self._ticks, ticks
        if last is None:
            return np.zeros(self._count), np.ones(self._count, dtype=bool)
        half, span = self._span // 2, self._span
        steps = [(new - old + half) % span - half for new, old in zip(ticks, last)]
        return np.array(steps, dtype=np.float64) * self._radian * self._sign, np.ones(
            self._count, dtype=bool)

    def _position_step(self, sample: WheelSample,
                       dt: float) -> tuple[FloatArray, FloatArray, bool]:
        position = sample.position
        step = (position - self._last) * self._sign
        if self._two_pi:
            step = (step + math.pi) % TWO_PI - math.pi
        valid = np.isfinite(position)
        if valid.all() and self._stamp is not None and np.isfinite(step).all():
            self._last = position
            return step, valid, False
        integrated = False
        if not valid.any() and np.isfinite(sample.velocity).any():
            valid = np.isfinite(sample.velocity)
            step = sample.velocity * self._sign * dt
            integrated = True
        else:
            self._last = np.where(valid, position, self._last)
        return np.where(np.isfinite(step), step, 0.0), valid, integrated
