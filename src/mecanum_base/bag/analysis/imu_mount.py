"""Mounting of the IMU: the small turn between the axes of the robot file and those of the base.

    base_from_sensor = Rz(psi) T base_from_sensor(file)      T levels: T (q_x, q_y, 1) ~ z
    felt = c told + d J told + Rz(-psi) (e diag(1, -1) + k S) told + b + Rz(-heading) f
    psi = psi_0 + atan2(d, c)

J turns by -90 deg, S swaps x and y; e (another lateral than forward scale), k (unequal
radii: diagonals that differ shear the way), b (zero-g) and f (slope of the floor), both a bag, are
fitted along. Pushes along one axis only cannot tell k from psi. ``told`` comes from the wheels,
which define what is forward, or from a true pose turned by the angle of its markers. Slip is met
by the robust fit. Given only where excited.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from mecanum_base.bag.analysis.fitted_value import LEVEL, Value, refused
from mecanum_base.bag.analysis.imu_levels import Level
from mecanum_base.bag.analysis.imu_pushes import Pushes
from mecanum_base.bag.analysis.robust_fit import Fit, robust_fit
from mecanum_base.core.parameter import FloatArray

NAMES = {'x': 'about x (roll)', 'y': 'about y (pitch)', 'z': 'about z (yaw)'}
BRISKLY = 'start and stop briskly ten times, forward and back and sideways (30 s or more, 1 m/s2)'
_OTHER = 'no calibration but another mounting, ask `mecanum doctor`'
_WIDEST = {'x': math.radians(3.0), 'y': math.radians(3.0), 'z': math.radians(2.0)}
_LARGEST = math.radians(20.0)  # more is another mounting, which the doctor names
_SCALE = (0.7, 1.4)  # accelerometer over wheels
_UNEQUAL = 0.1  # standard deviation of the lateral against the forward scale
_SLOPE = 0.1  # m/s2 of gravity along the floor, standard deviation (0.6 deg)
_SHARE = 0.05  # of an acceleration that the wheels may tell wrongly: creep, load
_LEAST_PUSH = 0.05  # m/s2 rms
_TURNED = 0.001  # rad: rollers that are 2 mrad off turn the way of the wheels as much
SHEAR = 0.005  # standard deviation of k: radii that differ by 1 %
_CLUSTERS = 4
_ROUNDS = 3


@dataclass(frozen=True, slots=True)
class MountFit:
    """Turns 'x', 'y', 'z' [rad] to add to the mount of the file, in axes of the base."""

    turns: dict[str, Value] = field(default_factory=dict)

    @property
    def given(self) -> bool:
        """Whether any of them is given."""
        return any(value.given for value in self.turns.values())

    def applied(self, base_from_sensor: FloatArray) -> FloatArray:
        """The new rotation (3, 3) for the one of the file."""
        x, y, z = (self._angle(axis) for axis in 'xyz')
        c, s = math.cos(z), math.sin(z)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        found: FloatArray = turn @ levelling(x, y) @ base_from_sensor
        return found

    def _angle(self, axis: str) -> float:
        value = self.turns.get(axis)
        return 0.0 if value is None or value.value is None else value.value


def levelling(x: float, y: float) -> FloatArray:
    """Rotation (3, 3) by the vector (x, y, 0) rad (Rodrigues)."""
    angle = math.hypot(x, y)
    cross = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])
    near = angle < 1e-9
    first = 1.0 if near else math.sin(angle) / angle
    second = 0.5 if near else (1.0 - math.cos(angle)) / angle**2
    found: FloatArray = np.eye(3) + first * cross + second * cross @ cross
    return found


def level_turns(level: Level | None, missing: str) -> dict[str, Value]:
    """Turns about x and y that put q upright: (q_y, -q_x)."""
    if level is None:
        return {axis: refused(NAMES[axis], missing) for axis in 'xy'}
    size = float(np.linalg.norm(level.up))
    if size > math.sin(_LARGEST):
        lean = f'{math.degrees(math.asin(min(size, 1.0))):.0f} deg'
        return {axis: refused(NAMES[axis], f'it leans by {lean}: {_OTHER}') for axis in 'xy'}
    scale = math.asin(size) / size if size > 1e-9 else 1.0
    pairs = {'x': (scale * float(level.up[1]), float(level.sigma[1])),
             'y': (-scale * float(level.up[0]), float(level.sigma[0]))}
    return {axis: _judged(axis, value, 1.645 * sigma, level.source)
            for axis, (value, sigma) in pairs.items()}


def yaw_turn(parts: list[Pushes], source: str, shear: float, sigma: float = 0.0) -> Value:
    """The turn about z from all recordings together; standard deviations: ``shear`` of what is
    told, ``sigma`` rad of its heading."""
    name = NAMES['z']
    if not parts:
        return refused(name, 'no accelerometer, or less than 2 s of it together with the wheels')
    told = np.concatenate([p.told for p in parts])
    felt = np.concatenate([p.felt for p in parts])
    bag = np.concatenate([np.full(len(p), i) for i, p in enumerate(parts)])
    heading = np.concatenate([p.heading for p in parts])
    cluster, offset = [], 0
    for part in parts:
        cluster.append(part.cluster + offset)
        offset += int(part.cluster.max()) + 1
    size = float(np.sqrt(np.mean(np.sum(told**2, axis=1))))
    if size < _LEAST_PUSH:
        return refused(name, f'{source}: accelerations of {size:.2f} m/s2 rms only: {BRISKLY}')
    psi, fit = 0.0, None
    for _ in range(_ROUNDS):
        fit = _fitted(told, felt, np.concatenate(cluster), bag, heading, psi,
                      shear)
        if fit is None or fit.clusters[0] < _CLUSTERS:
            return refused(name, f'the accelerations are too few or all in one go: {BRISKLY}')
        psi += math.atan2(float(fit.value[1]), float(fit.value[0]))
    assert fit is not None
    scale = math.hypot(float(fit.value[0]), float(fit.value[1]))
    if not _SCALE[0] < scale < _SCALE[1]:
        return refused(name, f'the accelerometer shows {scale:.2f} of the acceleration of the '
                       f'{source} (slip, a wrong unit, vibration or too little of it): {BRISKLY}')
    half = fit.half_width(1, LEVEL) / scale
    half = math.hypot(half, 1.645 * math.hypot(sigma, _TURNED))
    return _judged('z', math.remainder(psi, math.tau), half, f'accelerometer against {source}')


def _fitted(told: FloatArray, felt: FloatArray, cluster: FloatArray, bag: FloatArray,
            heading: FloatArray, psi: float, shear: float) -> Fit | None:
    """c, d, e, k, offsets and slopes for ``told`` turned by -psi."""
    c, s = math.cos(psi), math.sin(psi)
    back = np.array([[c, s], [-s, c]])  # Rz(-psi)
    seen = told @ back.T
    odd = np.column_stack([(told * [1.0, -1.0]) @ back.T, told[:, ::-1] @ back.T])
    if shear == 0.0:
        odd = odd[:, :2]
    first = 2 + odd.shape[1] // 2  # of the offsets
    bags = int(bag.max()) + 1
    here = (bag[:, None] == np.arange(bags)).astype(float)
    none = np.zeros_like(here)
    along, across = here * np.cos(heading)[:, None], here * np.sin(heading)[:, None]
    design = np.concatenate([
        np.column_stack([seen[:, 0], seen[:, 1], odd[:, ::2], here, none, along, across]),
        np.column_stack([seen[:, 1], -seen[:, 0], odd[:, 1::2], none, here, -across, along])])
    prior = np.zeros(design.shape[1])
    prior[0] = 1.0
    spread = np.full(design.shape[1], np.inf)
    spread[2:first] = (_UNEQUAL, shear)[:first - 2]
    spread[first + 2 * bags:] = _SLOPE
    weight = np.tile(1.0 / _noise(told, felt, here), 2)
    return robust_fit(design * weight[:, None], felt.T.reshape(-1) * weight,
                      np.concatenate([cluster, cluster]), prior, spread)


def _noise(told: FloatArray, felt: FloatArray, here: FloatArray) -> FloatArray:
    """Size (K,) of the errors to expect: that of calm windows, and a share of the push."""
    size = np.linalg.norm(told, axis=1)
    calm = size <= np.percentile(size, 40)
    rest = np.concatenate([felt[chosen] - np.median(felt[chosen], axis=0)
                           for chosen in (calm & (column > 0.0) for column in here.T)])
    quiet = 1.4826 * float(np.median(np.abs(rest))) if len(rest) else 0.0
    found: FloatArray = np.hypot(max(quiet, 0.01), _SHARE * size)
    return found


def _judged(axis: str, value: float, half: float, source: str) -> Value:
    name = NAMES[axis]
    shown = f'{math.degrees(value):+.1f} +- {math.degrees(half):.1f} deg'
    if abs(value) > _LARGEST:
        return refused(name, f'{shown}: {_OTHER}')
    if half > _WIDEST[axis]:
        todo = BRISKLY if axis == 'z' else ('turn two times around in each direction on the spot '
                                            'and stand still for 3 s at different headings')
        return refused(name, f'too uncertain: {shown}; {todo}')
    return Value(name, value, value - half, value + half, f'observable: {source}')
