"""Wiring faults of a robot from a recording: named with the corrected lines and how sure.

The doctor claims a fault only where one explanation carries at least 90 % of the probability, and
asks for another drive where the motion does not tell (R: the 81 combinations show which manoeuvre
separates which wheels).
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.agreement import yaw_agreement
from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.bag.analysis.wheel_gain import wheel_gain
from mecanum_base.bag.analysis.wiring_search import DEGREES, Wiring, search
from mecanum_base.bag.analysis.wiring_signals import (
    Signals,
    right_angles,
    rpy_of,
    signals_of,
)
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.robot import Robot

CERTAIN, LIKELY = 0.9, 0.6
_TILT = math.radians(2.0)
_OFFSET = 0.02
_LEAST = {'forward': 0.15, 'sideways': 0.15, 'turning': 0.15}  # m/s, m/s, rad/s x 0.3 rms
_POOR = 0.02  # m/s rms of motion of any kind


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One fault: what is wrong, the lines of the robot file that cure it, how sure (0..1)."""

    fault: str
    text: str
    lines: tuple[str, ...]
    certainty: float
    evidence: str = ''


@dataclass(slots=True)
class Verdict:
    """All diagnoses; ``missing``: manoeuvres without which nothing can be said of something;
    ``unclear``: explanations that the recording cannot tell apart."""

    diagnoses: list[Diagnosis] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    unclear: list[str] = field(default_factory=list)
    checked: list[str] = field(default_factory=list)

    def plain(self) -> dict[str, Any]:
        """As JSON values."""
        return asdict(self)


def examine(robot: Robot, motion: WheelMotion, gyro: Gyro | None, truth: Track | None = None,
            command: Track | None = None) -> Verdict:
    """Examine one recording; ``gyro`` in sensor axes, ``motion`` read as the robot file says.

    ``truth``: poses; ``command``: twists that were asked for, used where there is no gyro.
    """
    verdict = Verdict()
    assert isinstance(robot.base, Wheels)
    _file_plausible(robot.base, verdict)
    late = _time_offset(motion, gyro, verdict)
    if gyro is not None:
        command = None  # the wheels may be wired wrong on both sides: the gyro knows better
    signals = signals_of(motion, gyro, truth, command, late)
    if signals is None:
        verdict.missing.append('the recording is too short: drive for at least ten seconds')
        return verdict
    _accel_unit(signals, verdict)
    if gyro is None and signals.witness is None:
        verdict.missing.append('there is neither an IMU nor cmd_vel nor a true pose: only '
                               'contradictions among the wheels can be seen')
    if not _moves(robot.base, signals, verdict):
        return verdict
    if any(d.fault == 'millimetres' for d in verdict.diagnoses):
        verdict.missing.append('correct the millimetres first, then ask again')
        return verdict
    gain = wheel_gain(signals, robot.base)
    found = search(signals, robot.base, robot.imu.base_from_sensor())
    if gain is not None and gain.cost < found[0].cost - math.log(CERTAIN / (1 - CERTAIN)):
        _wheel_scale(robot, gain.wheel, gain.factor, gain.certainty, verdict)
        return verdict
    _wiring(robot, motion, signals, found, verdict)
    return verdict


def _file_plausible(wheels: Wheels, verdict: Verdict) -> None:
    """Millimetres where metres are meant show in the file itself."""
    for key, values, most in (('radius', wheels.radius, 1.0), ('x', wheels.x, 5.0),
                              ('y', wheels.y, 5.0)):
        if float(np.abs(values).max()) > most:
            verdict.diagnoses.append(Diagnosis(
                'millimetres', f'wheels.{key} is in millimetres',
                (f'{key}: {_list(values / 1000.0)}',), 0.99,
                f'largest value {float(np.abs(values).max()):g} m'))


def _accel_unit(signals: Signals, verdict: Verdict) -> None:
    """1 at rest instead of 9.81."""
    if signals.up_rested and 0.8 < signals.up_size < 1.2:
        verdict.diagnoses.append(Diagnosis(
            'accel_in_g', 'the accelerometer is in g',
            ('multiply linear_acceleration by 9.80665 in the driver (REP-145)',), 0.99,
            f'its reading at rest has the size {signals.up_size:.3f}'))


