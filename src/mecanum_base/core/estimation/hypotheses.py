"""The hypotheses on slip: which wheels slip, and how alike.

Three families over W wheels:

    subsets   every set of wheels, each with its own slip speed     sigma ``single``
    groups    all wheels with parallel roller axes, one slip speed  sigma ``common``: a diagonal
    body      the base moves against all its wheels as one rigid body: slip = -A twist

The body and the groups are the typical gross slip (a push, a hard start, ice): as independent
slips of two to four wheels they would hardly ever be believed. Subsets of more than two wheels
are listed for W <= 4 only; beyond that pairs, and all wheels but one or none, stand for them.

Probabilities follow a Markov chain: each wheel breaks loose at ``loose_rate`` and grips again at
``grip_rate``; common causes enter the larger sets directly.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from mecanum_base.core.estimation.geometry import parallel_groups
from mecanum_base.core.parameter import FloatArray

SMALL = 4  # wheels up to which every subset is listed


@dataclass(frozen=True, slots=True, eq=False)
class Hypotheses:
    """Tables over M hypotheses; number 0 is 'nothing slips'.

    ``member`` (M, W), ``likely`` (W, W, M) covariance of slip speeds (m/s)^2, ``change`` (M, M)
    rates 1/s, ``groups`` (G, W), ``kind`` (M,).
    """

    member: FloatArray
    likely: FloatArray
    change: FloatArray
    groups: FloatArray
    kind: tuple[str, ...]


def subsets(wheels: int) -> list[tuple[int, ...]]:
    """Sets of wheels that may slip independently, the empty one first."""
    sizes = range(wheels + 1) if wheels <= SMALL else (0, 1, 2, wheels - 1, wheels)
    return [s for k in sizes for s in combinations(range(wheels), k)]


def build(rows: FloatArray, single: float, common: float, spread: float, loose_rate: float,
          grip_rate: float, common_rate: float) -> Hypotheses:
    """Tables for the rows A (W, 3); speeds in m/s, rates in 1/s."""
    wheels = len(rows)
    sets = subsets(wheels)
    groups = [g for g in parallel_groups(rows) if len(g) < wheels]
    members, covariances, kinds = [], [], []
    for s in sets:
        mask = np.zeros(wheels)
        mask[list(s)] = 1.0
        members.append(mask)
        covariances.append(np.diag(mask * single ** 2))
        kinds.append('subset')
    for group in groups:
        mask = np.zeros(wheels)
        mask[list(group)] = 1.0
        direction = mask * _aligned(rows, group)
        members.append(mask)
        covariances.append(common ** 2 * np.outer(direction, direction)
                           + np.diag(mask * spread ** 2))
        kinds.append('group')
    plane = rows[:, :2]
    turn = rows[:, 2] - rows[:, 2].mean()
    size = max(float(np.sqrt(np.mean(turn ** 2))), 1e-9)
    members.append(np.ones(wheels))
    covariances.append(common ** 2 * (plane @ plane.T + 0.1 * np.outer(turn, turn) / size ** 2)
                       + np.eye(wheels) * spread ** 2)
    kinds.append('body')
    member = np.array(members)
    change = _rates(sets, member, kinds, loose_rate, grip_rate, common_rate)
    return Hypotheses(
        np.ascontiguousarray(member), np.ascontiguousarray(np.stack(covariances, axis=2)),
        change,
        np.array([[1.0 if i in g else 0.0 for i in range(wheels)] for g in groups]
                 ).reshape(len(groups), wheels), tuple(kinds))


def _aligned(rows: FloatArray, group: tuple[int, ...]) -> FloatArray:
    """Sign (W,) of each roller axis against the first of the group."""
    sign: FloatArray = np.sign(rows[:, :2] @ rows[group[0], :2])
    return np.where(sign == 0.0, 1.0, sign)


def _rates(sets: list[tuple[int, ...]], member: FloatArray, kinds: list[str], loose: float,
           grip: float, common: float) -> FloatArray:
    """Generator matrix (M, M) of the chain: rows sum to zero."""
    count = len(member)
    rate = np.zeros((count, count))
    index = {s: i for i, s in enumerate(sets)}
    everything = tuple(range(member.shape[1]))
    for s, i in index.items():
        for wheel in everything:
            inside = wheel in s
            other = tuple(v for v in s if v != wheel) if inside else tuple(sorted((*s, wheel)))
            if other in index:
                rate[i, index[other]] += grip if inside else loose
    for i in range(count):
        if kinds[i] == 'subset':
            size = len(sets[i])
            if size >= 2:
                rate[0, i] += common * loose
            continue
        # a common cause: entered from nothing, left to nothing, to the subset, to the others
        rate[0, i] += 4.0 * common * loose
        rate[i, 0] += grip
        same = tuple(int(v) for v in np.flatnonzero(member[i]))
        if same in index:
            rate[i, index[same]] += grip
            rate[index[same], i] += 0.5 * grip
        for j in range(count):
            if j != i and kinds[j] != 'subset':
                rate[i, j] += loose * 10.0
    np.fill_diagonal(rate, 0.0)
    np.fill_diagonal(rate, -rate.sum(axis=1))
    return rate
