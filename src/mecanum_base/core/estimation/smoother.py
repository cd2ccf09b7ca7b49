"""The smoothed track of a recording, piece by piece, from the final rows of the trail.

Slip follows from the smoothed velocity v_s (:mod:`.smoothing`):

    s_i <- s_i - A_i (v_s - v)        sigma_i^2 = A_i P_v A_i' + (5 mm/s)^2    A_i y by 1 + ky

A given pose and a restart end a piece: nothing that comes later changes what lies before. Where
the pieces end depends on the stamps of the rows only, not on how the rows come.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.estimation.layout import VX, VY
from mecanum_base.core.estimation.output import ROOT3, THRESHOLD
from mecanum_base.core.estimation.smoothing import TRACK, look_back
from mecanum_base.core.estimation.trail import WAS_JUDGED, WAS_STILL, WHEELS
from mecanum_base.core.parameter import FloatArray, IntArray

PIECE = 12_000_000_000  # ns handed out at once
AHEAD = 8_000_000_000  # ns of later frames that a frame sees at least: e^-4 of what is beyond


@dataclass(frozen=True, slots=True, eq=False)
class Smoothed:
    """Frames in order: ``stamp_ns`` (R,), ``track`` (R, 12) and ``slip`` (R, 2 W + 1).

    The columns are those of :class:`.stretch.Rows`.
    """

    stamp_ns: IntArray
    track: FloatArray
    slip: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Rows (R, width) of the trail, in ``parts``, with stamps (R,) ns; ``travel`` (W,) m a radian.

    The first ``count`` are those of the piece, the rest is what they see ahead.
    """

    stamp_ns: IntArray
    parts: tuple[FloatArray, ...]
    count: int
    travel: FloatArray

    def smoothed(self) -> Smoothed:
        """The work itself; it may be done anywhere and at any time."""
        w, count = len(self.travel), self.count
        rows = np.concatenate(self.parts)
        out, rows = look_back(self.stamp_ns, rows)[:count], rows[:count]
        x = rows[:, WHEELS + w:WHEELS + 2 * w]
        y = rows[:, WHEELS + 2 * w:]
        dx, dy = (out[:, VX:VY + 1] - rows[:, VX:VY + 1]).T[:, :, None]
        moves = (rows[:, WAS_STILL] == 0.0)[:, None]
        speed = rows[:, WHEELS:WHEELS + w] - np.where(moves, x * dx + y * dy, 0.0)
        xx, xy, yy = out[:, TRACK:].T[:, :, None]
        t = (np.abs(speed) - THRESHOLD) / np.sqrt(  # as output.slipping
            x * x * xx + 2.0 * x * y * xy + y * y * yy + 25e-6)
        slip = np.empty((count, 2 * w + 1))
        slip[:, 0:-1:2] = speed / self.travel
        slip[:, 1:-1:2] = 0.5 + (t * ROOT3 / (3.0 + t * t) + np.arctan(t / ROOT3)) / math.pi
        slip[:, -1] = slip[:, 1:-1:2].max(axis=1)
        return Smoothed(self.stamp_ns[:count].copy(), out[:, :TRACK].copy(), slip)


class Smoother:
    """Takes final rows of the trail in order and cuts them into pieces."""

    def __init__(self, travel: FloatArray) -> None:
        """``travel`` (W,) m a radian."""
        self._travel = travel
        self._parts: list[FloatArray] = []
        self._stamp: IntArray = np.zeros(0, dtype=np.int64)
        self._judged: FloatArray = np.zeros(0)
        self._done: list[Piece] = []

    def take(self, stamp: IntArray, rows: FloatArray) -> None:
        """Take rows (R, width) with stamps (R,) ns that follow those before; keeps the arrays."""
        if not len(stamp):
            return
        self._stamp = np.concatenate([self._stamp, stamp])
        self._judged = np.concatenate([self._judged, rows[:, WAS_JUDGED]])
        self._parts.append(rows)
        while self._stamp[-1] - self._stamp[0] >= PIECE + AHEAD:
            first = self._stamp[0]
            seen, over = np.searchsorted(self._stamp, [first + PIECE + AHEAD, first + PIECE])
            judged = np.flatnonzero(self._judged[:over])  # calm ones stay with the last
            self._cut(int(seen), int(judged[-1] if len(judged) and judged[-1] else over))

    def end(self) -> None:
        """What comes next does not follow what came before."""
        if len(self._stamp):
            self._cut(len(self._stamp), len(self._stamp))

    def _cut(self, seen: int, over: int) -> None:
        """A piece of the first ``over`` rows, of ``seen`` in view; the others are kept."""
        self._done.append(Piece(self._stamp[:seen], _between(self._parts, 0, seen), over,
                                self._travel))
        self._parts = list(_between(self._parts, over, len(self._stamp)))
        self._stamp, self._judged = self._stamp[over:], self._judged[over:]

    def taken(self) -> tuple[Piece, ...]:
        """The pieces that are complete and were not taken before."""
        found, self._done = tuple(self._done), []
        return found


def _between(parts: list[FloatArray], start: int, stop: int) -> tuple[FloatArray, ...]:
    """Rows ``start`` to ``stop`` of all parts together."""
    found, begin = [], 0
    for part in parts:
        some = part[max(start - begin, 0):max(stop - begin, 0)]
        if len(some):
            found.append(some)
        begin += len(part)
    return tuple(found)
