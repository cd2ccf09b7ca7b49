"""What `mecanum check` says of the lateness of the IMU's stamps."""

from __future__ import annotations

import math

from mecanum_base.robot import Robot

_RESERVE = 0.02  # s for the ways of the messages


def late_warning(robot: Robot) -> str:
    """A warning where ``imu.late`` moves stamps by more than the merge waits; else nothing.

    A sample that is older than the newest of any stream by more than ``estimator.reorder_wait`` is
    dropped. Stamps of the IMU moved back by more are that old when they come, those moved ahead
    make the encoders' so.
    """
    late, wait = robot.imu.late, robot.estimator.reorder_wait
    if abs(late) <= wait:
        return ''
    needed = min(math.ceil(100.0 * (abs(late) + _RESERVE) - 1e-6) / 100.0, 1.0)
    who, when, enough = (
        ('IMU', 'at the time of their stamps', 'come with a clock that is ahead') if late > 0.0
        else ('encoders', 'at once', 'come as much before those of the IMU'))
    return (f'warning: imu.late = {late:g} s is more than estimator.reorder_wait = {wait:g} s: '
            f'messages of the {who} that arrive {when} would be dropped as late; set '
            f'estimator.reorder_wait to {needed:.2f} s (not needed where they {enough})')
