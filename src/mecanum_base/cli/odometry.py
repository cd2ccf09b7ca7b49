"""Verb ``odometry``: the odometry node without ``ros2 run``."""

from __future__ import annotations

import argparse

from mecanum_base.cli.node_arguments import add_robot, words_for_ros

HELP = 'the odometry node: wheel angles and IMU in; odom, tf, slip/* and /diagnostics out'
EXAMPLE = """mecanum odometry --robot robot.yaml
mecanum odometry --robot robot.yaml --ros-args -r __ns:=/robot1 -p enable_odom_tf:=false"""
PASSES_ROS_ARGUMENTS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    add_robot(parser)


def run(options: argparse.Namespace) -> int:
    """Run the node until it is told to end."""
    from mecanum_base.ros.odometry_node import main
    return main(words_for_ros(options))
