"""Which wiring explains the recording best: a search over all plausible faults.

Every hypothesis is a permutation and sign of the wheels, mirrored rollers or not, a unit of the
gyro, a mounting of the IMU and a yaw scale. Its cost is a log-likelihood with the noise learned
from the best that any linear combination of the wheels can do, so no noise figures are needed:

    J = sum over channels  n/2 log((mse + floor) / (best mse + floor))  +  price of the wiring

n counts independent stretches (0.4 s each, at most 60 a channel), floor = (5 % of the signal)^2
stands for what the model leaves out. exp(-J), normalised, is how sure the search is. Wirings that
the recording cannot tell apart share the probability by what they change (wiring_prices.py).
"""

from __future__ import annotations

import dataclasses
import math
import operator
from dataclasses import dataclass

import numpy as np

from mecanum_base.bag.analysis.wiring_commands import Commands, driven_cost
from mecanum_base.bag.analysis.wiring_prices import (
    PRICE,
    SOUND,
    Order,
    imu_prices,
    seen_from_behind,
    wheel_wirings,
)
from mecanum_base.bag.analysis.wiring_signals import Signals, right_angles
from mecanum_base.bag.analysis.wiring_target import MISFIT, MOST, STRETCH, Target
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels, parity_basis
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray, IntArray

DEGREES = 180.0 / math.pi
_TILT = math.radians(5.0)
_LEVEL = 0.15  # of the turning may show on x and y of the gyro: tilt, bumps
_TOLERANCE = 0.08  # yaw scales this near 1 are calibration, not a fault
_KEPT = 400
_ANY_SCALE = 5.0  # a factor from 1/1000 to 1000 is hit within 8 % by chance once in 80 tries
_HOPELESS = 20.0  # cost above the best so far, exp(-20) is nothing


@dataclass(frozen=True, slots=True, eq=False)
class Wiring:
    """One hypothesis: wheel i is really column ``order[i]`` times ``sign[i]``; ``price`` is the
    part of its ``cost`` that no recording changes."""

    order: Order
    sign: Order
    mirrored: bool
    degrees: bool  # gyro in deg/s
    mount: int  # index of the right-angle rotation put before the file's mount
    scale: float  # real yaw over yaw of the wheels; 1 unless it is a fault
    price: float = 0.0
    cost: float = 0.0
    probability: float = 0.0

    @property
    def key(self) -> tuple[object, ...]:
        """What would be changed in the robot file."""
        return (self.order, self.sign, self.mirrored, self.degrees, self.mount,
                self.scale != 1.0)

    @property
    def sound(self) -> bool:
        """Whether the robot file is right."""
        return self.price == 0.0


def forward_of(wheels: Wheels, wiring: Wiring) -> FloatArray:
    """Forward matrix (3, W) of the columns as they are wired."""
    system = _system(wheels, wiring.mirrored) or _system(wheels, False)
    assert system is not None
    return system[0] @ _mixing(wiring.order, wiring.sign)


def _mixing(order: Order, sign: Order) -> FloatArray:
    mixing = np.zeros((len(order), len(order)))
    mixing[np.arange(len(order)), list(order)] = sign
    return mixing


