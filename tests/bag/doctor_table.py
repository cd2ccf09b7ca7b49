"""Every fault the doctor knows, injected into drives with many seeds: found, missed, wrong.

    python tests/bag/doctor_table.py [SEEDS] [--only WORDS]

Found: named with the right line and at least 90 %. Likely: the right line comes first, with less,
beside the other explanation. Beside: nothing has 90 %, and the right lines are named among the
explanations that the recording cannot tell apart. Wrong: another fault with at least 90 %. What
stands for many faults is tried with a quarter of the seeds where ALL does not say all of them.
"""

from __future__ import annotations

import argparse
import copy
import dataclasses
import functools
import itertools
import pathlib
import re
import sys

import numpy as np
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import driving

from mecanum_base.bag.analysis.doctor import CERTAIN, examine
from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.robot import Robot
from mecanum_base.robot_file import parse_parameters

ROBOT = Robot.from_mapping(parse_parameters(driving.YAML, 'made by hand'))
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # sensor x is base y
DOWN = np.diag([1.0, -1.0, -1.0])  # half a turn about x
SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # sensor y is base z


def _columns(order, sign=(1, 1, 1, 1)):
    def change(made):
        made.angle = made.angle[:, list(order)] * sign
        return made
    return change


def _factor(name, value):
    def change(made):
        setattr(made, name, getattr(made, name) * value)
        return made
    return change


def _turned(rotation):
    return lambda made: driving.mount(made, rotation)


def _file(**change):
    return ROBOT.replace(base=dataclasses.replace(ROBOT.base, **change))


def _tilt(degrees):
    angle = np.radians(degrees)
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def same(made):
    return made


# name: (expected fault or None, options of drive, change of the drive, robot file, check of lines)
FAULTS = {
    'none': (None, {}, same, ROBOT, ''),
    'swap front left / front right': ('swapped_wheels', {}, _columns((1, 0, 2, 3)), ROBOT,
                                      r'joint: \[front_right'),
    'swap front left / rear right': ('swapped_wheels', {}, _columns((3, 1, 2, 0)), ROBOT,
                                     r'joint: \[rear_right'),
    'swap front / rear': ('swapped_wheels', {}, _columns((2, 3, 0, 1)), ROBOT,
                          r'joint: \[rear_left'),
    'rotate three wheels': ('swapped_wheels', {}, _columns((1, 2, 0, 3)), ROBOT,
                            r'joint: \[rear_left'),
    'reverse one': ('reversed_encoder', {}, _columns((0, 1, 2, 3), (1, 1, -1, 1)), ROBOT,
                    r'sign: \[1, 1, -1, 1\]'),
    'reverse right side': ('reversed_encoder', {}, _columns((0, 1, 2, 3), (1, -1, 1, -1)), ROBOT,
                           r'sign: \[1, -1, 1, -1\]'),
    'reverse all': ('reversed_encoder', {}, _columns((0, 1, 2, 3), (-1, -1, -1, -1)), ROBOT,
                    r'sign: \[-1, -1, -1, -1\]'),
    'mirrored rollers': ('mirrored_rollers', {}, same, _file(roller=-ROBOT.base.roller),
                         r'roller: \[0.785398, -0.785398'),
    'one wheel counts x 1.2': ('wheel_scale', dict(radius=(.05, .05, .06, .05)), same,
                               ROBOT, r'radius: \[0.05, 0.05, 0.0(59|60)'),
    'counts of all x 4': ('counts_or_radius', {}, _factor('angle', 4.0), ROBOT,
                          r'radius: \[0.012'),
    'counts of all / 4': ('counts_or_radius', {}, _factor('angle', 0.25), ROBOT,
                          r'radius: \[0.(19|20)'),
    'wheelbase wrong': ('lever_arm', {}, same, _file(x=ROBOT.base.x * 2.0, y=ROBOT.base.y * 2.0),
                        r'x: \[0.(199|2)'),
    'geometry in mm': ('millimetres', {}, same, _file(x=ROBOT.base.x * 1e3, y=ROBOT.base.y * 1e3),
                       r'x: \[0.(199|2)'),
    'radius in mm': ('millimetres', {}, same, _file(radius=ROBOT.base.radius * 1e3),
                     r'radius: \[0.05'),
    'gyro in degrees': ('gyro_in_degrees', {}, _factor('gyro', 180.0 / np.pi), ROBOT,
                        'multiply angular_velocity by pi/180'),
    'accelerometer in g': ('accel_in_g', {}, _factor('accel', 1.0 / 9.80665), ROBOT,
                           'multiply linear_acceleration by 9.80665'),
    'imu quarter turn': ('imu_mount', {}, _turned(QUARTER), ROBOT,
                         r'rpy: \[0.0, 0.0, 1.5708\]'),
    'imu upside down': ('imu_mount', {}, _turned(DOWN), ROBOT,
                        r'rpy: \[-?3.14159, -?0.0, -?0.0\]'),
    'imu on its side': ('imu_mount', {}, _turned(SIDE), ROBOT,
                        r'rpy: \[1.5708, -?0.0, -?0.0\]'),
    'imu tilted 6 deg': ('imu_tilt', {}, _turned(_tilt(6.0)), ROBOT,
                         r'rpy: \[-?0.0\d+, 0.(09|10|11)'),
    'imu late 60 ms': ('time_offset', dict(imu_late=0.06), same, ROBOT, r'late: 0.0(6|59)'),
    'imu early 40 ms': ('time_offset', dict(imu_late=-0.04), same, ROBOT, r'late: -0.0(4|39)'),
    'only forward': (None, dict(sideways=0.0, turning=0.0), same, ROBOT, ''),
    'only forward, wheels swapped': (None, dict(sideways=0.0, turning=0.0),
                                     _columns((1, 0, 2, 3)), ROBOT, ''),
    'only turning, one reversed': (None, dict(forward=0.0, sideways=0.0),
                                   _columns((0, 1, 2, 3), (1, 1, -1, 1)), ROBOT, ''),
    'standing still': (None, dict(forward=0.0, sideways=0.0, turning=0.0), same, ROBOT, ''),
}