def _time_offset(motion: WheelMotion, gyro: Gyro | None, verdict: Verdict) -> float:
    """Offset of the gyro's stamps, found without any geometry on its liveliest axis."""
    if gyro is None:
        return 0.0
    spread = np.nanstd(gyro.rate, axis=0)
    axis = int(np.argmax(spread))
    column = gyro.rate[:, axis]
    scale = DEGREES if float(np.nanmax(np.abs(column))) > 35.0 else 1.0
    single = Gyro(gyro.stamp_ns, np.column_stack([column / scale] * 3), gyro.accel)
    found = yaw_agreement(motion, single)
    if found is None or found.fit < 0.8 or not math.isfinite(found.offset_sigma):
        return 0.0
    verdict.checked.append(f'time offset of the IMU: {found.offset * 1e3:+.0f} +- '
                           f'{found.offset_sigma * 1e3:.0f} ms')
    if abs(found.offset) < _OFFSET or abs(found.offset) < 4.0 * found.offset_sigma:
        return 0.0
    verdict.diagnoses.append(Diagnosis(
        'time_offset', f'the IMU is stamped {abs(found.offset) * 1e3:.0f} ms '
        f'{"late" if found.offset > 0 else "early"}',
        ('correct the stamps in the driver of the IMU (there is no line for it in the robot '
         'file)',), 0.97, f'{found.offset * 1e3:+.1f} +- {found.offset_sigma * 1e3:.1f} ms, '
        f'the wheels then explain {100 * found.fit:.1f} % of the gyro'))
    return found.offset


def _moves(wheels: Wheels, signals: Signals, verdict: Verdict) -> bool:
    """Whether the motion is rich enough; says what is missing."""
    lever = float(np.mean(wheels.radius * np.abs(np.sin(wheels.roller))))
    lever = lever / 1000.0 if lever > 1.0 else lever
    rates = signals.wheel * lever
    power = np.linalg.svd(rates / math.sqrt(len(rates)), compute_uv=False)
    if power[0] < _POOR:
        verdict.missing.append('not enough motion: drive 1 m forward, 1 m sideways, and turn once '
                               'around')
        return False
    if power[min(2, len(power) - 1)] < max(_POOR, 0.05 * float(power[0])):
        verdict.missing.append(
            'not enough kinds of motion: the wheels ran in '
            f'{int(np.sum(power > max(_POOR, 0.05 * float(power[0]))))} of the 3 ways that '
            'tell wheels apart; drive forward, sideways and turn, in one recording')
        return False
    return True


