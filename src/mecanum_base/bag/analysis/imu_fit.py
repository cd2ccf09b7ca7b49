"""The mounting of the IMU from the evidence of all recordings: level first, then the yaw."""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.bag.analysis.calibration import axis_fits
from mecanum_base.bag.analysis.calibration_windows import together, windows_of
from mecanum_base.bag.analysis.drift import Track, has_heading
from mecanum_base.bag.analysis.evidence import Evidence
from mecanum_base.bag.analysis.fitted_value import Value
from mecanum_base.bag.analysis.imu_levels import level_of, stops_of, turns_of
from mecanum_base.bag.analysis.imu_mount import SHEAR, MountFit, level_turns, yaw_turn
from mecanum_base.bag.analysis.imu_pushes import Pushes, pushes_of, wheel_track
from mecanum_base.bag.analysis.motion import Gyro
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.parameter import FloatArray


def mount_fit(evidences: list[Evidence], late: list[float], matrix: FloatArray) -> MountFit:
    """Fit the recordings together; ``late`` s a recording: offset of the IMU's stamps.

    Empty where no recording has an IMU.
    """
    pairs = [(e, t) for e, t in zip(evidences, late) if e.gyro is not None]
    if not pairs:
        return MountFit()
    imu = pairs[0][0].robot.imu
    file = imu.base_from_sensor()
    rotated = [_rotated(e.gyro, file) for e, _ in pairs]
    level, missing = level_of([stops_of(g, e.motion) for g, (e, _) in zip(rotated, pairs)],
                              [turns_of(g, e.motion) for g, (e, _) in zip(rotated, pairs)])
    turns = level_turns(level, missing)
    levelled = MountFit(dict(turns)).applied(file)
    rotated = [_rotated(e.gyro, levelled) for e, _ in pairs]
    lever = np.asarray(imu.xyz, dtype=np.float64)[:2]
    parts: list[Pushes] = []
    for gyro, (evidence, offset) in zip(rotated, pairs):
        late_ns = int(offset * 1e9)
        track = wheel_track(evidence.motion, matrix, gyro, late_ns)
        found = pushes_of(track, gyro, lever, late_ns)
        parts += [found] if found is not None else []
    turns['z'] = yaw_turn(parts, 'wheels', SHEAR)
    if not turns['z'].given:
        other = _from_truth(pairs, rotated, lever, levelled[2], matrix)
        turns['z'] = other if other is not None and other.given else turns['z']
    return MountFit(turns)


def _rotated(gyro: Gyro | None, turn: FloatArray) -> Gyro:
    assert gyro is not None
    return Gyro(gyro.stamp_ns, gyro.rate @ turn.T, gyro.accel @ turn.T)


def _from_truth(pairs: list[tuple[Evidence, float]], rotated: list[Gyro], lever: FloatArray,
                up: FloatArray, matrix: FloatArray) -> Value | None:
    """The yaw against a true pose whose markers are turned by the angle that the wheels tell."""
    chosen = [(e, g, t) for (e, t), g in zip(pairs, rotated)
              if e.truth is not None and has_heading(e.truth, 1.0)]
    windows = [w for e, _, t in chosen
               if (w := windows_of(e.motion, e.truth, e.gyro, up, t)) is not None]
    if not windows:
        return None
    whole = together(windows)
    good = np.isfinite(whole.moved).all(axis=1)
    whole = whole.where(good)
    fits = [fit for fit in axis_fits(whole, whole.wheel @ body_from_wheels(matrix).T)[:2]
            if fit is not None]
    if not fits:
        return None
    # unequal radii turn the ways forward and sideways oppositely
    angle = float(np.mean([math.atan2(float(f.value[1]), float(f.value[0])) for f in fits]))
    sigma = float(np.linalg.norm([f.sigma[1] / abs(f.value[0]) for f in fits])) / len(fits)
    sigma = math.hypot(sigma, SHEAR if len(fits) == 1 else 0.0)
    parts: list[Pushes] = []
    for evidence, gyro, offset in chosen:
        truth = evidence.truth
        assert truth is not None
        track = Track(truth.stamp_ns, truth.pose + np.array([0.0, 0.0, angle]))
        found = pushes_of(track, gyro, lever, int(offset * 1e9))
        parts += [found] if found is not None else []
    return yaw_turn(parts, 'true pose', 0.0, sigma)
