"""Which wirings of the wheels are thought of, and how unlikely each is before anything was driven.

A robot file that is right is believed SOUND = 5 times as readily as one with a mistake; every
mistake costs PRICE = log(20): the first is one in a hundred, a further one, on a robot that has
been put together wrongly, one in twenty. One mistake is: two wheels exchanged; the wheels listed
in quite another order (all such orders together are as likely as all exchanges together); one
encoder reversed; all encoders reversed; a wrong mounting of the IMU.

These prices alone decide between wirings that are one and the same base seen from another side: a
base turned by half or a quarter of a turn, its wheels renumbered and the IMU turned along, is the
same machine, and no wheel, gyro or accelerometer tells which side is its front. So one mistake in
the order of the wheels is believed before two or three that would look alike.
"""

from __future__ import annotations

import itertools
import math

from mecanum_base.core.parameter import FloatArray

PRICE = math.log(20.0)
SOUND = math.log(5.0)

Order = tuple[int, ...]


def wheel_wirings(count: int, sign: FloatArray) -> list[tuple[Order, Order, float]]:
    """Orders and signs (+-1) of ``count`` wheels and what each costs; above four wheels two
    reversed at most, or all; above six one exchange at most. ``sign`` (W,) of the robot file:
    wheels that change places may take their signs along or find those of the place."""
    identity = tuple(range(count))
    orders = list(itertools.permutations(identity)) if count <= 6 else [
        identity, *(_exchanged(identity, a, b) for a, b in itertools.combinations(identity, 2))]
    signs = list(itertools.product((1, -1), repeat=count))
    if count > 4:
        signs = [s for s in signs if s.count(-1) <= 2 or s.count(-1) == count]
    found = []
    for order in orders:
        stays = tuple(int(v) for v in sign * sign[list(order)])
        price = order_price(order)
        found += [(order, own, price + min(_sign_price(own), _sign_price(
            tuple(a * b for a, b in zip(own, stays))))) for own in
            (signs if stays in signs else [*signs, stays])]
    return found


def order_price(order: Order) -> float:
    """Price of an order of the wheels."""
    moved = sum(i != j for i, j in enumerate(order))
    if moved <= 2:
        return PRICE * (moved > 0)
    exchanges = math.comb(len(order), 2)
    others = math.factorial(len(order)) - 1 - exchanges
    return PRICE + math.log(max(others / exchanges, 1.0))


def _sign_price(sign: Order) -> float:
    flips = sign.count(-1)
    return PRICE * min(flips, 1 + len(sign) - flips)  # all reversed is one mistake, not four


def _exchanged(order: Order, a: int, b: int) -> Order:
    changed = list(order)
    changed[a], changed[b] = order[b], order[a]
    return tuple(changed)
