"""Verb ``drive``: the drive node without ``ros2 run``."""

from __future__ import annotations

import argparse

from mecanum_base.cli.node_arguments import add_robot, words_for_ros

HELP = 'the drive node: cmd_vel in; wheel_commands, cmd_vel_limited and /diagnostics out'
EXAMPLE = """mecanum drive --robot robot.yaml
mecanum drive --robot robot.yaml --ros-args -p drive.cmd_vel_type:=twist_stamped"""
PASSES_ROS_ARGUMENTS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    add_robot(parser)


def run(options: argparse.Namespace) -> int:
    """Run the node until it is told to end."""
    from mecanum_base.ros.drive_node import main
    return main(words_for_ros(options))
