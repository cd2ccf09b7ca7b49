"""How often the 90 % intervals of the calibration cover the truth, and what is refused.

    python tests/bag/calibration_coverage.py [RUNS] [FIRST_SEED ...]

Several first seeds are so many sets of runs, and all of them together.
"""

from __future__ import annotations

import argparse
import pathlib
import sys

import numpy as np
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import driving

from mecanum_base.bag.analysis.calibrate_bags import fitted
from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.evidence import Evidence
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.bag.analysis.time_offset import time_offset
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.robot import Robot
from mecanum_base.robot_file import parse_parameters

ROBOT = Robot.from_mapping(parse_parameters(driving.YAML, 'made by hand'))
MATRIX = wheels_from_body(ROBOT.base)


def one(seed, **options):
    """(calibration, true values by name) of one random base; options of :func:`drawn`."""
    evidence, real = drawn(seed, **options)
    offsets = []
    found = fitted([evidence], [time_offset(evidence, offsets)], MATRIX)
    found.constants += offsets
    return found, real


def drawn(seed, truth=True, imu=True, accelerometer=True, mounted=(2.0, 2.0, 5.0), **options):
    """(evidence, true values by name) of one random base.

    Roll and pitch of the mount come from gravity and turning, so the accelerometer has an offset
    (0.5 m/s2), the floor a slope (0.3 deg) and the gyro cross-axis errors (1.2 %); the rollers
    turn the way of the wheels (1 mrad). All at random; ``mounted`` deg: spread of the mounting.
    """
    generator = np.random.default_rng(1000 + seed)
    rho, kappa = generator.uniform(0.95, 1.05), generator.uniform(0.93, 1.0)
    lam, gyro = generator.uniform(0.93, 1.07), generator.uniform(0.99, 1.01)
    # without truth the gyro is the reference; its scale error then has the stated spread
    if not truth:
        gyro = 1.0 + 0.005 * generator.normal()
    spread = 0.01 * generator.normal(size=4)
    spread -= spread.mean()
    x, y, z = np.radians(mounted) * generator.normal(size=3)
    setting = dict(seconds=80.0, radius=driving.RADIUS * rho * (1.0 + spread),
                   lever=(driving.LX + driving.LY) * lam, lateral=kappa, gyro_scale=gyro,
                   truth_noise=0.002, zero_g=0.5 * generator.normal(size=3),
                   floor=np.radians(0.3) * generator.normal(size=2),
                   imu_late=generator.uniform(-0.03, 0.08))
    setting['rollers'] = 0.001 * np.random.default_rng(2000 + seed).normal()
    late = {**setting, **options}['imu_late']
    made = driving.drive(seed=seed, **{**setting, **options})
    turn = Rotation.from_euler('z', z) * Rotation.from_rotvec([x, y, 0.0])
    cross = 0.012 * generator.normal(size=(3, 3))
    np.fill_diagonal(cross, 0.0)
    driving.mount(made, turn.as_matrix(), cross)
    if not accelerometer:
        made.accel[:] = np.nan
    motion = WheelMotion(driving.JOINTS, made.wheel_ns, made.angle)
    evidence = Evidence(ROBOT, motion, Gyro(made.imu_ns, made.gyro, made.accel) if imu else None,
                        Track(made.truth_ns, made.pose) if truth else None, None)
    return evidence, {
        'gyro reads': (np.eye(3) + cross) @ turn.as_matrix().T @ [0.0, 0.0, gyro],
        'forward': rho, 'sideways': rho * kappa, 'turning': rho / lam, 'gyro scale': gyro,
        'wheels': 1.0 + spread, 'about x (roll)': x, 'about y (pitch)': y, 'about z (yaw)': z,
        'gyro time offset [s]': late}


def effective_scale(found, real):
    """What the gyro reads about z of the base, seen through the fitted mounting, over the truth:
    cross-axis errors of an IMU that leans are part of it."""
    up = found.mount.applied(np.eye(3))[2]
    return float(up @ real['gyro reads'])


def covered(found, real):
    """{name: covered or None where refused}."""
    real = {**real, 'gyro scale': effective_scale(found, real)}
    values = {**found.axes, **{v.name: v for v in found.constants},
              **{v.name: v for v in found.mount.turns.values()}}
    result = {name: (value.low <= real[name] <= value.high) if value.given else None
              for name, value in values.items() if name in real}
    for index, value in enumerate(found.wheels):
        result[f'wheel {index}'] = ((value.low <= real['wheels'][index] <= value.high)
                                    if value.given else None)
    return result


def given(found, name):
    """Whether a value of that name is given."""
    values = {**found.axes, **{v.name: v for v in (*found.constants, *found.mount.turns.values())}}
    return name in values and values[name].given


KINDS = {'true pose': {}, 'true pose, slip in every tenth leg': dict(slip=0.1),
         'gyro alone': dict(truth=False)}
UNEXCITED = {  # what must be refused: (name of the value, motion that does not excite it)
    'forward': dict(forward=0.0), 'sideways': dict(sideways=0.0), 'turning': dict(turning=0.0),
    'gyro scale': dict(turning=0.0), 'gyro time offset [s]': dict(turning=0.0),
    'about z (yaw)': dict(forward=0.0, sideways=0.0),
    'about x (roll)': dict(turning=0.0, accelerometer=False),
    'about y (pitch)': dict(turning=0.0, accelerometer=False)}


def main(runs, firsts):
    shown = [f'{first}..' for first in firsts] + (['all'] if len(firsts) > 1 else [])
    for label, options in KINDS.items():
        print(f'| {label} | ' + ' | '.join(shown) + ' |\n|' + ' --- |' * (1 + len(shown)))
        counts: dict[str, list[list[bool]]] = {}
        for number, first in enumerate(firsts):
            for seed in range(first, first + runs):
                for name, value in covered(*one(seed, **options)).items():
                    if value is not None:
                        counts.setdefault(name, [[] for _ in firsts])[number].append(value)
        for name, sets in counts.items():
            whole = sets + ([sum(sets, [])] if len(sets) > 1 else [])
            print(f'| {name} | ' + ' | '.join(
                f'{100 * np.mean(values):.{int(len(values) > 100)}f} % of {len(values)}'
                for values in whole) + ' |', flush=True)
    for name, still in UNEXCITED.items():
        count = sum(given(one(seed, **still)[0], name)
                    for first in firsts for seed in range(first, first + runs))
        print(f'not excited {name:20s}: given {count} times of {runs * len(firsts)}', flush=True)
    return 0


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('runs', type=int, nargs='?', default=100, help='simulated runs a set')
    parser.add_argument('first', type=int, nargs='*', default=[0], help='first seed of each set')
    chosen = parser.parse_args()
    sys.exit(main(chosen.runs, chosen.first))
