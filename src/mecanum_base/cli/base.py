"""Verb ``base``: drive, odometry and other nodes in one process."""

from __future__ import annotations

import argparse

from mecanum_base.cli.node_arguments import add_robot, words_for_ros

HELP = 'drive and odometry node in one process, for small computers; others on demand'
EXAMPLE = """mecanum base --robot robot.yaml
mecanum base --robot robot.yaml --sim --record"""
PASSES_ROS_ARGUMENTS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    add_robot(parser)
    for name in ('sim', 'goal', 'record'):
        parser.add_argument(f'--{name}', action='store_true', help=f'run the {name} node as well')


def run(options: argparse.Namespace) -> int:
    """Run the nodes until they are told to end."""
    from mecanum_base.ros.base_node import run_chosen
    return run_chosen(options, words_for_ros(options))
