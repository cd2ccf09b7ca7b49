"""Exact odometry for wheels whose roller phase is known (index pulse), G eq. 15 integrated.

While the wheels turn by D_i, the body increment per unit path s in [0, 1] is

    xi(s) = H(theta(s))^+ D,     theta(s) = theta_0 + s D,     dX/ds = X xi(s)^

with the exact H of :mod:`mecanum_base.core.contact.rate`; for more than three wheels H is
over-determined at unrelated phases and the least-squares increment in rad is taken, its residual
being genuine forced slip (up to 4-5 % of the wheel rate with 8 rollers). The path is cut at every
hand-over, where H jumps, and each piece is integrated by the fourth-order Magnus rule

    Omega = (h/2)(xi_1 + xi_2) + (sqrt(3)/12) h^2 [xi_1, xi_2]     at the two Gauss points.

Without an index pulse use the mean correction (``wheels_from_body(wheels)``), with no roller count
the nominal H. Not modelled: slip that the wheels do not force upon each other.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core import se2
from mecanum_base.core.contact.rate import require_pin_radius, wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels, weights
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

MAX_STEP = 0.02  # rad of the fastest wheel per integration step: pose error below 1e-8 m a metre


def exact_twist(wheels: Wheels, angles: FloatArray, rates: FloatArray,
                weighting: str = 'rate') -> FloatArray:
    """Twist (3,) from wheel rates (W,) rad/s at angles (W,) rad from the index (G15 inverted)."""
    matrix = wheels_from_body(wheels, angles)
    twist: FloatArray = body_from_wheels(matrix, weights(wheels, weighting)) @ rates
    return twist


def integrate(wheels: Wheels, angles: FloatArray, turns: FloatArray,
              pose: FloatArray | None = None, *, max_step: float = MAX_STEP) -> FloatArray:
    """Pose (3,) after the wheels went from ``angles`` (W,) by ``turns`` (W,) rad, evenly.

    ``angles`` are counted from the index pulse (a roller central under the axle), ``pose`` is the
    start (origin if None), ``max_step`` rad. Yaw is not wrapped. Raises ConfigError where a pin
    radius is needed and unknown.
    """
    require_pin_radius(wheels)
    here = np.zeros(3) if pose is None else pose
    cuts = [0.0, *handovers(wheels, angles, turns), 1.0]
    for first, last in zip(cuts[:-1], cuts[1:]):
        steps = max(1, math.ceil((last - first) * float(np.max(np.abs(turns))) / max_step))
        step = (last - first) / steps
        for index in range(steps):
            here = se2.compose(here, se2.exp(
                _magnus(wheels, angles, turns, first + index * step, step)))
    return here


class ExactOdometer:
    """Pose from absolute wheel angles, the roller phases known from an index pulse.

    ``index`` (W,) rad: the encoder angle of each wheel at its index pulse, at which a roller is
    central under the axle. Raises ConfigError where a pin radius is needed and unknown.
    """

    def __init__(self, wheels: Wheels, index: FloatArray, pose: FloatArray | None = None) -> None:
        require_pin_radius(wheels)
        self._wheels = wheels
        self._index = np.array(index, dtype=np.float64)
        self._position: FloatArray | None = None
        self.pose = np.zeros(3) if pose is None else np.array(pose, dtype=np.float64)

    def update(self, position: FloatArray) -> FloatArray:
        """Pose (3,) at the encoder angles ``position`` (W,) rad, unwrapped; the first one arms."""
        if self._position is not None:
            self.pose = integrate(self._wheels, self._position - self._index,
                                  position - self._position, self.pose)
        self._position = np.array(position, dtype=np.float64)
        return self.pose


def _magnus(wheels: Wheels, angles: FloatArray, turns: FloatArray, start: float,
            step: float) -> FloatArray:
    """Body increment (3,) over [start, start + step] of the path, fourth order."""
    offset = math.sqrt(3.0) / 6.0
    one, two = (exact_twist(wheels, angles + (start + step * (0.5 + side)) * turns, turns)
                for side in (-offset, offset))
    bracket = np.array([two[2] * one[1] - one[2] * two[1], one[2] * two[0] - two[2] * one[0], 0.0])
    omega: FloatArray = (step / 2.0) * (one + two) + (math.sqrt(3.0) / 12.0) * step**2 * bracket
    return omega


def handovers(wheels: Wheels, angles: FloatArray, turns: FloatArray) -> list[float]:
    """Sorted path fractions in (0, 1) at which some wheel changes its roller, repeats kept."""
    found: list[float] = []
    for index, count in enumerate(wheels.roller_count):
        if not count or turns[index] == 0.0:
            continue
        pitch = 2.0 * math.pi / int(count)
        start, end = angles[index] / pitch + 0.5, (angles[index] + turns[index]) / pitch + 0.5
        low, high = min(start, end), max(start, end)
        found += [(whole - start) / (end - start)
                  for whole in range(math.ceil(low), math.floor(high) + 1) if low < whole < high]
    return sorted(found)
