"""Columns for the plots of a report, thinned so that a page stays small."""

from __future__ import annotations

from typing import Any

import numpy as np

from mecanum_base.bag.analysis.agreement import yaw_integral
from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.estimate import EstimatedTrack
from mecanum_base.bag.analysis.imu_checks import resting_at
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion, twist_of
from mecanum_base.bag.analysis.recording import Recording, Series
from mecanum_base.core.parameter import FloatArray

POINTS = 1500


def columns(recording: Recording, motion: WheelMotion | None, gyro: Gyro | None,
            matrix: FloatArray | None, estimate: EstimatedTrack | None,
            tracks: dict[str, Track], aligned: dict[str, FloatArray], truth: Track | None,
            encoder: Series | None) -> dict[str, Any]:
    """{'paths': ..., 'errors': ..., 'wheels': ..., 'yaw': ..., 'slip': ..., 'periods': ...}."""
    origin = recording.origin_ns
    found: dict[str, Any] = {}
    if tracks:
        found['paths'] = {name: _thin(x=t.pose[:, 0], y=t.pose[:, 1])
                          for name, t in tracks.items()}
        best = next((n for n in ('estimator', 'wheels only', *tracks) if n in aligned), None)
        if best is not None:
            real = aligned[best]
            found['paths']['truth'] = _thin(x=real[:, 0], y=real[:, 1])
    if truth is not None and aligned:
        found['errors'] = {name: _error(tracks[name], truth, real, origin)
                           for name, real in aligned.items()}
    if motion is not None:
        seconds, rate = _smooth_rates(motion, origin)
        found['wheels'] = {joint: _thin(x=seconds, y=rate[:, i])
                           for i, joint in enumerate(motion.joints)}
    if gyro is not None:
        found['yaw'] = _yaw(motion, gyro, matrix, origin)
    if estimate is not None:
        at = (estimate.stamp_ns - origin) / 1e9
        joints = motion.joints if motion is not None else ()
        found['slip'] = {'any wheel': _peaks(at, estimate.body)}
        found['slip'].update({joint: _peaks(at, estimate.probability[:, i])
                              for i, joint in enumerate(joints)})
        found['sigma'] = _thin(x=at, position=estimate.sigma[:, 0],
                               yaw=np.degrees(estimate.sigma[:, 1]))
    if encoder is not None:
        step = np.diff(encoder.stamp_ns) / 1e6
        at = (encoder.log_ns[1:] - origin) / 1e9
        found['periods'] = {encoder.channel.topic: _peaks(at, step)}
    return found


def _thin(**named: FloatArray) -> dict[str, list[float]]:
    """Every n-th value, rounded to six digits; the last one is kept."""
    size = len(next(iter(named.values())))
    keep = np.unique(np.append(np.arange(0, size, max(size // POINTS, 1)), max(size - 1, 0)))
    return {name: _digits(np.asarray(values)[keep]) for name, values in named.items()}


def _peaks(x: FloatArray, y: FloatArray) -> dict[str, list[float]]:
    """The largest value of each stretch, so that short events stay visible."""
    if len(x) <= POINTS:
        return {'x': _digits(x), 'y': _digits(y)}
    edges = np.linspace(0, len(x), POINTS + 1).astype(int)[:-1]
    return {'x': _digits(x[edges]), 'y': _digits(np.maximum.reduceat(y, edges))}


def _digits(values: FloatArray) -> list[float]:
    return [float(f'{v:.6g}') for v in np.asarray(values, dtype=float)]


def _smooth_rates(motion: WheelMotion, origin: int) -> tuple[FloatArray, FloatArray]:
    """Wheel rates over at least 50 ms: finer ones are counting noise."""
    seconds, _ = motion.rates()
    usual = float(np.median(np.diff(motion.seconds)))
    stride = max(1, int(round(0.05 / max(usual, 1e-6))))
    rows = motion.angle[::stride]
    at = (motion.stamp_ns[::stride] - origin) / 1e9
    if len(rows) < 2:
        return seconds, motion.rates()[1]
    return (at[1:] + at[:-1]) / 2.0, np.diff(rows, axis=0) / np.diff(at)[:, None]


def _yaw(motion: WheelMotion | None, gyro: Gyro, matrix: FloatArray | None,
         origin: int) -> dict[str, Any]:
    at = (gyro.stamp_ns - origin) / 1e9
    turned = np.degrees(yaw_integral(gyro))
    found = {'gyro': _thin(x=at, y=turned)}
    rest = resting_at(gyro, motion)
    if rest.sum() >= 20:
        bias = float(np.degrees(np.nanmean(gyro.rate[rest, 2])))
        found['gyro without its bias at rest'] = _thin(x=at, y=turned - bias * (at - at[0]))
    if motion is not None and matrix is not None:
        seconds, twist = twist_of(motion, matrix)
        step = np.diff(motion.seconds)
        start = (int(motion.stamp_ns[0]) - origin) / 1e9
        found['wheels'] = _thin(x=seconds + start, y=np.degrees(np.cumsum(twist[:, 2] * step)))
    return found


def _error(track: Track, truth: Track, real: FloatArray, origin: int) -> dict[str, Any]:
    inside = (truth.stamp_ns >= track.stamp_ns[0]) & (truth.stamp_ns <= track.stamp_ns[-1])
    stamp = truth.stamp_ns[inside]
    own = (track.stamp_ns - origin) / 1e9
    at = (stamp - origin) / 1e9
    x, y = (np.interp(at, own, track.pose[:, i]) for i in (0, 1))
    size = min(len(at), len(real))
    return _thin(x=at[:size], y=np.hypot(x[:size] - real[:size, 0], y[:size] - real[:size, 1]))
