"""Calibration over one or several recordings: evidence, windows, fit, measured distance."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.calibration import Calibration, calibrate, judged
from mecanum_base.bag.analysis.calibration_windows import together, windows_of
from mecanum_base.bag.analysis.evidence import Evidence, evidence_of
from mecanum_base.bag.analysis.fitted_value import Value
from mecanum_base.bag.analysis.imu_fit import mount_fit
from mecanum_base.bag.analysis.motion import dead_reckoned
from mecanum_base.bag.analysis.time_offset import lateness, time_offset
from mecanum_base.core.errors import BagError
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.robot import Robot

Update = Callable[[float, str], None]


def calibrate_bags(paths: list[str], robot: Robot, options: Any, update: Update) -> Calibration:
    """Fit the recordings together; BagError where none is long enough."""
    assert isinstance(robot.base, Wheels)
    matrix = wheels_from_body(robot.base)
    evidences: list[Evidence] = []
    offsets: list[Value] = []
    late: list[float] = []
    for number, path in enumerate(paths):
        found = evidence_of(path, robot, options.encoder_topic, options.imu_topic,
                            not options.no_imu, options.truth_topic,
                            functools.partial(_step, update, number, len(paths)),
                            options.truth_frame)
        evidences.append(found)
        late.append(time_offset(found, offsets))
    result = fitted(evidences, late, matrix)
    if result is None:
        raise BagError(f'{", ".join(paths)}: too short to calibrate: at least 8 s with wheels and '
                       'reference at the same time are needed')
    result.constants += offsets
    result.late, notes = lateness(offsets, robot.imu.late)
    result.notes += notes
    if result.late is not None:
        _wait(result, evidences, robot)
    if options.distance is not None:
        _measured(result, evidences, matrix, options)
    for number, evidence in enumerate(evidences):
        verdict = evidence.examined() if evidence.gyro is not None or evidence.truth else None
        wrong = [d for d in verdict.diagnoses if d.certainty > 0.9] if verdict else []
        result.notes += [f'{paths[number]}: {d.text}: correct this first (`mecanum doctor`)'
                         for d in wrong if d.fault not in ('time_offset', 'imu_tilt')]
    return result


def fitted(evidences: list[Evidence], late: list[float], matrix: FloatArray) -> Calibration | None:
    """Everything that recordings of one robot tell together; ``late`` s: offset of each gyro.

    None where none of them is long enough.
    """
    mount = mount_fit(evidences, late, matrix)
    up = mount.applied(evidences[0].robot.imu.base_from_sensor())[2]
    parts = [windows_of(e.motion, e.truth, e.gyro, up, t) for e, t in zip(evidences, late)]
    whole = [part for part in parts if part is not None]
    if not whole:
        return None
    result = calibrate(together(whole), matrix)
    result.mount = mount
    return result


def _step(update: Update, number: int, total: int, share: float) -> None:
    update((number + share) / total, f'{number + 1} of {total}')


def _wait(result: Calibration, evidences: list[Evidence], robot: Robot) -> None:
    """The reorder wait that the new lateness asks for, as the messages arrived."""
    assert result.late is not None
    moved_ns = round(1e9 * result.late) - robot.imu.late_ns
    wait = robot.estimator.reorder_wait
    found = [w for e in evidences if e.arrived is not None
             and (w := e.arrived.wait(moved_ns, wait)) is not None]
    if not found:
        return
    result.reorder_wait = max(found)
    who = 'IMU' if moved_ns > 0 else 'encoders'
    result.notes.append(
        f'read with it, messages of the {who} come later than estimator.reorder_wait = {wait:g} s '
        f'allows and would be dropped: {result.reorder_wait:g} s is written, by which the '
        'odometry is published later; better let the driver publish in time')


def _measured(result: Calibration, evidences: list[Evidence], matrix: Any,
              options: Any) -> None:
    """Put the scale from a distance measured by hand in place of the axis it was driven along."""
    axis = 0 if options.along == 'forward' else 1
    ratios = []
    for evidence in evidences:
        pose = dead_reckoned(evidence.motion, matrix)
        step = pose[-1, :2] - pose[0, :2]
        length = float(np.hypot(*step))
        if length < 0.3 or abs(step[axis]) < 0.95 * length or abs(pose[-1, 2]) > 0.2:
            result.notes.append(
                f'a measured distance needs a straight drive {options.along}; the wheels say '
                f'x {step[0]:.2f} m, y {step[1]:.2f} m, yaw {math.degrees(pose[-1, 2]):.0f} deg')
            return
        ratios.append(options.distance / length)
    value = float(np.mean(ratios))
    spread = float(np.std(ratios)) / math.sqrt(len(ratios)) if len(ratios) > 1 else 0.0
    half = 1.645 * math.hypot(options.distance_sigma / options.distance * value, spread, 0.003)
    result.source = f'measured distance and {result.source}'
    result.axes[options.along] = judged(options.along, value, half)
