"""Commands and encoder readings as they come, compared beside the estimator.

    a_k = a_{k-1} + wrap(n_k - n_{k-1}) q s

n raw readings (counts or rad), wrap the smaller way round the counter or, with position_wrap
two_pi, round the circle; q rad a count (1 for positions), s encoder.sign, a wheel angle [rad].
What is compared is said in :mod:`mecanum_base.core.estimation.following`. Nothing here touches
the estimator: late, missing or wrongly stamped commands cannot change an estimate, and a
recording gives the same track with its commands and without. Not modelled: bases that send wheel
speeds in place of positions are not compared.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mecanum_base.core.estimation.following import WINDOW, Following
from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.parameter import FloatArray, IntArray

_TURN = 2.0 * math.pi
_JUMP = 1e3  # rad between two readings: the reading is wrong, its step is left out


class CommandWatch:
    """Says which wheels do not follow their commands; idle until the first command.

    ``joints`` names the wheels of ``encoder``. Commands and readings are those of the topics: the
    sign of the encoder is applied here.
    """

    def __init__(self, joints: Sequence[str], encoder: EncoderConfig) -> None:
        counts, self._sign = encoder.for_wheels(len(joints))
        self._radian = _TURN / counts
        self._span = 1 << int(encoder.counter_bits)
        self._two_pi = encoder.position_wrap == 'two_pi'
        self._joints = tuple(joints)
        self._following = Following(len(joints), self._radian)
        self._waiting: list[tuple[int, FloatArray | IntArray]] = []
        self._last: FloatArray | IntArray | None = None
        self._angle = np.zeros(len(joints))
        self.used = 0  # commands taken

    def commands(self, stamp_ns: IntArray, rate: FloatArray) -> int:
        """Commanded rates (N, W) rad/s; returns how many hold no number and are refused."""
        good = np.isfinite(rate).any(axis=1)
        taken = int(np.count_nonzero(good))
        if taken:
            self.used += taken
            self._following.commands(stamp_ns[good], rate[good] * self._sign)
        return len(stamp_ns) - taken

    def reading(self, stamp_ns: int, value: FloatArray | IntArray) -> None:
        """One encoder message (W,): counts (int64) or angles [rad], NaN where not given."""
        if not self.used:
            return
        self._waiting.append((stamp_ns, value))
        if stamp_ns // WINDOW != self._waiting[0][0] // WINDOW:
            self._release()

    def readings(self, stamp_ns: IntArray, value: FloatArray | IntArray) -> None:
        """Encoder messages (N, W) in order of arrival."""
        if not self.used or not len(stamp_ns):
            return
        if self._waiting:
            self._release()
        self._following.angles(stamp_ns, self._angles(value))

    def flush(self) -> None:
        """The end of the data: compare what still waits."""
        if self._waiting:
            self._release()
        self._following.flush()

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence for each wheel that does not follow at the moment."""
        return tuple(f'wheel {self._joints[i]} does not follow its command'
                     for i in self._following.strays)

    @property
    def strayed(self) -> tuple[tuple[str, int, float], ...]:
        """Joint, first stamp [ns] and seconds in all of each wheel that did not follow."""
        return tuple((joint, first, float(seconds)) for joint, first, seconds in zip(
            self._joints, self._following.first_ns, self._following.seconds) if seconds > 0.0)

    def _release(self) -> None:
        waiting, self._waiting = self._waiting, []
        self._following.angles(np.array([stamp for stamp, _ in waiting], dtype=np.int64),
                               self._angles(np.array([value for _, value in waiting])))

    def _angles(self, value: FloatArray | IntArray) -> FloatArray:
        """Unwrapped angles (N, W) of consecutive readings; NaN where there was none."""
        if self._last is None or self._last.dtype != value.dtype:
            self._last = value[0]
        whole = np.concatenate([self._last[None], value])
        if value.dtype == np.int64:
            step = np.diff(whole, axis=0)  # wraps at 64 bits by itself
            if self._span < 1 << 63:
                half = self._span // 2
                step = (step + half) % self._span - half
            turned = step * self._radian
            good = np.ones(value.shape, dtype=bool)
        else:
            good = np.isfinite(value)
            whole = _filled(whole)
            with np.errstate(all='ignore'):
                turned = np.diff(whole, axis=0)
                if self._two_pi:
                    turned = (turned + math.pi) % _TURN - math.pi
        self._last = whole[-1]
        turned[~(np.abs(turned) <= _JUMP)] = 0.0  # also before the first reading of a wheel
        angle: FloatArray = np.cumsum(np.concatenate([self._angle[None], turned * self._sign]),
                                      axis=0)[1:]
        self._angle = angle[-1].copy()
        angle[~good] = np.nan
        return angle


def _filled(value: FloatArray) -> FloatArray:
    """Every entry that is no number replaced by the last one before it, where there is one."""
    good = np.isfinite(value)
    if good.all():
        return value
    row = np.maximum.accumulate(np.where(good, np.arange(len(value))[:, None], 0), axis=0)
    found: FloatArray = np.take_along_axis(value, row, axis=0)
    return found
