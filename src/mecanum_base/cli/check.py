"""`mecanum check`: is this robot file valid, and what will the robot be able to do and to see?"""

from __future__ import annotations

import argparse
import difflib
import sys

from mecanum_base.cli.check_carriers import describe_carriers
from mecanum_base.cli.check_files import convert_controller, parameter_lines, write_asked
from mecanum_base.cli.check_stamps import late_warning
from mecanum_base.cli.check_wheels import describe_wheels
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.robot import BLOCKS, Robot
from mecanum_base.robot_file import load_robot

HELP = 'validate a robot file and tell what the robot can do and its encoders can see'
EXAMPLE = """mecanum check config/mecanum4.yaml
mecanum check my_robot.yaml --strict      # unknown keys are errors
mecanum check my_robot.yaml --urdf my_robot.urdf --policy policy.xml
mecanum check --from-controller controllers.yaml --counts-per-revolution 4096 --out robot.yaml

exit codes: 0 fine, 1 findings (the file is valid but the base is poor), 2 the file is invalid"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the verb."""
    parser.add_argument('robot_file', metavar='ROBOT_FILE', nargs='?', help='robot file (YAML)')
    parser.add_argument('--strict', action='store_true',
                        help='unknown top-level keys are errors (default: one warning)')
    parser.add_argument('--parameters', action='store_true',
                        help='list every parameter with value, unit and range')
    parser.add_argument('--urdf', metavar='FILE', help='write a URDF of the robot')
    parser.add_argument('--policy', metavar='FILE', help='write an SROS2 policy for our topics')
    parser.add_argument('--from-controller', metavar='FILE', help='convert the YAML of a '
                        'mecanum_drive_controller into a robot file')
    parser.add_argument('--counts-per-revolution', type=float, metavar='N',
                        help='encoder counts a wheel turn, for --from-controller')
    parser.add_argument('--out', metavar='FILE', help='where --from-controller writes '
                        '(default: the screen)')


def run(options: argparse.Namespace) -> int:
    """Print the description; 1 if there are findings. An invalid file raises ConfigError."""
    if options.from_controller:
        return convert_controller(options)
    if options.robot_file is None:
        raise ConfigError('ROBOT_FILE', None, 'must be named (or give --from-controller FILE)')
    robot = load_robot(options.robot_file, strict=options.strict)
    if robot.ignored:
        print(_warning(robot.ignored), file=sys.stderr)
    if warning := late_warning(robot):
        print(warning, file=sys.stderr)
    lines, findings = describe(robot)
    print(f'{options.robot_file}: valid')
    print('\n'.join(lines))
    print()
    if options.parameters:
        print('\n'.join(parameter_lines(robot)))
        print()
    write_asked(options, robot)
    if not findings:
        print('findings: none')
        return 0
    print('findings:')
    for finding in findings:
        print(f'  - {finding}')
    return 1


def describe(robot: Robot) -> tuple[list[str], list[str]]:
    """(lines for people, findings) on a valid robot."""
    base = robot.base
    return (describe_wheels(base, robot) if isinstance(base, Wheels)
            else describe_carriers(base, robot))


def _warning(ignored: tuple[str, ...]) -> str:
    """One line that names the unknown top-level keys and what they may have been meant for."""
    parts = []
    for key in ignored:
        close = difflib.get_close_matches(key, list(BLOCKS), n=1, cutoff=0.7)
        parts.append(f'{key} (did you mean {close[0]}?)' if close else key)
    return f'warning: unknown top-level keys, ignored: {", ".join(parts)}'
