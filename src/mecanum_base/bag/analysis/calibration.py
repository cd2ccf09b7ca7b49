"""Constants of a base from recordings: scales, lever, lateral factor, gyro scale, wheel radii.

With the forward matrix B of the robot file and wheel angles dphi of a window (models.md 2.1)

    reference = (s_x, s_y, s_w) * (B dphi) + frame of the reference        (one s an axis)

    s_x = rho          common radius          s_y / s_x = kappa   lateral factor, tan(delta)
    s_x / s_w = lambda  lever arm             gyro = g * yaw of the reference

The reference frame (mounting of the markers) has an unknown small angle and offset, which are
fitted along. A value is given only where the motion excited it, else the manoeuvre is named.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.calibration_windows import Windows
from mecanum_base.bag.analysis.contradiction import agreeing
from mecanum_base.bag.analysis.fitted_value import LEVEL, Value, refused
from mecanum_base.bag.analysis.imu_mount import MountFit
from mecanum_base.bag.analysis.robust_fit import Fit, robust_fit
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.parameter import FloatArray

GYRO_SCALE = 'gyro scale'  # name of that constant
WIDEST = 0.03  # half width of a scale that is still worth giving
_SHARE = 0.15  # of the way must be along an axis
_WAY = {'forward': 1.5, 'sideways': 1.5, 'turning': 6.0}  # m, m, rad
_CLUSTERS = 4
# standard deviations by which a scale depends on how the base is driven (creep, rollers, unequal
# radii): what tests/bag/physics_coverage.py finds beyond the scatter of the fit in 140 robots;
# nothing forward, and wheels have no part in the scale of the gyro
_DRIVEN = {'sideways': 0.0001, 'turning': 0.0005}
_GYRO_SCALE = 0.005  # standard deviation of the scale of an uncalibrated gyro
_FRAME = (math.radians(5.0), 0.2)  # rad, m: how far the markers may be off
_UNEQUAL = 0.1  # rad/m: how far unequal radii may turn a base that drives straight
MANOEUVRE = {'forward': 'drive 3 m forward and back, twice',
             'sideways': 'drive 3 m sideways and back, twice',
             'turning': 'turn two times around in each direction on the spot'}


@dataclass(slots=True)
class Calibration:
    """Scales by axis, constants, and how well they do on time that was not used for the fit."""

    source: str
    axes: dict[str, Value] = field(default_factory=dict)
    constants: list[Value] = field(default_factory=list)
    wheels: list[Value] = field(default_factory=list)
    mount: MountFit = field(default_factory=MountFit)
    late: float | None = None  # s, the new imu.late
    reorder_wait: float | None = None  # s, the new estimator.reorder_wait, which that asks for
    held_out: dict[str, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def plain(self) -> dict[str, Any]:
        """As JSON values."""
        return asdict(self)

    def scale(self, axis: str) -> float:
        """Scale of an axis; 1 where none is given."""
        value = self.axes.get(axis)
        return 1.0 if value is None or value.value is None else value.value


def calibrate(windows: Windows, matrix: FloatArray) -> Calibration:
    """Fit what the windows can tell; ``matrix`` H (W, 3) of the robot file."""
    forward = body_from_wheels(matrix)
    windows = windows.where(agreeing(windows.wheel, matrix))
    wheels = windows.wheel @ forward.T
    with_truth = bool(np.isfinite(windows.moved).all(axis=1).any())
    found = Calibration('true pose' if with_truth else 'gyro')
    if with_truth:
        good = np.isfinite(windows.moved).all(axis=1)
        part = windows.where(good)
        fits = axis_fits(part, wheels[good])
        for axis, name in enumerate(('forward', 'sideways', 'turning')):
            found.axes[name] = _axis_value(name, axis, fits[axis], wheels[good])
        found.held_out = held_out(part, wheels[good])
        found.wheels = wheel_values(part, forward, found, fits)
        found.constants += _gyro_scale(part)
    else:
        found.axes['forward'] = refused('forward', 'no reference for distances: record a true '
                                        'pose, or give --distance')
        found.axes['sideways'] = refused('sideways', 'no reference for distances: record a true '
                                         'pose, or give --distance')
        found.axes['turning'] = _from_gyro(windows, wheels)
    return found


def axis_fits(windows: Windows, wheels: FloatArray) -> list[Fit | None]:
    """Robust fit of each axis: scale first, then angle and offset of the reference frame (for
    turning: the turn that unequal radii make of straight driving)."""
    x, y, w = wheels.T
    designs = [np.column_stack([x, -y, -w]), np.column_stack([y, x, w]),
               np.column_stack([w, x, y])]
    result: list[Fit | None] = []
    for axis, design in enumerate(designs):
        prior = np.zeros(design.shape[1])
        prior[0] = 1.0
        spread = np.full(design.shape[1], np.inf)
        spread[1:] = _FRAME if axis < 2 else _UNEQUAL
        result.append(robust_fit(design, windows.moved[:, axis], windows.cluster, prior, spread))
    return result


def excited(name: str, axis: int, wheels: FloatArray) -> str:
    """Empty if the motion along an axis is enough, else what is missing."""
    way = np.abs(wheels).sum(axis=0)
    total = float(way[0] + way[1])
    own = float(way[axis])
    unit = 'rad' if name == 'turning' else 'm'
    if own < _WAY[name]:
        return f'only {own:.2f} {unit} {name}: {MANOEUVRE[name]}'
    if axis < 2 and own < _SHARE * total:
        return (f'only {own:.2f} of {total:.2f} m are {name}, the rest would drown it: '
                f'{MANOEUVRE[name]}')
    return ''


def _axis_value(name: str, axis: int, fit: Fit | None, wheels: FloatArray) -> Value:
    missing = excited(name, axis, wheels)
    if missing:
        return refused(name, missing)
    if fit is None or fit.clusters[0] < _CLUSTERS:
        return refused(name, f'the motion is too short or all in one go: {MANOEUVRE[name]}')
    return judged(name, float(fit.value[0]), fit.half_width(0, LEVEL))


def judged(name: str, value: float, half: float) -> Value:
    """The value with its interval, or why it is not given."""
    half = math.hypot(half, 1.645 * _DRIVEN.get(name, 0.0))
    if half > WIDEST:
        return refused(name, f'too uncertain: {value:.3f} +- {half:.3f} ({100 * LEVEL:.0f} %); '
                       f'slip, noise or too little motion: {MANOEUVRE.get(name, "drive longer")}')
    if not 0.5 < value < 2.0:
        return refused(name, f'{value:.3f} is no calibration but a wrong constant: ask '
                       f'`mecanum doctor`')
    return Value(name, value, value - half, value + half, 'observable')


def _from_gyro(windows: Windows, wheels: FloatArray) -> Value:
    good = np.isfinite(windows.gyro)
    missing = excited('turning', 2, wheels[good]) if good.any() else 'there is no gyro'
    if missing:
        return refused('turning', missing)
    design = np.column_stack([wheels[good][:, [2, 0, 1]], np.ones(int(good.sum()))])
    fit = robust_fit(design, windows.gyro[good], windows.cluster[good],
                     np.array([1.0, 0.0, 0.0, 0.0]), np.array([np.inf, _UNEQUAL, _UNEQUAL, 0.01]))
    if fit is None or fit.clusters[0] < _CLUSTERS:
        return refused('turning', f'the motion is too short: {MANOEUVRE["turning"]}')
    half = math.hypot(fit.half_width(0, LEVEL), 1.645 * _GYRO_SCALE)
    return judged('turning', float(fit.value[0]), half)


def _gyro_scale(windows: Windows) -> list[Value]:
    good = np.isfinite(windows.gyro)
    if not good.any():
        return []
    turned = windows.moved[good, 2]
    if np.abs(turned).sum() < _WAY['turning']:
        return [refused(GYRO_SCALE, f'only {np.abs(turned).sum():.1f} rad turned: '
                        f'{MANOEUVRE["turning"]}')]
    design = np.column_stack([windows.gyro[good], np.ones(len(turned))])  # the quieter of both
    fit = robust_fit(design, turned, windows.cluster[good], np.array([1.0, 0.0]),
                     np.array([np.inf, 0.01]))
    if fit is None or fit.clusters[0] < _CLUSTERS:
        return [refused(GYRO_SCALE, 'the motion is too short')]
    value = 1.0 / float(fit.value[0])
    return [judged(GYRO_SCALE, value, fit.half_width(0, LEVEL) * value**2)]


def wheel_values(windows: Windows, forward: FloatArray, found: Calibration,
                 fits: list[Fit | None]) -> list[Value]:
    """Radius of each wheel relative to the mean of all, fitted along with the scales of the axes
    and the frame of the reference.

    reference - s B dphi = s B diag(dphi) e + ds B dphi + frame,   sum e = 0
    """
    if not all(found.axes[name].given for name in ('forward', 'sideways', 'turning')):
        return []
    count = forward.shape[1]
    contrast = np.linalg.svd(np.ones((1, count)))[2][1:].T  # (W, W - 1), columns sum to 0
    wheels = windows.wheel @ forward.T
    x, y, w = wheels.T
    none = np.zeros(len(x))
    frame = np.array([[-y, none, -w], [x, w, none], [none, none, none]])  # angle, place x and y
    rows, rest = [], []
    for axis, fit in enumerate(fits):
        assert fit is not None
        scale = float(fit.value[0])
        own = np.zeros((len(x), 3))
        own[:, axis] = wheels[:, axis]
        design = np.column_stack([(windows.wheel * (scale * forward[axis])) @ contrast, own,
                                  frame[axis].T])
        rows.append(design / fit.scale)
        rest.append((windows.moved[:, axis] - scale * wheels[:, axis]) / fit.scale)
    spread = np.full(count + 5, np.inf)
    spread[-3:] = _FRAME[0], _FRAME[1], _FRAME[1]
    fit = robust_fit(np.concatenate(rows), np.concatenate(rest), np.tile(windows.cluster, 3),
                     np.zeros(count + 5), spread)
    if fit is None:
        return []
    along = np.hstack([contrast, np.zeros((count, 6))])
    return [judged(f'wheel {i}', 1.0 + float(row @ fit.value), fit.half_width_along(row, LEVEL))
            for i, row in enumerate(along)]


def held_out(windows: Windows, wheels: FloatArray, folds: int = 4) -> dict[str, float]:
    """Error of the windows before and after, each fold fitted on the time of the others."""
    groups = np.unique(windows.cluster)
    if len(groups) < 2 * folds:
        return {}
    before, after = [], []
    for part in np.array_split(groups, folds):
        test = np.isin(windows.cluster, part)
        fits = axis_fits(windows.where(~test), wheels[~test])
        for axis in range(3):
            real, plain = windows.moved[test, axis], wheels[test, axis]
            fit = fits[axis]
            usable = fit is not None and not excited(
                ('forward', 'sideways', 'turning')[axis], axis, wheels[~test])
            scale = float(fit.value[0]) if usable and fit is not None else 1.0
            arm = 1.0 if axis < 2 else 0.2  # rad to m at the edge of a small base
            before.append(arm * (real - plain).sum())
            after.append(arm * (real - scale * plain).sum())
    return {'before': float(np.sqrt(np.mean(np.square(before)))),
            'after': float(np.sqrt(np.mean(np.square(after)))), 'folds': float(folds)}
