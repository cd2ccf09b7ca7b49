"""`mecanum doctor`: find wiring faults in a recording."""

from __future__ import annotations

import argparse
import json
import sys

HELP = ('find swapped wheels, wrong signs, mirrored rollers, wrong counts, a rotated IMU, wrong '
        'units and clock offsets in a bag; prints the corrected lines')
EXAMPLE = 'mecanum doctor run.mcap --robot robot.yaml'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the verb."""
    parser.add_argument('bag', nargs='+', metavar='BAG',
                        help='MCAP file, rosbag2 folder, or a folder that holds them; several are '
                             'read as one recording')
    parser.add_argument('--robot', required=True, metavar='FILE', help='robot file (YAML)')
    parser.add_argument('--encoder-topic', metavar='T', help='topic of the encoders')
    parser.add_argument('--imu-topic', metavar='T', help='topic of the IMU')
    parser.add_argument('--no-imu', action='store_true', help='leave the IMU out')
    parser.add_argument('--truth-topic', metavar='T', help='topic with the true pose')
    parser.add_argument('--truth-frame', metavar='F',
                        help='of /tf as truth: parent frame of the base')
    parser.add_argument('--json', action='store_true', help='print JSON instead of text')


def run(options: argparse.Namespace) -> int:
    """Examine and print; 1 if a fault was found, 0 if not (or if nothing can be said)."""
    from mecanum_base.bag.analysis.evidence import evidence_of
    from mecanum_base.bag.folder import bags_under
    from mecanum_base.cli.progress import Progress
    from mecanum_base.robot_file import load_robot
    robot = load_robot(options.robot)
    with Progress('doctor') as progress:
        verdict = evidence_of(
            list(bags_under(options.bag)), robot, options.encoder_topic, options.imu_topic,
            not options.no_imu, options.truth_topic, progress.update,
            options.truth_frame).examined()
    if options.json:
        print(json.dumps(verdict.plain(), indent=1))
        return 1 if verdict.diagnoses else 0
    for diagnosis in verdict.diagnoses:
        print(f'{diagnosis.text}  (how sure: {100 * diagnosis.certainty:.0f} %)')
        if diagnosis.evidence:
            print(f'    because: {diagnosis.evidence}')
        for line in diagnosis.lines:
            print(f'    {line}')
    for text in verdict.unclear:
        print(f'not to be told apart: {text}')
    for text in verdict.missing:
        print(f'cannot say: {text}')
    for text in verdict.checked:
        print(f'checked: {text}')
    if not (verdict.diagnoses or verdict.missing or verdict.unclear):
        print('no fault found')
    sys.stdout.flush()
    return 1 if verdict.diagnoses else 0