def _order(order, robot=ROBOT, sign=(1, 1, 1, 1)):
    """The fault that column i of joint_states shows wheel order[i]; ``sign`` is that of the place
    the wheel really has."""
    names = ', '.join(driving.JOINTS[i] for i in np.argsort(order))
    kept = [sign[i] * sign[j] for i, j in enumerate(order)]
    return ('swapped_wheels', {}, _columns(order, kept), robot, re.escape(f'joint: [{names}]'))


def _mount(turn):
    """The fault of a mounting that the robot file does not know."""
    def fits(text):
        found = re.match(r'rpy: \[(.*)\]', text)
        told = [float(v) for v in found[1].split(',')] if found else [0.0, 0.0, 0.0]
        return np.abs(Rotation.from_euler('xyz', told).as_matrix() - turn).max() < 1e-4
    return ('imu_mount', {}, _turned(turn), ROBOT, fits)


# every order of four wheels and every right-angle mounting but the right one
OTHERS = [order for order in itertools.permutations(range(4)) if order != (0, 1, 2, 3)]
ORDERS = [_order(order) for order in OTHERS]
RIGHT_BACKWARDS = (1, -1, 1, -1)
MIXED = [_order(order, ROBOT.replace(encoder=dataclasses.replace(
    ROBOT.encoder, sign=RIGHT_BACKWARDS)), RIGHT_BACKWARDS) for order in OTHERS]
MOUNTS = [_mount(turn) for turn in Rotation.create_group('O').as_matrix()
          if np.abs(turn - np.eye(3)).max() > 0.1]
HALF = np.diag([-1.0, -1.0, 1.0])
TWO = [(wheels, imu) for wheels in (
    ORDERS[0], ORDERS[7], ORDERS[-1], *(FAULTS[name] for name in (
        'reverse one', 'reverse right side', 'reverse all', 'mirrored rollers'))) for imu in (
    _mount(HALF), *(FAULTS[name] for name in (
        'imu quarter turn', 'imu upside down', 'imu on its side', 'gyro in degrees',
        'accelerometer in g')))]
# three things say which end is the front; one of them wrong is the same machine as the others
FRONT = [FAULTS['reverse all'], ORDERS[-1], _mount(HALF)]
BEHIND = list(itertools.combinations(FRONT, 2))
GENTLY = dict(forward=0.12, sideways=0.12, turning=0.8, accel_noise=0.5)
# name: (faults, what the doctor gets to see)
EVERY = {
    'each of the 23 other orders: gyro, accelerometer': (ORDERS, {}),
    'the same with vibration and gentle starts': (ORDERS, GENTLY),
    'the same in a file with mixed signs': (MIXED, {}),
    'the same with commands, encoders wired otherwise': (ORDERS, dict(commands='right')),
    'the same with commands, motors wired along': (ORDERS, dict(commands='along')),
    'the same with gyro alone': (ORDERS, dict(accelerometer=False)),
    'the same with gyro and commands, encoders': (ORDERS, dict(accelerometer=False,
                                                               commands='right')),
    'the same with commands alone, encoders': (ORDERS, dict(imu=False, commands='right')),
    'the same with a true pose, no IMU': (ORDERS, dict(imu=False)),
    'each of the 23 other right-angle mountings': (MOUNTS, {}),
    'signs, order or IMU the wrong way round': (FRONT, {}),
    'two of these three': (BEHIND, {}),
    'these six with a true pose beside the IMU': (FRONT + BEHIND, dict(pose=True)),
    'these six with commands, encoders wired otherwise': (FRONT + BEHIND, dict(commands='right')),
    'two mistakes at once: wheels and IMU, 42 pairs': (TWO, {})}
