"""Verb ``goal``: the goal node without ``ros2 run``."""

from __future__ import annotations

import argparse

from mecanum_base.cli.node_arguments import add_robot, words_for_ros

HELP = 'the goal node: drives to goal_pose past obstacles, by a potential field'
EXAMPLE = """mecanum goal --robot robot.yaml
mecanum goal --robot robot.yaml --ros-args -r __ns:=/robot1"""
PASSES_ROS_ARGUMENTS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    add_robot(parser)


def run(options: argparse.Namespace) -> int:
    """Run the node until it is told to end."""
    from mecanum_base.ros.goal_node import main
    return main(words_for_ros(options))
