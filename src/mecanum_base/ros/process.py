"""One life of a node process: start, spin, stop the wheels, exit with a code that means something.

Exit codes: 0 after SIGINT, SIGTERM or SIGHUP, 1 after an exception in a callback (traceback in
the log), 2 for wrong usage or a robot file that breaks a rule (one line says what and where).

rclpy's own signal handlers shut the context down before the node can say a last word, so they are
off and the signals are handled here: the node publishes zeros, the publishers wait until they are
acknowledged, then everything is shut down.
"""

from __future__ import annotations

import argparse
import inspect
import signal
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Union

import rclpy
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import ok, try_shutdown

from mecanum_base import robot_file
from mecanum_base.core.errors import ConfigError
from mecanum_base.ros.spinning import spin

ACKNOWLEDGED_WITHIN = 0.2  # s, as the interface contract says
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

Factory = Callable[[], Node]


class StopRequest:
    """Remembers the first signal that asked the process to end."""

    def __init__(self) -> None:
        self.reason = ''

    def __call__(self, number: int, _frame: Any) -> None:
        """The signal handler."""
        self.reason = self.reason or f'received {signal.Signals(number).name}'


def run(factory: Union[Factory, Sequence[Factory]], args: Sequence[str] | None = None, *,
        commands_wheels: bool = False, name: str = '') -> int:
    """Run the node of ``factory`` (or several in one process) until it ends; the exit code.

    ``args`` are the words after the program ``name`` (default: the module of the first node).
    With ``commands_wheels`` every node that has ``halt(reason) -> publishers`` is halted before
    the process ends, whatever ended it, and its publishers wait until the zeros are acknowledged.
    """
    factories = tuple(factory) if isinstance(factory, Sequence) else (factory,)
    words = list(sys.argv[1:] if args is None else args)
    name = name or _program(factories)
    _refuse_unknown(name, factories, words)
    with _signals() as stop:
        nodes: list[Node] = []
        try:
            check_arguments(words)
            rclpy.init(args=words, signal_handler_options=SignalHandlerOptions.NO)
            nodes.extend(make() for make in factories)
        except (ConfigError, RuntimeError) as error:  # RuntimeError: rcl refused the arguments
            if isinstance(error, RuntimeError) and ok():
                raise
            print(f'{name}: {str(error).splitlines()[0]}', file=sys.stderr)
            _close(nodes)
            return 2
        code = _spin(nodes, stop, commands_wheels)
        _close(nodes)
        return code


def check_arguments(words: Sequence[str]) -> None:
    """Find lists that mix 0 and 0.2 in parameter files and -p values, before rcl refuses them.

    Raises ConfigError with file, line and the number to write.
    """
    for word, following in zip(words, [*words[1:], '']):
        if word == '--params-file':
            robot_file.parse_yaml(robot_file.read_text(following), following)
        elif word in ('-p', '--param') and ':=' in following:
            key, value = following.split(':=', 1)
            robot_file.parse_yaml(f'{key}: {value}', f'-p {key}')


def halt(nodes: Sequence[Node], reason: str) -> None:
    """Stop the wheels of every node that commands any and wait until that has arrived."""
    for node in nodes:
        stop = getattr(node, 'halt', None)
        if stop is None:
            continue
        for publisher in stop(reason):
            publisher.wait_for_all_acked(Duration(seconds=ACKNOWLEDGED_WITHIN))


def _spin(nodes: Sequence[Node], stop: StopRequest, commands_wheels: bool) -> int:
    executor = SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)
    reason, code = '', 0
    try:
        spin(nodes, executor, lambda: not stop.reason and ok())
        reason = stop.reason
    except ExternalShutdownException:
        reason = 'the context was shut down'
    except Exception as error:
        nodes[0].get_logger().fatal(traceback.format_exc())
        reason, code = f'exception in a callback: {error!r}', 1
    if commands_wheels and ok():
        try:
            halt(nodes, reason)
        except Exception:
            nodes[0].get_logger().fatal(traceback.format_exc())
            code = 1
    executor.shutdown()
    return code


def _close(nodes: Sequence[Node]) -> None:
    for node in nodes:
        node.destroy_node()
    try_shutdown()


@contextmanager
def _signals() -> Iterator[StopRequest]:
    """Own signal handlers for the time of the block; Python allows them in the main thread."""
    stop = StopRequest()
    wanted = [number for number in SIGNALS
              if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN]  # nohup
    before = {number: signal.signal(number, stop) for number in wanted}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _program(factories: Sequence[Factory]) -> str:
    module = inspect.getmodule(factories[0])
    return module.__name__.rpartition('.')[2] if module else 'node'


def _refuse_unknown(name: str, factories: Sequence[Factory], words: Sequence[str]) -> None:
    """Handle --help; exit with code 2 for words that are not for ROS."""
    module = inspect.getmodule(factories[0])
    parser = argparse.ArgumentParser(
        prog=name, description=inspect.getdoc(module),
        epilog=f'example:\n  ros2 run mecanum_base {name} --ros-args --params-file robot.yaml',
        usage=f'{name} [--ros-args ROS 2 arguments]',
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.parse_args(_own_words(words))


def _own_words(words: Sequence[str]) -> list[str]:
    """The words that are not between --ros-args and -- (or the end)."""
    own, for_ros = [], False
    for word in words:
        if word == '--ros-args':
            for_ros = True
        elif for_ros and word == '--':
            for_ros = False
        elif not for_ros:
            own.append(word)
    return own
