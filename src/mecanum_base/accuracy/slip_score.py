"""Slip claims against the true slip, per sample and per episode.

    truly slipping   any wheel slides faster than 5 cm/s along its roller axis
    quiet            none faster than 2 cm/s; what lies between is not counted
    claimed          the probability that any wheel slips is 0.5 or more
    F1               2 TP/(2 TP + FP + FN) over samples
    latency          from the start of a true episode (50 ms or longer) to the first claim
    false episode    claimed, with no wheel above 2 cm/s within 0.3 s
    diagonal         samples claimed and true whose most probable wheel has its rollers parallel
                     to those of the wheel that truly slides most (both wheels of a diagonal give
                     the same evidence but for the accelerometer)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mecanum_base.core.parameter import FloatArray

BoolArray = npt.NDArray[np.bool_]

ON, OFF = 0.05, 0.02  # m/s
_LEAST, _AFTER, _NEAR = 0.05, 0.1, 0.3  # s


@dataclass(frozen=True, slots=True)
class SlipScore:
    """Counts of one run; ``delays`` s, ``true_samples`` of ``samples`` slip."""

    hits: int
    false_alarms: int
    misses: int
    delays: tuple[float, ...]
    missed_episodes: int
    false_episodes: int
    hours: float
    diagonal_right: int
    diagonal_all: int
    true_samples: int
    samples: int


def score_of(seconds: FloatArray, speed: FloatArray, body: FloatArray, wheel: FloatArray,
             groups: Sequence[Sequence[int]]) -> SlipScore:
    """Score probabilities ``body`` (N,) and ``wheel`` (N, W) against true slip speeds (N, W).

    ``seconds`` (N,) evenly spaced; ``groups`` are the sets of wheels with parallel rollers, empty
    where the share of right diagonals has no meaning.
    """
    worst = np.abs(speed).max(axis=1)
    claim, real, quiet = body >= 0.5, worst > ON, worst < OFF
    delays, missed = [], 0
    for a, b in spans(real, seconds):
        if b - a < _LEAST:
            continue
        hit = np.flatnonzero(claim & (seconds >= a) & (seconds <= b + _AFTER))
        if len(hit):
            delays.append(float(seconds[hit[0]] - a))
        else:
            missed += 1
    period = float(np.median(np.diff(seconds)))
    reach = np.ones(2 * round(_NEAR / period) + 1)
    near = np.convolve((worst > OFF).astype(np.float64), reach)[len(reach) // 2:][:len(worst)] > 0
    false = sum(not near[(seconds >= a) & (seconds <= b)].any() for a, b in spans(claim, seconds))
    both = claim & real if groups else np.zeros(len(claim), dtype=bool)
    group = np.zeros(speed.shape[1], dtype=np.int64)
    for number, members in enumerate(groups):
        group[list(members)] = number
    right = group[wheel.argmax(axis=1)] == group[np.abs(speed).argmax(axis=1)]
    return SlipScore(int(np.sum(claim & real)), int(np.sum(claim & quiet)),
                     int(np.sum(~claim & real)), tuple(delays), missed, int(false),
                     float(seconds[-1] - seconds[0]) / 3600.0, int(np.sum(right & both)),
                     int(np.sum(both)), int(np.sum(real)), len(real))


def spans(flag: BoolArray, seconds: FloatArray) -> list[tuple[float, float]]:
    """First and last time of every connected stretch where ``flag`` (N,) is true."""
    edge = np.diff(np.concatenate(([0], flag.astype(np.int64), [0])))
    return [(float(seconds[a]), float(seconds[b - 1]))
            for a, b in zip(np.flatnonzero(edge == 1), np.flatnonzero(edge == -1))]
