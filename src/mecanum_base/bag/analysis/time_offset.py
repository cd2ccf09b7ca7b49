"""Time offset of the IMU's stamps against the encoders', and the ``imu.late`` it makes."""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.bag.analysis.agreement import yaw_agreement
from mecanum_base.bag.analysis.evidence import Evidence
from mecanum_base.bag.analysis.fitted_value import Value, refused
from mecanum_base.bag.analysis.motion import Gyro, wheel_matrix
from mecanum_base.core.estimation.sensors import LATEST

OFFSET = 'gyro time offset [s]'  # name of that constant
_HARMLESS = 0.005  # s


def time_offset(found: Evidence, offsets: list[Value]) -> float:
    """Time offset of the gyro, found without geometry; adds it to the constants."""
    if found.gyro is None:
        return 0.0
    up = found.robot.imu.base_from_sensor()[2]
    turned = Gyro(found.gyro.stamp_ns, np.column_stack([found.gyro.rate @ up] * 3),
                  found.gyro.accel)
    agreed = yaw_agreement(found.motion, turned, matrix=wheel_matrix(found.robot))
    if agreed is None or agreed.fit < 0.8 or not math.isfinite(agreed.offset_sigma):
        offsets.append(refused(OFFSET, 'too little turning, or wheels and gyro disagree: turn '
                               'two times around in each direction on the spot'))
        return 0.0
    half = agreed.offset_half
    offsets.append(Value(OFFSET, agreed.offset, agreed.offset - half, agreed.offset + half,
                         'observable'))
    return agreed.offset


def lateness(offsets: list[Value], old: float) -> tuple[float | None, list[str]]:
    """The new ``imu.late`` [s] for the ``old`` one and what recordings read with it still show,
    with a note why; None where it stays.

    Written where recordings agree on an offset that is surely not 0 and not harmless: 5 ms are
    half a sample of an ordinary encoder, and what a base lags behind its wheels.
    """
    given = [(v.value, v.low, v.high) for v in offsets
             if v.value is not None and v.low is not None and v.high is not None]
    if not given:
        return None, []
    value, low, high = (np.array(column) for column in zip(*given))
    if float(low.max()) > float(high.min()) + _HARMLESS:
        return None, [
            f'the time offset of the IMU differs from recording to recording '
            f'({1e3 * value.min():+.0f} to {1e3 * value.max():+.0f} ms): two clocks drift '
            'apart, imu.late is not written; stamp encoders and IMU by one clock, or synchronise '
            'both (PTP, chrony)']
    weight = 1.0 / np.maximum((high - low) / 2.0, 1e-4) ** 2
    late = float(value @ weight / weight.sum())
    if abs(late) <= max(_HARMLESS, float(weight.sum()) ** -0.5):
        return None, []
    new = round(old + late, 4)
    sense = 'late' if late > 0.0 else 'early'
    what = (f'the IMU is stamped {1e3 * abs(late):.0f} ms too {sense}, which puts the heading '
            f'{math.degrees(abs(late)):.1f} deg off while the base turns at 1 rad/s')
    if abs(new) > LATEST:
        return None, [f'{what}: imu.late = {new:.3f} s would be more than {LATEST} s, which is '
                      'another clock and no delay: let the driver of the IMU stamp by the clock '
                      'of the encoders']
    return new, [f'{what}: imu.late = {new:.4f} s is written']
