"""Verb ``record``: the record node without ``ros2 run``, and completing a killed recording."""

from __future__ import annotations

import argparse
import sys

from mecanum_base.cli.node_arguments import add_robot, words_for_ros

HELP = 'record every topic of the robot into an MCAP bag, or complete a bag that was cut'
EXAMPLE = """mecanum record --output run1
mecanum record --recover run1"""
PASSES_ROS_ARGUMENTS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    add_robot(parser)
    parser.add_argument('--output', metavar='FOLDER', help='new folder of the bag (default: '
                        'mecanum_ and the date; the same as -p record.output:=FOLDER)')
    parser.add_argument('--recover', metavar='BAG', help='MCAP file or bag folder whose recorder '
                        'was killed: give it a summary and metadata.yaml, then end')


def run(options: argparse.Namespace) -> int:
    """Complete a bag, or record until told to end."""
    if options.recover is not None:
        return _recover(options.recover)
    from mecanum_base.ros.record_node import main
    words = words_for_ros(options)
    if options.output is not None:
        words += ['--ros-args', '-p', f'record.output:={options.output}', '--']
    return main(words)


def _recover(bag: str) -> int:
    from mecanum_base.bag.recover import recover
    result = recover(bag)
    for loss in result.losses:
        print(f'mecanum record: {loss}', file=sys.stderr)
    names = ', '.join(file.name for file in result.files)
    print(f'{names}: {result.messages} messages kept'
          + (f', {result.metadata} written' if result.metadata else ''))
    return 0