class _Targets:
    """All signals of one recording as targets, by mounting of the IMU."""

    def __init__(self, signals: Signals, wheels: Wheels, mount: FloatArray) -> None:
        self.signals = signals
        self.rotations = right_angles()
        self.mounts = list(range(len(self.rotations)))
        self.prices = [imu_prices(turn) for turn in self.rotations]
        if signals.accel is None:  # nothing tells mountings apart that share the axis of turning
            axes = [tuple(turn[2]) for turn in self.rotations]
            self.mounts = [index for index in self.mounts if axes.index(axes[index]) == index]
        self.gravity = _gravity_cost(signals, self.rotations, mount)
        rows = len(signals.wheel)
        self.square = signals.wheel.T @ signals.wheel / rows
        self.count = min(MOST, signals.seconds / STRETCH)
        self.witness: list[Target] = []
        if signals.witness is not None:
            good = np.isfinite(signals.witness).all(axis=1)
            self.witness = [Target(signals.wheel[good], signals.witness[good, axis])
                            for axis in range(3)]
        self.commands = Commands(signals, wheels)
        self.plane: list[float] = []
        self.yaw: list[tuple[Target, Target]] = []
        self.push: list[tuple[Target, Target]] = []
        for turn in self.rotations if signals.gyro is not None else []:
            assert signals.gyro is not None
            whole = turn @ mount
            self.plane.append(_plane_cost(signals.gyro @ whole.T, self.count))
            rate = signals.gyro @ whole[2]
            self.yaw.append((Target(signals.wheel, rate), Target(signals.wheel, rate / DEGREES)))
            if signals.accel is not None:
                self.push.append(self._pushes(whole, rate))

    def _pushes(self, whole: FloatArray, rate: FloatArray) -> tuple[Target, Target]:
        """Accelerometer along x and y while the robot hardly turns (no centripetal part)."""
        assert self.signals.accel is not None
        size = np.abs(rate)
        calm = size < max(0.2, 0.2 * float(np.percentile(size, 95)))
        accel = self.signals.accel[calm] @ whole.T
        if 0.8 < self.signals.up_size < 1.2:
            accel = accel * 9.80665
        return (Target(self.signals.push[calm], accel[:, 0]),
                Target(self.signals.push[calm], accel[:, 1]))

    def told(self, forward: FloatArray, scale: float) -> float:
        """Cost of true pose or commands if the base turns ``scale`` times as far as the wheels
        say; it goes as far as they say, or that many times."""
        if not self.witness or self.signals.commanded:
            return driven_cost(self.witness, forward)

        def cost(axis: int, around: float) -> float:
            target, row = self.witness[axis], forward[axis]
            factor = min(max(target.scale(row), around - _TOLERANCE * around),
                         around + _TOLERANCE * around)
            return target.cost(factor * row)

        return cost(2, scale) + min(cost(0, k) + cost(1, k) for k in (1.0, scale))

    def parity(self, rows: FloatArray, orders: IntArray, signs: FloatArray) -> FloatArray:
        """Costs (N,) of the wheels contradicting each other by ``rows`` (P, W) of the parity,
        for wheels in ``orders`` (N, W) with ``signs`` (N, W)."""
        if not len(rows):
            return np.zeros(len(orders))
        spread = float(np.trace(self.square)) / len(self.square)
        moments = self.square[orders[:, :, None], orders[:, None, :]]
        mse = np.einsum('ij,nij,ni,nj->n', rows.T @ rows, moments, signs, signs) / len(rows)
        floor = MISFIT**2 * spread + 1e-12
        found: FloatArray = 0.5 * self.count * np.log((np.maximum(mse, 0.0) + floor) / floor)
        return found


def search(signals: Signals, wheels: Wheels, mount: FloatArray,
           sign: FloatArray) -> list[Wiring]:
    """The best wirings, most probable first; ``mount`` (3, 3): base_from_sensor of the file,
    ``sign`` (W,) that of its encoders."""
    targets = _Targets(signals, wheels, mount)
    found: list[Wiring] = []
    best = math.inf
    orders, signs, prices, turned = zip(*wheel_wirings(wheels.count, sign,
                                                       seen_from_behind(wheels)))
    least = np.minimum(prices, turned)
    columns, turns = np.array(orders), np.array(signs, dtype=float)
    for mirrored in (False, True):
        system = _system(wheels, mirrored)
        if system is None:
            continue
        forward, parity = system
        contrary = targets.parity(parity, columns, turns)
        lowest = contrary + least + PRICE * mirrored
        for i in np.argsort(lowest, kind='stable'):
            if lowest[i] > best + _HOPELESS:
                break
            price = prices[i] + PRICE * mirrored
            wiring = Wiring(orders[i], signs[i], mirrored, False, 0, 1.0, price, price)
            scored = _score(targets, forward @ _mixing(orders[i], signs[i]), wiring,
                            turned[i] + PRICE * mirrored, float(contrary[i]), best + _HOPELESS)
            best = min([best, *(w.cost for w in scored)])
            found += scored
    found = [dataclasses.replace(w, cost=w.cost - SOUND) if w.sound else w for w in found]
    found.sort(key=lambda w: w.cost)
    found = found[:_KEPT]
    weight = np.exp(-(np.array([w.cost for w in found]) - found[0].cost))
    total = float(weight.sum())
    return [dataclasses.replace(w, probability=float(p) / total)
            for w, p in zip(found, weight)]


