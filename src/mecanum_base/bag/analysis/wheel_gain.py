"""One wheel with wrong counts per revolution or radius: the factor that cures the parity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.bag.analysis.wiring_prices import PRICE
from mecanum_base.bag.analysis.wiring_signals import Signals
from mecanum_base.bag.analysis.wiring_target import Target
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import parity_basis
from mecanum_base.core.kinematics.wheels import Wheels

_LEAST = 0.05  # a smaller deviation is calibration


@dataclass(frozen=True, slots=True)
class WheelGain:
    """``wheel`` really turns ``factor`` times as far as it says; ``certainty`` over the other
    wheels, ``cost`` as in the wiring search (parity only)."""

    wheel: int
    factor: float
    certainty: float
    cost: float


def wheel_gain(signals: Signals, wheels: Wheels) -> WheelGain | None:
    """The wheel whose factor makes all wheels agree; None with three wheels or no such wheel."""
    basis = parity_basis(wheels_from_body(wheels))
    if not len(basis):
        return None
    found = []
    for wheel in range(wheels.count):
        # parity row . wheels = 0 solved for this wheel: its rate from all the others
        row = basis[int(np.argmax(np.abs(basis[:, wheel])))]
        others = np.delete(np.arange(wheels.count), wheel)
        told = -(signals.wheel[:, others] @ row[others]) / row[wheel]
        own = signals.wheel[:, [wheel]]
        target = Target(own, told)
        factor = target.scale(np.array([1.0]))
        joint = Target(signals.wheel, told)
        weights = np.zeros(wheels.count)
        weights[wheel] = factor
        cost = joint.cost(weights)
        found.append((cost, wheel, factor))
    found.sort()
    cost, wheel, factor = found[0]
    if abs(factor - 1.0) < _LEAST or factor <= 0.1 or factor > 10.0:
        return None
    weight = np.exp(-(np.array([f[0] for f in found]) - cost))
    return WheelGain(wheel, factor, min(float(1.0 / weight.sum()), 0.99), cost + PRICE + 1.0)
