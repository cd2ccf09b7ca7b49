"""What a wiring fault means for the robot file: names, corrected lines, and how sure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.bag.analysis.wheel_lines import listed, order_lines, reversed_places, signs
from mecanum_base.bag.analysis.wiring_commands import caution
from mecanum_base.bag.analysis.wiring_search import DEGREES, Wiring, forward_of
from mecanum_base.bag.analysis.wiring_signals import Signals, right_angles, rpy_of
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.robot import Robot

_TILT = math.radians(2.0)


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One fault: what is wrong, the lines of the robot file that cure it, how sure (0..1)."""

    fault: str
    text: str
    lines: tuple[str, ...]
    certainty: float
    evidence: str = ''


def faults_of(robot: Robot, signals: Signals, wiring: Wiring,
              certainty: float) -> list[Diagnosis]:
    """The faults of one wiring with their corrected lines."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    found = []
    names = wheels.joint
    told = (f'found from {_sources(signals)} together; '
            f'{caution(signals, wheels, forward_of(wheels, wiring))}')
    turned = reversed_places(robot, wiring.order, wiring.sign)
    if wiring.order != tuple(range(wheels.count)):
        moved = [i for i, j in enumerate(wiring.order) if i != j]
        lines = order_lines(robot, wiring.order, wiring.sign)
        found.append(Diagnosis(
            'swapped_wheels', 'wheels are swapped: ' + ', '.join(
                f'at the place of {names[i]} sits {names[wiring.order[i]]}' for i in moved),
            lines[:-1] if turned and lines[-1].startswith('sign') else lines, certainty, told))
    if turned:
        found.append(Diagnosis(
            'reversed_encoder',
            f'reversed: {", ".join(names[wiring.order[i]] for i in turned)}',
            (f'sign: {signs(robot, wiring.order, wiring.sign).tolist()}',), certainty,
            'sign in the order of the (corrected) joint list; ' + told))
    if wiring.mirrored:
        found.append(Diagnosis(
            'mirrored_rollers', 'the rollers are mirrored (O against X, seen from above)',
            (f'roller: {listed(-wheels.roller)}',), certainty, 'sideways motion and lever fit '
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
            (f'rpy: {listed(np.array(rpy_of(turn)))}',), certainty,
            'gravity, gyro and acceleration fit this mounting'))
    if wiring.scale != 1.0:
        found.append(_scale_fault(robot, signals, wiring, certainty))
    return found


def _sources(signals: Signals) -> str:
    """What was looked at, in words."""
    return ', '.join(name for name, column in (
        ('gyro', signals.gyro), ('accelerometer', signals.accel), ('commands', signals.asked),
        ('true pose or commands', signals.witness)) if column is not None) + ' and wheels'


def _scale_fault(robot: Robot, signals: Signals, wiring: Wiring, certainty: float) -> Diagnosis:
    """A yaw scale far from 1: lever arm, or counts and radius; translation tells which."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    k = wiring.scale
    counts = robot.encoder.for_wheels(wheels.count)[0]
    lever = (f'x: {listed(wheels.x / k)}', f'y: {listed(wheels.y / k)}')
    common = ((f'counts_per_revolution: {float(counts[0] / k):.6g}',)
              if robot.encoder.source == 'wheel_ticks'
              else (f'radius: {listed(wheels.radius * k)}',))
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
    if 1.0 / 3.0 < 1000.0 * min(k, 1.0 / k) < 3.0:
        which = ('x and y look like millimetres', lever) if k > 50.0 else (
            'the radius looks like millimetres', (f'radius: {listed(wheels.radius * k)}',))
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


def wheel_scale(robot: Robot, wheel: int, factor: float, certainty: float) -> Diagnosis:
    """One wheel whose counts per revolution or radius are wrong by ``factor``."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    counts, _ = robot.encoder.for_wheels(wheels.count)
    counts[wheel] /= factor
    radius = wheels.radius.copy()
    radius[wheel] *= factor
    line = (f'counts_per_revolution: {listed(counts)}' if robot.encoder.source == 'wheel_ticks'
            else f'radius: {listed(radius)}')
    return Diagnosis(
        'wheel_scale', f'{wheels.joint[wheel]} really turns {factor:.3f} times as far as it says',
        (line,), certainty, 'its counts per revolution (or its radius) are wrong: only then do '
        'the wheels agree')


def tilt_of(robot: Robot, signals: Signals, wiring: Wiring) -> list[Diagnosis]:
    """A small tilt of the IMU, from gravity at rest."""
    if signals.up is None or not signals.up_rested or signals.up_size < 0.5:
        return []
    turn = right_angles()[wiring.mount] @ robot.imu.base_from_sensor()
    up = turn @ signals.up
    angle = math.acos(max(-1.0, min(1.0, float(up[2]))))
    if not _TILT < angle < math.radians(30.0):
        return []
    axis = np.cross(up, [0.0, 0.0, 1.0])
    corrected = _about(axis / np.linalg.norm(axis), angle) @ turn
    return [Diagnosis(
        'imu_tilt', f'the IMU (or the floor) is tilted by {math.degrees(angle):.1f} deg',
        (f'rpy: {listed(np.array(rpy_of(corrected)))}',), 0.8,
        'direction of gravity at rest; turn the robot by half a turn and look again: a tilt of '
        'the floor then changes its sign')]


def _about(axis: FloatArray, angle: float) -> FloatArray:
    """Rotation (3, 3) about a unit axis (Rodrigues)."""
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]],
                      [-axis[1], axis[0], 0.0]])
    found: FloatArray = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return found


def describe(robot: Robot, wiring: Wiring) -> str:
    """One line for a wiring: the lines of the robot file that would cure it."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    parts: list[str] = []
    if wiring.order != tuple(range(wheels.count)):
        parts += order_lines(robot, wiring.order, wiring.sign)
    elif reversed_places(robot, wiring.order, wiring.sign):
        parts.append(f'sign: {signs(robot, wiring.order, wiring.sign).tolist()}')
    if wiring.mirrored:
        parts.append(f'roller: {listed(-wheels.roller)}')
    if wiring.degrees:
        parts.append('gyro in degrees')
    if wiring.mount:
        turn = right_angles()[wiring.mount] @ robot.imu.base_from_sensor()
        parts.append(f'rpy: {listed(np.array(rpy_of(turn)))}')
    if wiring.scale != 1.0:
        parts.append(f'yaw scale {wiring.scale:.3g}')
    return '; '.join(parts) or 'the robot file is right'


def look_at(robot: Robot, one: Wiring, other: Wiring) -> str:
    """The look at the robot that decides between two wirings, ``one`` the one named first."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    moved = [i for i, j in enumerate(one.order) if j != other.order[i]]
    if not moved:
        return 'Look how the IMU sits: where no rpy is named, as the robot file says'
    place = moved[0]
    spot = ' and '.join(f'{abs(value):.3g} m {words[int(value < 0.0)]}' for value, words in (
        (wheels.x[place], ('ahead', 'behind')),
        (wheels.y[place], ('to the left', 'to the right'))) if value)
    columns = [f'column {w.order[place] + 1} of the counts'
               if robot.encoder.source == 'wheel_ticks' else wheels.joint[w.order[place]]
               for w in (one, other)]
    return (f'Turn by hand the wheel that sits {spot} of the middle, seen with the front that '
            f'you go by: if {columns[0]} moves, what is named first is right, if {columns[1]} '
            'does, what comes next')