def _system(wheels: Wheels, mirrored: bool) -> tuple[FloatArray, FloatArray] | None:
    """Forward matrix and parity of the wheels, rollers as in the file or mirrored; None where
    mirrored rollers change nothing (omni wheels) or the base could not be turned by them."""
    matrix = wheels_from_body(wheels)
    if mirrored:
        plain, chosen = matrix, dataclasses.replace(wheels, roller=-wheels.roller)
        matrix = wheels_from_body(chosen)
        if np.allclose(matrix, plain, rtol=0.0, atol=1e-9 * float(np.abs(plain).max())):
            return None
    singular = np.linalg.svd(matrix * np.array([1.0, 1.0, 1.0 / _arm(wheels)]), compute_uv=False)
    if singular[-1] < 0.02 * singular[0]:
        return None
    return body_from_wheels(matrix), parity_basis(matrix)


def _arm(wheels: Wheels) -> float:
    return float(np.hypot(wheels.x, wheels.y).mean())


def _gravity_cost(signals: Signals, rotations: list[FloatArray], mount: FloatArray) -> FloatArray:
    """Cost of each rotation from the direction of gravity; 0 without an accelerometer."""
    if signals.up is None or signals.up_size < 0.5:
        return np.zeros(len(rotations))
    sigma = _TILT if signals.up_rested else 2.0 * _TILT
    angle = [math.acos(max(-1.0, min(1.0, float((turn @ mount @ signals.up)[2]))))
             for turn in rotations]
    return np.minimum(0.5 * (np.array(angle) / sigma) ** 2, 40.0)


def _plane_cost(gyro: FloatArray, count: float) -> float:
    """A base on a floor turns about z: what x and y of the gyro (K, 3) show speaks against."""
    power = np.mean(gyro**2, axis=0)
    floor = _LEVEL**2 * float(power.sum()) + 1e-12
    return 0.5 * count * math.log((float(power[0] + power[1]) + floor) / floor)


def _score(targets: _Targets, forward: FloatArray, wiring: Wiring, turned: float,
           contrary: float, limit: float) -> list[Wiring]:
    """The wiring with every reading of the IMU; its ``cost`` so far is the price of the wiring,
    ``turned`` that beside an IMU turned by half a turn, ``contrary`` what its wheels contradict.

    What costs more than ``limit`` is left out.
    """
    base = contrary + targets.commands.cost(forward)
    if targets.signals.gyro is None:
        return _witnessed(targets, forward, wiring, wiring.price + base)
    found = []
    told = targets.told(forward, 1.0)
    for index in targets.mounts:
        price = min(map(operator.add, (wiring.price, turned), targets.prices[index]))
        cost = base + price + float(targets.gravity[index]) + targets.plane[index]
        if cost > limit:
            continue
        push = targets.push[index] if targets.push else ()
        level = sum(t.cost(row) for t, row in zip(push, forward))
        for degrees in (False, True):
            target, unit = targets.yaw[index][degrees], PRICE * degrees
            scale = target.scale(forward[2])
            near = min(max(scale, 1.0 - _TOLERANCE), 1.0 + _TOLERANCE)
            plain = cost + unit + told + level
            if plain < limit:
                plain += target.cost(near * forward[2])
                found.append(dataclasses.replace(wiring, mount=index, degrees=degrees,
                                                 price=price + unit, cost=plain))
            if scale > 0.0 and near != scale:  # lever arm, or counts of all wheels
                unit += PRICE + _ANY_SCALE
                scaled = cost + unit + target.cost(scale * forward[2])
                if scaled > limit:
                    continue
                pulled = sum(t.cost(scale * row) for t, row in zip(push, forward))
                scaled += min(level, pulled) + targets.told(forward, scale)
                found.append(dataclasses.replace(wiring, mount=index, degrees=degrees, scale=scale,
                                                 price=price + unit, cost=scaled))
    return found


def _witnessed(targets: _Targets, forward: FloatArray, wiring: Wiring,
               cost: float) -> list[Wiring]:
    """The wiring as commands or a true pose alone see it; commands know no scale, because motors
    may turn more or less than is asked of them."""
    found = [dataclasses.replace(wiring, cost=cost + targets.told(forward, 1.0))]
    scale = targets.witness[2].scale(forward[2]) if targets.witness else 1.0
    if not targets.signals.commanded and scale > 0.0 and abs(scale - 1.0) > _TOLERANCE:
        price = PRICE + _ANY_SCALE
        found.append(dataclasses.replace(
            wiring, scale=scale, price=wiring.price + price,
            cost=cost + price + targets.told(forward, scale)))
    return found
