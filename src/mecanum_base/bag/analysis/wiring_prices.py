"""Which wirings of the wheels are thought of, and how unlikely each is before anything was driven.

A robot file that is right is believed SOUND = 5 times as readily as one with a mistake; every
mistake costs PRICE = log(20): the first is one in a hundred, a further one, on a robot that has
been put together wrongly, one in twenty. One mistake is: two wheels exchanged; the wheels listed
from the other end of the base; the wheels listed in quite another order (all such orders together
are as likely as all exchanges together); one encoder reversed; all encoders reversed; a wrong
mounting of the IMU.

A base turned by half or a quarter of a turn, its wheels renumbered and the IMU turned along, is
the same machine: no wheel, gyro or accelerometer tells which side is its front. Three things say
where it is: the order of the wheels, the signs of the encoders and the mounting of the IMU. One of
them wrong looks exactly like the two others wrong together, and who takes one end of a base for
the other gets two of them wrong by a single mistake. So two of the three are END = log(4) dearer
than one, no more: the odd one out of three is named with 80 %, never as certain. Everything else
that has a twin of this kind is one mistake against three or more.
"""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np

from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

PRICE = math.log(20.0)
SOUND = math.log(5.0)
END = math.log(4.0)  # by one mistake about the front, two things are wrong instead of one

Order = tuple[int, ...]


def seen_from_behind(wheels: Wheels) -> Order | None:
    """The order in which somebody at the other end lists the wheels, who also sees all of them
    turn the other way; None for a base that does not look the same from there."""
    places = np.column_stack([wheels.x, wheels.y])
    places = places - places.mean(axis=0)
    gap = np.linalg.norm(places[:, None] + places[None], axis=2)
    behind = np.argmin(gap, axis=1)
    matrix = wheels_from_body(wheels) * [1.0, 1.0, 1.0 / float(np.hypot(*places.T).mean())]
    matrix = matrix / np.linalg.norm(matrix, axis=1, keepdims=True)
    turned = matrix * [-1.0, -1.0, 1.0]
    alike = np.sum(turned * matrix[behind], axis=1)
    if (behind[behind] != np.arange(len(behind))).any() or (alike > -0.95).any():
        return None
    return tuple(int(i) for i in behind)


def wheel_wirings(count: int, sign: FloatArray,
                  behind: Order | None = None) -> list[tuple[Order, Order, float, float]]:
    """Orders and signs (+-1) of ``count`` wheels, what each costs, and what it costs beside an
    IMU whose half turn about z is thereby explained; above four wheels two reversed at most, or
    all; above six one exchange at most. ``sign`` (W,) of the robot file: wheels that change
    places may take their signs along or find those of the place. ``behind``: from
    :func:`seen_from_behind`."""
    identity = tuple(range(count))
    orders = list(itertools.permutations(identity)) if count <= 6 else [
        identity, *(_exchanged(identity, a, b) for a, b in itertools.combinations(identity, 2)),
        *([behind] if behind else [])]
    signs = list(itertools.product((1, -1), repeat=count))
    if count > 4:
        signs = [s for s in signs if s.count(-1) <= 2 or s.count(-1) == count]
    price = {order: order_price(order, behind) for order in orders}
    found = []
    for order in orders:
        stays = tuple(int(v) for v in sign * sign[list(order)])
        other = tuple(order[i] for i in behind) if behind else ()
        other_price = price.get(other, math.inf)
        other_stays = tuple(int(v) for v in sign * sign[list(other)]) if behind else stays
        for own in signs if stays in signs else [*signs, stays]:
            flipped = tuple(-v for v in own)
            alone = price[order] + _signs_price(own, stays)
            listed = END + PRICE + other_price + _signs_price(flipped, other_stays)
            turned = END + PRICE + min(other_price + _signs_price(own, other_stays),
                                       price[order] + _signs_price(flipped, stays)
                                       ) if behind else math.inf
            found.append((order, own, min(alone, listed), turned))
    return found


def imu_prices(turn: FloatArray) -> tuple[float, float]:
    """What a mounting of the IMU costs that is ``turn`` (3, 3) off, and what the rest of it costs
    where half a turn about z is already paid for."""
    upright = turn[2, 2] > 0.5
    return (PRICE * (not (upright and turn[0, 0] > 0.5)),
            PRICE * (not (upright and turn[0, 0] < -0.5)))


def order_price(order: Order, behind: Order | None = None) -> float:
    """Price of an order of the wheels."""
    moved = sum(i != j for i, j in enumerate(order))
    if moved <= 2 or order == behind:
        return PRICE * (moved > 0)
    exchanges = math.comb(len(order), 2)
    others = math.factorial(len(order)) - 1 - exchanges - (behind is not None)
    return PRICE + math.log(max(others / exchanges, 1.0))


@functools.cache
def _signs_price(sign: Order, stays: Order) -> float:
    """Price of signs where ``stays`` are those of a wheel that finds the sign of its place."""
    return min(_sign_price(sign), _sign_price(tuple(a * b for a, b in zip(sign, stays))))


def _sign_price(sign: Order) -> float:
    flips = sign.count(-1)
    return PRICE * min(flips, 1 + len(sign) - flips)  # all reversed is one mistake, not four


def _exchanged(order: Order, a: int, b: int) -> Order:
    changed = list(order)
    changed[a], changed[b] = order[b], order[a]
    return tuple(changed)