ALL = {name for name in EVERY if 'six' in name or 'three' in name or name.startswith(
    ('each of the 23 other orders', 'signs, order'))}


KINDS = ('found', 'likely', 'beside', 'missed', 'wrong')


def judged(name, seed, **more):
    """One of KINDS for one fault and seed, and the verdict."""
    return judged_fault(FAULTS[name], seed, **more)


def judged_fault(fault, seed, imu=True, accelerometer=True, commands='', pose=False, **more):
    """The same for a line like those of FAULTS, or for two of them at once; ``commands``: none,
    those that the base 'right'ly follows, or what is wired 'along' with the encoders; with
    ``pose``, and without ``imu`` or commands, there is a true pose."""
    faults = fault if isinstance(fault[0], tuple) else (fault,)
    robot = faults[0][3]
    made = _driven(seed=seed, **{'seconds': 50.0, **faults[0][1], **more})
    for one in faults:
        made = one[2](made)
    motion = WheelMotion(driving.JOINTS, made.wheel_ns, made.angle)
    if not accelerometer:
        made.accel[:] = np.nan
    gyro = Gyro(made.imu_ns, made.gyro, made.accel) if imu else None
    truth = Track(made.truth_ns, made.pose) if pose or not (imu or commands) else None
    command = None
    if commands == 'right':
        command = Track(made.truth_ns, made.command[::4])
    elif commands:  # the wheels do by name what was asked of the names
        angle = made.angle[::2]
        asked = np.gradient(angle @ body_from_wheels(wheels_from_body(robot.base)).T, 0.02, axis=0)
        command = Track(made.wheel_ns[::2], asked)
    verdict = examine(robot, motion, gyro, truth, command)
    sure = [d for d in verdict.diagnoses if d.certainty >= CERTAIN or d.fault == 'imu_tilt']
    expected = {name: line for name, *_, line in faults if name}
    cured = {name: [d for d in verdict.diagnoses if d.fault == name and _cures(line, d)]
             for name, line in expected.items()}
    certain = {name for name, found in cured.items() if any(d in sure for d in found)}
    if {d.fault for d in sure} - certain:
        return 'wrong', verdict
    if certain == set(expected):
        return 'found', verdict
    if all(cured.values()):
        return 'likely', verdict
    same = 'this would look the same: '
    beside = [text.split(' %: ')[1].split('; ') for text in verdict.unclear]
    beside += [text[len(same):].split('; ') for text in verdict.missing if text.startswith(same)]
    named = any(all(_among(line, lines) for line in expected.values()) for lines in beside)
    return ('beside' if named else 'missed'), verdict


def _driven(**options):
    """A drive to be changed; the same one is not worked out twice."""
    return copy.deepcopy(_drive(**options))


@functools.lru_cache(maxsize=32)
def _drive(**options):
    return driving.drive(**options)


def _cures(line, diagnosis):
    """Whether one of its lines is that one."""
    return _among(line, diagnosis.lines)


def _among(line, lines):
    fits = line if callable(line) else functools.partial(re.match, line)
    return any(map(fits, lines))


def main(seeds, only):
    print('| fault | ' + ' | '.join(KINDS) + ' |\n|' + ' --- |' * (1 + len(KINDS)))
    rows = {name: [(fault, {}, seed) for seed in range(1, seeds + 1)]
            for name, fault in FAULTS.items()}
    for name, (faults, more) in EVERY.items():
        part = seeds if name in ALL else max(seeds // 4, 1)
        rows[name] = [(fault, more, seed) for seed in range(1, part + 1) for fault in faults]
    total = dict.fromkeys(KINDS, 0)
    for name, tried in rows.items():
        if only not in name:
            continue
        counts, notes = dict.fromkeys(KINDS, 0), []
        for fault, more, seed in tried:
            result, verdict = judged_fault(fault, seed, **more)
            counts[result] += 1
            if result == 'wrong':
                notes.append(f'   seed {seed}: {[(d.fault, d.lines) for d in verdict.diagnoses]}')
        print(f'| {name} | ' + ' | '.join(str(n) for n in counts.values()) + ' |', flush=True)
        for note in notes:
            print(note, file=sys.stderr)
        total = {k: total[k] + counts[k] for k in total}
    print('| all | ' + ' | '.join(str(n) for n in total.values()) + ' |')
    return 1 if total['wrong'] else 0


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('seeds', type=int, nargs='?', default=20, help='seeds a fault')
    parser.add_argument('--only', default='', help='rows whose name contains this')
    chosen = parser.parse_args()
    sys.exit(main(chosen.seeds, chosen.only))
