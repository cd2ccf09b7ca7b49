"""Time offset of the IMU's stamps against the encoders', and what to do with it."""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.bag.analysis.agreement import yaw_agreement
from mecanum_base.bag.analysis.evidence import Evidence
from mecanum_base.bag.analysis.fitted_value import Value, refused
from mecanum_base.bag.analysis.motion import Gyro, wheel_matrix

OFFSET = 'gyro time offset [s]'  # name of that constant
_HARMLESS = 0.005  # s: half a sample of an ordinary encoder


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


def offset_notes(offsets: list[Value], reorder_wait: float) -> list[str]:
    """What the offsets of one or several recordings mean; ``reorder_wait`` s of the estimator."""
    given = [(v.value, v.low, v.high) for v in offsets
             if v.value is not None and v.low is not None and v.high is not None]
    if not given:
        return []
    value, low, high = (np.array(column) for column in zip(*given))
    if float(low.max()) > float(high.min()) + _HARMLESS:
        return [f'the time offset of the IMU differs from recording to recording '
                f'({1e3 * value.min():+.0f} to {1e3 * value.max():+.0f} ms): two clocks drift '
                'apart; stamp encoders and IMU by one clock, or synchronise both (PTP, chrony)']
    late = float(np.median(value))
    if abs(late) <= _HARMLESS:
        return []
    sense, cure = (('late', 'subtract {:.3f} s from') if late > 0.0 else
                   ('early', 'add {:.3f} s to'))
    text = (f'the IMU is stamped {1e3 * abs(late):.0f} ms too {sense}, which puts the heading '
            f'{math.degrees(abs(late)):.1f} deg off while the base turns at 1 rad/s. No key of '
            f'the robot file takes this number: let the driver of the IMU '
            f'{cure.format(abs(late))} header.stamp')
    if late > reorder_wait:
        text += (f'; if its messages also arrive that late, set estimator.reorder_wait to '
                 f'{math.ceil(100.0 * late + 1.0) / 100.0:.2f} s, or they will be dropped as late')
    return [text]