def _wiring(robot: Robot, motion: WheelMotion, signals: Signals, found: list[Wiring],
            verdict: Verdict) -> None:
    """Turn the probabilities of the search into diagnoses."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    sure: dict[tuple[object, ...], float] = {}
    for wiring in found:
        sure[wiring.key] = sure.get(wiring.key, 0.0) + wiring.probability
    best = max(found, key=lambda w: (sure[w.key], -w.cost))
    certainty = sure[best.key]
    verdict.checked.append(f'{wheels.count} wheels, rollers, mounting: best explanation carries '
                           f'{100 * certainty:.1f} %')
    if certainty < LIKELY:
        top = sorted(sure.items(), key=lambda item: -item[1])[:3]
        for key, value in top:
            example = next(w for w in found if w.key == key)
            verdict.unclear.append(f'{100 * value:.0f} %: {describe(robot, example)}')
        return
    for diagnosis in faults_of(robot, signals, best, min(certainty, 0.99)):
        verdict.diagnoses.append(diagnosis)
    if certainty < CERTAIN and not any(d.certainty >= CERTAIN for d in verdict.diagnoses):
        others = sorted(((v, k) for k, v in sure.items() if k != best.key), key=lambda i: -i[0])
        other = next(w for w in found if w.key == others[0][1])
        verdict.unclear.append(f'{100 * others[0][0]:.0f} %: {describe(robot, other)}')
    _tilt(robot, signals, best, verdict)


def faults_of(robot: Robot, signals: Signals, wiring: Wiring,
              certainty: float) -> list[Diagnosis]:
    """The faults of one wiring with their corrected lines."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    found = []
    names = wheels.joint
    if wiring.order != tuple(range(wheels.count)):
        moved = [i for i, j in enumerate(wiring.order) if i != j]
        found.append(Diagnosis(
            'swapped_wheels', 'wheels are swapped: ' + ', '.join(
                f'at the place of {names[i]} sits {names[wiring.order[i]]}' for i in moved),
            (f'joint: [{", ".join(names[j] for j in wiring.order)}]',), certainty,
            'found from gyro, wheels and accelerometer together'))
    sign = robot.encoder.for_wheels(wheels.count)[1]
    if -1 in wiring.sign:
        turned = [names[wiring.order[i]] for i, s in enumerate(wiring.sign) if s < 0]
        new = [int(sign[wiring.order[i]]) * s for i, s in enumerate(wiring.sign)]
        found.append(Diagnosis('reversed_encoder', f'reversed: {", ".join(turned)}',
                               (f'sign: {new}',), certainty,
                               'sign in the order of the (corrected) joint list'))
    if wiring.mirrored:
        found.append(Diagnosis(
            'mirrored_rollers', 'the rollers are mirrored (O against X, seen from above)',
            (f'roller: {_list(-wheels.roller)}',), certainty, 'sideways motion and lever fit '
            'only with the other roller angles'))
    if wiring.degrees:
        found.append(Diagnosis(
            'gyro_in_degrees', 'the gyro is in degrees per second',
            ('multiply angular_velocity by pi/180 in the driver (REP-145)',), certainty,
            'wheels and gyro differ by a factor near 57.3'))
    if wiring.mount:
        turn = right_angles()[wiring.mount] @ robot.imu.base_from_sensor()
        found.append(Diagnosis(
            'imu_mount', 'the IMU is mounted another way than imu.rpy says',
            (f'rpy: {_list(np.array(rpy_of(turn)))}',), certainty,
            'gravity, gyro and acceleration fit this mounting'))
    if wiring.scale != 1.0:
        found.append(_scale_fault(robot, signals, wiring, certainty))
    return found


def _scale_fault(robot: Robot, signals: Signals, wiring: Wiring, certainty: float) -> Diagnosis:
    """A yaw scale far from 1: lever arm, or counts and radius; translation tells which."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    k = wiring.scale
    counts = robot.encoder.for_wheels(wheels.count)[0]
    lever = (f'x: {_list(wheels.x / k)}', f'y: {_list(wheels.y / k)}')
    common = ((f'counts_per_revolution: {float(counts[0] / k):.6g}',)
              if robot.encoder.source == 'wheel_ticks'
              else (f'radius: {_list(wheels.radius * k)}',))
    move, sigma = _translation_scale(robot, signals, wiring)
    shown = f'real yaw = {k:.4g} x yaw of the wheels'
    if sigma < 0.15 * abs(1.0 - k) and sigma < 0.1 * max(k, 1.0):
        shown += f'; real distance = {move:.3f} +- {sigma:.3f} x that of the wheels'
        if abs(move - 1.0) < 3.0 * sigma + 0.05:
            return Diagnosis('lever_arm', 'the wheelbase or track of the file is wrong', lever,
                             certainty, shown)
        if abs(move / k - 1.0) < 3.0 * sigma / k + 0.05:
            return Diagnosis('counts_or_radius', 'counts per revolution or radius are wrong',
                             common, certainty, shown)
    if not 0.02 < k < 50.0:
        which = ('x and y look like millimetres', lever) if k > 50.0 else (
            'the radius looks like millimetres', (f'radius: {_list(wheels.radius * k)}',))
        return Diagnosis('millimetres', which[0], which[1], certainty, shown)
    return Diagnosis(
        'yaw_scale', 'either the lever arm (x, y) or counts and radius are wrong: measure a '
        'distance of 2 m to tell', (*lever, 'or', *common), min(certainty, 0.5), shown)


def _translation_scale(robot: Robot, signals: Signals, wiring: Wiring) -> tuple[float, float]:
    """(scale, sigma) of real over wheel translation, from the truth or the accelerometer."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    forward = body_from_wheels(wheels_from_body(wheels))
    order, sign = list(wiring.order), np.array(wiring.sign, dtype=float)
    pairs: list[tuple[FloatArray, FloatArray]] = []
    if signals.witness is not None:
        twist = (signals.wheel[:, order] * sign) @ forward.T
        good = np.isfinite(signals.witness).all(axis=1)
        pairs = [(twist[good, a], signals.witness[good, a]) for a in (0, 1)]
    elif signals.accel is not None and signals.gyro is not None:
        turn = right_angles()[wiring.mount] @ robot.imu.base_from_sensor()
        calm = np.abs(signals.gyro @ turn[2]) < 0.2 * (DEGREES if wiring.degrees else 1.0)
        unit = 9.80665 if 0.8 < signals.up_size < 1.2 else 1.0
        accel = signals.accel[calm] @ turn.T * unit
        pull = (signals.push[calm][:, order] * sign) @ forward.T
        pairs = [(pull[:, a], accel[:, a]) for a in (0, 1)]
    if not pairs or len(pairs[0][0]) < 40:
        return 1.0, math.inf
    x, y = np.concatenate([p[0] for p in pairs]), np.concatenate([p[1] for p in pairs])
    power = float(x @ x)
    if power < 1e-9:
        return 1.0, math.inf
    value = float(x @ y) / power
    rest = y - value * x
    return value, float(np.sqrt(np.sum((rest * x) ** 2) * 4.0) / power)  # windows overlap


