"""Dead reckoning from the wheels alone: the baseline every estimate is compared with.

    increment = (A' A)^-1 A' step          step (W,): travel along the roller axes, minimised in m
    pose <- pose . Exp(increment)          exact for a constant twist over the step

With a gyro increment given, it replaces the wheels' own yaw (wheels + gyro heading).
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core import se2
from mecanum_base.core.estimation.encoder import WheelAngles
from mecanum_base.core.estimation.geometry import (
    Base,
    carrier_table,
    hinge_increment,
    rolling_rows,
    travel_per_radian,
)
from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.records import TickSample, WheelSample


class WheelOdometry:
    """Wheel-only pose (3,) in odom, starting at 0, 0, 0."""

    def __init__(self, base: Base, encoder: EncoderConfig) -> None:
        self._base = base
        self._angles = WheelAngles(encoder, base.count, np.repeat(
            base.max_speed, 2) if isinstance(base, Carriers) else base.max_speed)
        self._travel = travel_per_radian(base)
        self._rows = rolling_rows(base)
        self._inverse = np.linalg.pinv(self._rows)
        self._hinge = np.array(base.initial_angle) if isinstance(base, Carriers) else np.zeros(0)
        self._last: FloatArray | None = None
        self._stamp: int | None = None
        self.pose: FloatArray = np.zeros(3)
        self.twist: FloatArray = np.zeros(3)

    def handle(self, sample: WheelSample | TickSample,
               yaw_increment: float | None = None) -> FloatArray:
        """Take one encoder sample (in the order of stamps); the pose (3,) after it."""
        reading = self._angles.read(sample)
        if isinstance(reading, str):
            return self.pose
        travel = reading.angle * self._travel
        last, self._last = self._last, travel
        before, self._stamp = self._stamp, reading.stamp_ns
        if last is None or before is None:
            return self.pose
        increment = self._increment(travel - last, reading.valid)
        if yaw_increment is not None:
            increment[2] = yaw_increment
        self.twist = increment / ((reading.stamp_ns - before) * 1e-9)
        self.pose = se2.compose(self.pose, se2.exp(increment))
        if isinstance(self._base, Carriers):
            table = carrier_table(self._base)
            self._hinge = self._hinge + hinge_increment(table, self._hinge, increment)
            self._rows = rolling_rows(self._base, self._hinge)
            self._inverse = np.linalg.pinv(self._rows)
        return self.pose

    def _increment(self, step: FloatArray, valid: FloatArray) -> FloatArray:
        if valid.all():
            increment: FloatArray = self._inverse @ step
            return increment
        seen = valid > 0.0
        if np.linalg.matrix_rank(self._rows[seen]) < 3:
            return np.zeros(3)
        partial: FloatArray = np.linalg.pinv(self._rows[seen]) @ step[seen]
        return partial
