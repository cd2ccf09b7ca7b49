"""Several nodes in one process, for small computers: drive and odometry, and others on demand.

Names, topics, services and parameters are those of the single nodes. One executor serves all
nodes in turn, so an exception in any of them stops the wheels and ends the process.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence

from rclpy.node import Node

from mecanum_base.ros.process import run

_NODES = {'drive': 'DriveNode', 'odometry': 'OdometryNode', 'sim': 'SimNode', 'goal': 'GoalNode',
          'record': 'RecordNode'}
ALWAYS = ('drive', 'odometry')
OPTIONAL = tuple(name for name in _NODES if name not in ALWAYS)
EXAMPLE = 'base_node --sim --ros-args --params-file robot.yaml'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options that add nodes."""
    for name in OPTIONAL:
        parser.add_argument(f'--{name}', action='store_true', help=f'run the {name} node as well')


def node_class(name: str) -> type[Node]:
    """The node class by its short name; imported only when wanted, as record needs mcap."""
    module = importlib.import_module(f'mecanum_base.ros.{name}_node')
    found: type[Node] = getattr(module, _NODES[name])
    return found


def run_chosen(options: argparse.Namespace, words: Sequence[str]) -> int:
    """Run drive, odometry and the chosen nodes until they are told to end; the exit code."""
    names = [*ALWAYS, *(name for name in OPTIONAL if getattr(options, name))]
    return run([node_class(name) for name in names], words, commands_wheels=True,
               name='base_node')


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns the exit code."""
    words = list(sys.argv[1:] if args is None else args)
    parser = argparse.ArgumentParser(
        prog='base_node', description=__doc__, allow_abbrev=False,
        epilog=f'example:\n  ros2 run mecanum_base {EXAMPLE}',
        formatter_class=argparse.RawDescriptionHelpFormatter)
    add_arguments(parser)
    split = words.index('--ros-args') if '--ros-args' in words else len(words)
    return run_chosen(parser.parse_args(words[:split]), words[split:])