def _wheel_scale(robot: Robot, wheel: int, factor: float, certainty: float,
                 verdict: Verdict) -> None:
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    counts, _ = robot.encoder.for_wheels(wheels.count)
    counts[wheel] /= factor
    radius = wheels.radius.copy()
    radius[wheel] *= factor
    line = (f'counts_per_revolution: {_list(counts)}' if robot.encoder.source == 'wheel_ticks'
            else f'radius: {_list(radius)}')
    verdict.diagnoses.append(Diagnosis(
        'wheel_scale', f'{wheels.joint[wheel]} really turns {factor:.3f} times as far as it says',
        (line,), certainty, 'its counts per revolution (or its radius) are wrong: only then do '
        'the wheels agree'))


def _tilt(robot: Robot, signals: Signals, wiring: Wiring, verdict: Verdict) -> None:
    """A small tilt of the IMU, from gravity at rest."""
    if signals.up is None or not signals.up_rested or signals.up_size < 0.5:
        return
    turn = right_angles()[wiring.mount] @ robot.imu.base_from_sensor()
    up = turn @ signals.up
    angle = math.acos(max(-1.0, min(1.0, float(up[2]))))
    if not _TILT < angle < math.radians(30.0):
        return
    axis = np.cross(up, [0.0, 0.0, 1.0])
    corrected = _about(axis / np.linalg.norm(axis), angle) @ turn
    verdict.diagnoses.append(Diagnosis(
        'imu_tilt', f'the IMU (or the floor) is tilted by {math.degrees(angle):.1f} deg',
        (f'rpy: {_list(np.array(rpy_of(corrected)))}',), 0.8,
        'direction of gravity at rest; turn the robot by half a turn and look again: a tilt of '
        'the floor then changes its sign'))


def _about(axis: FloatArray, angle: float) -> FloatArray:
    """Rotation (3, 3) about a unit axis (Rodrigues)."""
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]],
                      [-axis[1], axis[0], 0.0]])
    found: FloatArray = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return found


def describe(robot: Robot, wiring: Wiring) -> str:
    """One line for a wiring."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    parts = []
    if wiring.order != tuple(range(wheels.count)):
        parts.append(f'joint: [{", ".join(wheels.joint[j] for j in wiring.order)}]')
    if -1 in wiring.sign:
        parts.append(f'sign: {list(wiring.sign)}')
    if wiring.mirrored:
        parts.append('mirrored rollers')
    if wiring.degrees:
        parts.append('gyro in degrees')
    if wiring.mount:
        turn = right_angles()[wiring.mount] @ robot.imu.base_from_sensor()
        parts.append(f'imu.rpy {_list(np.array(rpy_of(turn)))}')
    if wiring.scale != 1.0:
        parts.append(f'yaw scale {wiring.scale:.3g}')
    return '; '.join(parts) or 'the robot file is right'


def _list(values: Any) -> str:
    return '[' + ', '.join(_decimal(float(v)) for v in values) + ']'


def _decimal(value: float) -> str:
    text = f'{value + 0.0:.6g}'
    return text if set(text) & set('.e') else text + '.0'
