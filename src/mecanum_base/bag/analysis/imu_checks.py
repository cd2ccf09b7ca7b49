"""Checks of the IMU: frozen values, bias at rest, gravity, units, vibration."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.findings import Finding, spans_where
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.core.parameter import FloatArray

GRAVITY = 9.80665
_FROZEN = 0.3  # s
_LEAK = math.radians(2.0)
_VIBRATION = 1.5  # m/s^2 rms from sample to sample


def imu_findings(topic: str, gyro: Gyro, motion: WheelMotion | None) -> list[Finding]:
    """What the IMU tells, with the wheels as witness of rest and motion where there are any."""
    seconds = (gyro.stamp_ns - gyro.stamp_ns[0]) / 1e9
    rest = resting_at(gyro, motion)
    found = _absent(topic, gyro)
    found += _frozen(topic, gyro, seconds, rest, motion is not None)
    found += _rest(topic, gyro, seconds, rest, motion)
    found += _gravity(topic, gyro, rest)
    found += _vibration(topic, gyro, rest)
    return found


def resting_at(gyro: Gyro, motion: WheelMotion | None) -> Any:
    """Flag (N,) on the IMU's stamps: the wheels rest there and 0.2 s around."""
    if motion is None:
        return np.zeros(len(gyro.stamp_ns), dtype=bool)
    rest = motion.resting().astype(float)
    shift = np.int64(200_000_000)
    flags = [np.interp(gyro.stamp_ns + d, motion.stamp_ns, rest, left=0.0, right=0.0) > 0.999
             for d in (-shift, np.int64(0), shift)]
    return flags[0] & flags[1] & flags[2]


def _absent(topic: str, gyro: Gyro) -> list[Finding]:
    found = []
    if np.isnan(gyro.accel).all():
        found.append(Finding('note', 'no_accelerometer', 'the IMU has no accelerometer',
                             'linear_acceleration_covariance[0] is -1',
                             'slip of a whole diagonal cannot be seen without it', topic))
    if np.isnan(gyro.rate).all():
        found.append(Finding('warning', 'no_gyro', 'the IMU has no gyro',
                             'angular_velocity_covariance[0] is -1', 'yaw comes from the wheels '
                             'alone', topic))
    for axis, name in enumerate('xyz'):
        column = gyro.rate[:, axis]
        if np.isfinite(column).all() and len(column) > 50 and np.ptp(column) == 0.0:
            found.append(Finding(
                'blocker' if name == 'z' else 'note', 'gyro_axis_constant',
                f'gyro {name} never changes', f'{column[0]!s} rad/s in all {len(column)} messages',
                'the driver does not fill this axis' + (
                    '' if name != 'z' else ': without it yaw comes from the wheels alone; use '
                    '--no-imu'), topic))
    return found


def frozen_spans(gyro: Gyro) -> list[tuple[float, float]]:
    """Stretches (start, end) s since the first sample in which every reading repeats exactly."""
    seconds = (gyro.stamp_ns - gyro.stamp_ns[0]) / 1e9
    every = np.column_stack([gyro.rate, gyro.accel])
    used = every[:, np.isfinite(every).all(axis=0)]
    used = used[:, np.ptp(used, axis=0) > 0.0] if used.size else used
    if used.shape[1] == 0:
        return []
    same = (np.diff(used, axis=0) == 0.0).all(axis=1)
    return [s for s in spans_where(same, seconds[1:], _FROZEN)
            if np.sum((seconds >= s[0]) & (seconds <= s[1])) >= 15]


def _frozen(topic: str, gyro: Gyro, seconds: FloatArray, rest: Any,
            wheels: bool) -> list[Finding]:
    spans = frozen_spans(gyro)
    moving = [s for s in spans if not rest[(seconds >= s[0]) & (seconds <= s[1])].all()]
    if not spans:
        return []
    severe = bool(moving) and wheels
    chosen = moving if severe else spans
    longest = max(chosen, key=lambda s: s[1] - s[0])
    return [Finding(
        'warning' if severe else 'note', 'imu_frozen',
        'the IMU repeats exactly the same values' + (' while the robot moves' if severe else ''),
        f'{sum(e - s for s, e in chosen):.2f} s in {len(chosen)} stretches, the longest '
        f'{longest[1] - longest[0]:.2f} s from {longest[0]:.2f} s on',
        'the sensor or its bus hangs: check wiring and supply; a frozen gyro is used as if it '
        'were true unless the driver stops publishing', topic, tuple(chosen),
        {'seconds': float(sum(e - s for s, e in chosen))})]


