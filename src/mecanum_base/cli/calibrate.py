"""`mecanum calibrate`: fit the constants of a robot file to recordings."""

from __future__ import annotations

import argparse
import json
import math
import pathlib
import sys
from typing import Any

HELP = ('fit wheel radius, lever arm, lateral factor, gyro scale, mounting and time offset of the '
        'IMU to bags, with uncertainty; writes a robot file; refuses what the motion did not '
        'excite')
EXAMPLE = '''mecanum calibrate run1.mcap run2.mcap --robot robot.yaml --out calibrated.yaml
mecanum calibrate straight.mcap --robot robot.yaml --out calibrated.yaml --distance 3.02'''


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the verb."""
    parser.add_argument('bag', nargs='+', metavar='BAG',
                        help='recordings, or folders that hold them, fitted together')
    parser.add_argument('--robot', required=True, metavar='FILE', help='robot file (YAML)')
    parser.add_argument('--out', required=True, metavar='FILE',
                        help='robot file to write; not written where nothing could be fitted')
    parser.add_argument('--truth-topic', metavar='T',
                        help='topic with the true pose (default: named like ground_truth, mocap)')
    parser.add_argument('--truth-frame', metavar='F',
                        help='of /tf as truth: parent frame of the base')
    parser.add_argument('--encoder-topic', metavar='T', help='topic of the encoders')
    parser.add_argument('--imu-topic', metavar='T', help='topic of the IMU')
    parser.add_argument('--no-imu', action='store_true', help='leave the IMU out')
    parser.add_argument('--distance', type=float, metavar='M',
                        help='straight distance [m] from start to end, measured by hand')
    parser.add_argument('--distance-sigma', type=float, default=0.01, metavar='M',
                        help='standard deviation of that measurement (default: 0.01 m)')
    parser.add_argument('--along', choices=('forward', 'sideways'), default='forward',
                        help='direction of the measured distance (default: forward)')
    parser.add_argument('--per-wheel', action='store_true',
                        help='write a radius for each wheel, not one factor for all')
    parser.add_argument('--json', action='store_true', help='print JSON instead of text')


def run(options: argparse.Namespace) -> int:
    """Fit, print, write; 1 if nothing could be fitted."""
    from mecanum_base.bag.analysis.calibrate_bags import calibrate_bags
    from mecanum_base.bag.analysis.calibrated_file import (
        calibrated_wheels,
        estimator_keys,
        imu_keys,
        rewritten,
        roller_text,
    )
    from mecanum_base.bag.folder import bags_under
    from mecanum_base.cli.progress import Progress
    from mecanum_base.core.errors import BagError, ConfigError
    from mecanum_base.core.kinematics.wheels import Wheels
    from mecanum_base.robot_file import load_robot, read_text
    robot = load_robot(options.robot)
    if options.distance is not None and not options.distance > 0.0:
        raise ConfigError('--distance', options.distance, 'must be > 0', 'm')
    if not options.distance_sigma > 0.0:
        raise ConfigError('--distance-sigma', options.distance_sigma, 'must be > 0', 'm')
    paths = list(bags_under(options.bag))
    with Progress('calibrate') as progress:
        found = calibrate_bags(paths, robot, options, progress.update)
    assert isinstance(robot.base, Wheels)
    given = [n for n, v in found.axes.items() if v.given]
    imu = imu_keys(found, robot)
    estimator = estimator_keys(found)
    given += [f'imu.{key}' for key in imu] + [f'estimator.{key}' for key in estimator]
    text = roller_text(found, robot.base)
    if text:
        found.notes.append(text)
    if not options.per_wheel and any(v.low is not None and v.high is not None
                                     and not v.low <= 1.0 <= v.high for v in found.wheels):
        found.notes.append('the radii of the wheels differ, which turns a base that drives '
                           'straight: --per-wheel writes a radius for each; try it on another '
                           'recording with `mecanum analyze --compare` before you keep it')
    if options.json:
        print(json.dumps(found.plain(), indent=1))
    else:
        _print(found, robot.base.joint)
    if not given:
        print('nothing could be fitted; no file written', file=sys.stderr)
        return 1
    changed = calibrated_wheels(robot.base, found, options.per_wheel)
    bags = ', '.join(pathlib.Path(b).name for b in paths)
    comment = (f'calibrated by mecanum calibrate from {bags} ({found.source}); fitted: '
               f'{", ".join(given)}').replace('\n', ' ')
    try:
        pathlib.Path(options.out).write_text(
            rewritten(read_text(options.robot), options.robot, changed, comment, imu,
                      estimator),
            encoding='utf-8')
    except OSError as error:
        raise BagError(f'{options.out}: cannot be written: {error.strerror}') from None
    load_robot(options.out)
    if not options.json:
        print(f'written to {options.out}')
    return 0


def _print(found: Any, joints: tuple[str, ...]) -> None:
    meaning = {'forward': 'radius (way forward)', 'sideways': 'way sideways',
               'turning': 'yaw (radius over lever)'}
    for name, value in found.axes.items():
        _line(meaning[name], value)
    for value in found.constants:
        _line(value.name, value)
    for value in found.mount.turns.values():
        _line(f'IMU mounting {value.name}', value)
    for joint, value in zip(joints, found.wheels):
        _line(f'radius of {joint} against the mean', value)
    if found.held_out:
        print(f'error on time not used for the fit: {found.held_out["before"]:.3f} m before, '
              f'{found.held_out["after"]:.3f} m after (drift over a quarter of the recording, '
              f'each axis)')
    for note in found.notes:
        print(f'note: {note}')


def _line(name: str, value: Any) -> None:
    if value.value is None:
        print(f'{name:36s} not given: {value.verdict}')
    elif name.startswith('IMU'):
        degrees = [math.degrees(v) for v in (value.value, value.low, value.high)]
        print('{:36s} {:+.2f} deg   90 %: {:+.2f} to {:+.2f}'.format(name, *degrees))
    elif name.endswith('[s]'):
        print(f'{name:36s} {value.value:+.4f}   90 %: {value.low:+.4f} to {value.high:+.4f}')
    else:
        print(f'{name:36s} x {value.value:.4f}   90 %: {value.low:.4f} to {value.high:.4f}')
