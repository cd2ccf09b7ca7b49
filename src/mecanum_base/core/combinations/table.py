"""The 81 combinations of signs and how many of them pass which criterion (source T, Table I).

Patterns such as "++0-" are written in T's order 1 = FR, 2 = FL, 3 = RL, 4 = RR, "+" driving the
base forward. Table I names 16 of them by compass direction, North = forward, East = right.

T counts "51 functional and 30 non-functional". That is no unconditional truth: 30 is the number
of combinations other than stop that stall when idle wheels are locked and loads are equal, 51 the
rest including stop. Table I's own two-wheel rows are among those 30: they assume idle wheels that
turn freely. Any criterion that treats u and -u alike counts an odd number on the side of stop.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.combinations.verdict import Verdict, judge
from mecanum_base.core.kinematics.layouts import RECTANGLE, TLALE
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

TABLE_I = {
    '++++': 'N', '++00': 'N', '00++': 'N', '----': 'S', '--00': 'S', '00--': 'S',
    '-+-+': 'E', '-00+': 'E', '0+-0': 'E', '+-+-': 'W', '+00-': 'W', '0-+0': 'W',
    '0+0+': 'NE', '0-0-': 'SW', '+0+0': 'NW', '-0-0': 'SE'}
COMPASS = {'N': 90.0, 'S': -90.0, 'E': 0.0, 'W': 180.0, 'NE': 45.0, 'SW': -135.0, 'NW': 135.0,
           'SE': -45.0}  # degrees from East (right), counter-clockwise
ON_AXIS = 1e-3  # share of the reach of the wheels
_SIGNS = {'+': 1.0, '0': 0.0, '-': -1.0}
CAVEAT = ('51/30 of the paper = stalled when idle wheels are locked (30) against the rest '
          'including stop (51); Table I\'s two-wheel rows assume freely turning idle wheels')


@dataclass(frozen=True, slots=True, eq=False)
class Numbering:
    """Which wheel of the file is T's 1, 2, 3, 4 and which sign of its rate drives forward.

    ``order`` (4,) indices into the file; ``forward`` (4,) +1 or -1 by T's number; ``tlale`` False
    where the wheels do not stand one in each quadrant: then the order of the file is kept.
    """

    order: tuple[int, ...]
    forward: FloatArray
    tlale: bool


@dataclass(frozen=True, slots=True, eq=False)
class Combination:
    """One pattern with its verdict; ``label`` = compass direction of Table I, '' if not there.

    ``compass`` = degrees from East (right) of the least-squares translation, NaN without one.
    """

    pattern: str
    verdict: Verdict
    label: str
    compass: float


def number_wheels(wheels: Wheels) -> Numbering:
    """T's numbering of a base with four wheels, one in each quadrant about their mean."""
    ahead, aside = wheels.x - np.mean(wheels.x), wheels.y - np.mean(wheels.y)
    places = {(True, True): 'FL', (True, False): 'FR', (False, True): 'RL', (False, False): 'RR'}
    names = [places[bool(f), bool(s)] for f, s in zip(ahead > 0.0, aside > 0.0)]
    beside = float(np.min(np.abs([ahead, aside])))  # a wheel on an axis is in no quadrant
    tlale = (sorted(names) == sorted(RECTANGLE)
             and beside > ON_AXIS * float(np.max(np.hypot(ahead, aside))))
    order = tuple(names.index(RECTANGLE[i]) for i in TLALE) if tlale else tuple(range(4))
    drive = wheels_from_body(wheels)[list(order), 0]
    forward = np.where(drive < -1e-6 * np.max(np.abs(drive)), -1.0, 1.0)
    return Numbering(order, forward, tlale)


def rates_of(numbering: Numbering, drive: FloatArray) -> FloatArray:
    """Wheel rates (4,) in file order from drive rates (4,) of wheels 1..4, + = forward."""
    rates = np.zeros(4)
    rates[list(numbering.order)] = numbering.forward * drive
    return rates


def drive_of(numbering: Numbering, rates: FloatArray) -> FloatArray:
    """Drive rates (4,) of wheels 1..4, + = forward, from wheel rates (4,) in file order."""
    drive: FloatArray = numbering.forward * rates[list(numbering.order)]
    return drive


def pattern_of(drive: FloatArray) -> str:
    """Signs of drive rates (4,), for instance '+0-0'."""
    return ''.join('+' if value > 0.0 else '-' if value < 0.0 else '0' for value in drive)


def combine(wheels: Wheels, drive: FloatArray) -> Combination:
    """One combination of drive rates (4,) rad/s of wheels 1..4, equal or not, + = forward.

    The label of Table I is given for equal speeds only.
    """
    numbering = number_wheels(wheels)
    verdict = judge(wheels, rates_of(numbering, drive))
    pattern = pattern_of(drive)
    turning = np.abs(drive[drive != 0.0])
    equal = bool(len(turning) == 0 or np.ptp(turning) <= 1e-12 * np.max(turning))
    label = TABLE_I.get(pattern, '') if numbering.tlale and equal else ''
    compass = math.degrees(math.atan2(verdict.twist[0], -verdict.twist[1]))
    return Combination(pattern, verdict, label,
                       math.nan if math.isnan(verdict.bearing) else compass)


def survey(wheels: Wheels, rate: float = 1.0) -> tuple[Combination, ...]:
    """All 81 combinations at ``rate`` rad/s, from '++++' to '----'."""
    return tuple(combine(wheels, rate * np.array([_SIGNS[sign] for sign in signs]))
                 for signs in itertools.product('+0-', repeat=4))


@dataclass(frozen=True, slots=True)
class Counts:
    """How many of the 81 combinations meet which criterion; see :data:`CAVEAT`.

    ``no_slip`` idle wheels locked; ``parity_within_one`` |n . u| <= rate; ``stop`` nothing
    driven; ``stalled`` at rest though driven, idle wheels locked; ``not_stalled`` the others,
    stop included; ``no_twist`` least-squares twist 0; ``free_unique``, ``free_open``,
    ``free_slip`` with freely turning idle wheels.
    """

    total: int
    no_slip: int
    parity_within_one: int
    stop: int
    stalled: int
    not_stalled: int
    no_twist: int
    free_unique: int
    free_open: int
    free_slip: int


def count(combinations: tuple[Combination, ...]) -> Counts:
    """The counts of :class:`Counts` over a :func:`survey`."""
    verdicts = [c.verdict for c in combinations]
    stalled = sum(v.stalls and v.driven > 0 for v in verdicts)
    free = [v.free_idle for v in verdicts]
    return Counts(
        total=len(verdicts), no_slip=sum(v.no_slip for v in verdicts),
        parity_within_one=sum(
            abs(v.parity) <= float(np.max(np.abs(v.rates))) * (1.0 + 1e-9) for v in verdicts),
        stop=sum(v.driven == 0 for v in verdicts), stalled=stalled,
        not_stalled=len(verdicts) - stalled, no_twist=sum(not v.moves for v in verdicts),
        free_unique=free.count('unique'), free_open=free.count('underdetermined'),
        free_slip=free.count('slip'))