def _rest(topic: str, gyro: Gyro, seconds: FloatArray, rest: Any,
          motion: WheelMotion | None) -> list[Finding]:
    if motion is None:
        return []
    good = rest & np.isfinite(gyro.rate).all(axis=1)
    total = float(np.sum(np.diff(seconds)[good[1:]])) if len(seconds) > 1 else 0.0
    if total < 0.5 or good.sum() < 20:
        return [Finding(
            'note', 'no_rest', 'the robot never stands still with the IMU running',
            f'{total:.1f} s at rest', 'stand still for 3 s before and after a drive: the gyro '
            'bias is then known to 0.01 deg/s', topic)]
    bias, noise = gyro.rate[good].mean(axis=0), gyro.rate[good].std(axis=0)
    size = abs(float(bias[2]))
    severity = 'note' if size < 0.02 else 'warning'
    return [Finding(
        severity, 'gyro_bias', f'gyro bias at rest is {bias[2]:+.4f} rad/s about z',
        f'x {bias[0]:+.4f}, y {bias[1]:+.4f}, z {bias[2]:+.4f} rad/s over {total:.1f} s; noise '
        f'{noise[2]:.4f} rad/s', 'the estimator learns it at every stop'
        + ('' if size < 0.02 else '; this is large: let the driver calibrate it at start'), topic,
        spans_where(good, seconds, 0.3)[:20],
        {'x': float(bias[0]), 'y': float(bias[1]), 'z': float(bias[2]),
         'noise': float(noise[2]), 'seconds': total})]


def _gravity(topic: str, gyro: Gyro, rest: Any) -> list[Finding]:
    good = np.isfinite(gyro.accel).all(axis=1)
    if not good.any():
        return []
    still = good & rest
    chosen = still if still.sum() >= 20 else good
    mean = gyro.accel[chosen].mean(axis=0)
    size = float(np.linalg.norm(mean))
    where = 'at rest' if still.sum() >= 20 else 'on average'
    numbers = {'x': float(mean[0]), 'y': float(mean[1]), 'z': float(mean[2]), 'size': size}
    shown = f'mean acceleration {where}: {mean[0]:+.2f}, {mean[1]:+.2f}, {mean[2]:+.2f} m/s2'
    if 0.8 < size < 1.2 and abs(mean).max() > 0.8:
        return [Finding('blocker', 'accel_in_g', 'the accelerometer is in g, not in m/s2', shown,
                        'multiply by 9.80665 in the driver (REP-145)', topic, numbers=numbers)]
    if size < 0.5 * GRAVITY:
        return [Finding('warning', 'gravity_removed', 'the accelerometer does not show gravity',
                        shown, 'the driver has already removed it (REP-145 wants +9.81 on z at '
                        'rest): publish the raw acceleration; z stays unused', topic,
                        numbers=numbers)]
    if not 0.9 * GRAVITY < size < 1.1 * GRAVITY:
        return [Finding('warning', 'accel_scale', 'the accelerometer does not read 9.81 m/s2',
                        shown, 'check its range setting and calibration', topic, numbers=numbers)]
    axis = int(np.argmax(abs(mean)))
    if axis != 2 or mean[2] < 0.0:
        return [Finding('blocker', 'imu_tilted', 'gravity is not on +z of the IMU', shown,
                        'the IMU is mounted another way up than imu.rpy says; `mecanum doctor` '
                        'names the rotation', topic, numbers=numbers)]
    tilt = math.atan2(math.hypot(mean[0], mean[1]), mean[2])
    if tilt > _LEAK and still.sum() >= 20:
        return [Finding('warning', 'gravity_leak', 'gravity leaks into x and y of the IMU',
                        f'{shown}: a tilt of {math.degrees(tilt):.1f} deg',
                        'correct imu.rpy or level the sensor; the estimator learns a constant '
                        'leak as accelerometer bias', topic, numbers={**numbers, 'tilt': tilt})]
    return []


def _vibration(topic: str, gyro: Gyro, rest: Any) -> list[Finding]:
    good = np.isfinite(gyro.accel[:, :2]).all(axis=1) & ~rest
    accel = gyro.accel[good][:, :2]
    if len(accel) < 50:
        return []
    rough = float(np.sqrt(np.mean((accel[2:] - 2 * accel[1:-1] + accel[:-2]) ** 2) / 6.0))
    if rough < _VIBRATION:
        return []
    return [Finding('warning', 'vibration', 'strong vibration',
                    f'{rough:.1f} m/s2 rms from sample to sample while driving',
                    'mount the IMU on rubber; slip of a whole diagonal is hard to see in this',
                    topic, numbers={'rms': rough})]
