"""Arguments that the verbs of nodes share: ``--robot`` and everything ROS 2 understands."""

from __future__ import annotations

import argparse

ROBOT_HELP = 'robot file; the same as --ros-args --params-file FILE'


def add_robot(parser: argparse.ArgumentParser) -> None:
    """The option ``--robot``; what argparse does not know goes to ROS 2."""
    parser.add_argument('--robot', metavar='FILE', help=ROBOT_HELP)


def words_for_ros(options: argparse.Namespace) -> list[str]:
    """Arguments for the node: the robot file first, so that ``-p`` and others win over it."""
    rest: list[str] = list(options.ros_arguments)
    if options.robot is None:
        return rest
    return ['--ros-args', '--params-file', options.robot, '--', *rest]
