"""Lines of the robot file that put wheels into another order or turn their signs.

By name (joint_states) the places stay and the names move: column i gets the name of column
order[i]. Counts (wheel_ticks) come in the order of the columns, so there the places move: column
order[i] gets the place of column i, and its name with it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import IntArray
from mecanum_base.robot import Robot

_PLACES = ('x', 'y', 'axle', 'roller', 'radius', 'roller_pin_radius', 'max_speed')


def order_lines(robot: Robot, order: tuple[int, ...], sign: tuple[int, ...]) -> tuple[str, ...]:
    """Lines for wheel i being really column ``order[i]`` times ``sign[i]``; the line with the
    names first."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    if not _counted(robot):
        lines = [f'joint: [{", ".join(wheels.joint[j] for j in order)}]']
    else:
        place = np.argsort(order)
        lines = [f'joint: [{", ".join(wheels.joint[i] for i in place)}]']
        for key in _PLACES:
            column = getattr(wheels, key)
            if (column[place] != column).any():
                lines.append(f'{key}: {listed(column[place])}')
        if (wheels.roller_count[place] != wheels.roller_count).any():
            lines.append(f'roller_count: {wheels.roller_count[place].tolist()}')
    old = robot.encoder.for_wheels(wheels.count)[1]
    new = signs(robot, order, sign)
    return (*lines, f'sign: {new.tolist()}') if (new != old).any() else tuple(lines)


def signs(robot: Robot, order: tuple[int, ...], sign: tuple[int, ...]) -> IntArray:
    """``encoder.sign`` (W,) for the corrected order."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    old = robot.encoder.for_wheels(wheels.count)[1].astype(np.int64)
    column = np.array(order)
    turned: IntArray = old[column] * np.array(sign, dtype=np.int64)  # by place
    return turned[np.argsort(column)] if _counted(robot) else turned


def reversed_places(robot: Robot, order: tuple[int, ...], sign: tuple[int, ...]) -> list[int]:
    """Places whose encoder runs backwards, beside a change of the order in which signs either
    move with the wheels or stay where they are."""
    old = robot.encoder.for_wheels(len(order))[1]
    moved = np.array(sign)
    stayed = moved * old[list(order)] * old
    flips = min((moved, stayed), key=lambda column: int(np.sum(column < 0)))
    return [int(i) for i in np.flatnonzero(flips < 0)]


def _counted(robot: Robot) -> bool:
    return robot.encoder.source == 'wheel_ticks'


def listed(values: Any) -> str:
    """A YAML list of floats, six digits."""
    return '[' + ', '.join(_decimal(float(v)) for v in values) + ']'


def _decimal(value: float) -> str:
    text = f'{value + 0.0:.6g}'
    return text if set(text) & set('.e') else text + '.0'
