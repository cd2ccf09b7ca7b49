"""The verbs of the `mecanum` command: finds one, runs it and turns errors into exit codes.

Each verb is one module of this package with ``HELP`` (one line), ``EXAMPLE`` (shown by --help),
``add_arguments(parser)`` and ``run(options) -> int``. A module is imported only when its verb is
used, so that a missing extra never breaks another verb.

Exit codes: 0 fine, 1 findings, 2 wrong usage or input, 130 interrupted (Ctrl-C).
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence

from mecanum_base import __version__
from mecanum_base.cli.beginning import interrupts_are_raised
from mecanum_base.cli.interrupts import kept
from mecanum_base.cli.leftover import Leftover
from mecanum_base.cli.main import INTERRUPTED
from mecanum_base.core.errors import MecanumBaseError

VERBS = {
    'demo': 'drive a simulated base over ROS 2 topics; odometry and slip against the truth',
    'replay': 'run the estimator over a recorded bag',
    'analyze': 'findings and report on recorded bags',
    'calibrate': 'fit the constants of wheels and IMU to a bag',
    'doctor': 'find swapped wheels, wrong signs and other wiring faults in a bag',
    'check': 'validate a robot file',
    'combos': 'the 81 wheel combinations of a four-wheel base',
    'roller': 'roller geometry of a mecanum wheel',
    'sim': 'simulated hardware: as a node, or headless into a bag',
    'drive': 'the drive node',
    'odometry': 'the odometry node',
    'base': 'drive, odometry and other nodes in one process',
    'goal': 'the goal node',
    'record': 'the record node; --recover completes a cut bag',
}


class Interrupted(Exception):
    """Ctrl-C while a verb ran; the text says what it leaves behind."""


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; returns the exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or words[0] in ('-h', '--help'):
        print(_overview())
        return 0 if words else 2
    if words[0] == '--version':
        print(f'mecanum_base {__version__}')
        return 0
    if words[0] not in VERBS:
        print(f'mecanum: unknown command {words[0]!r}; one of: {", ".join(VERBS)}',
              file=sys.stderr)
        return 2
    try:
        return _run(words[0], words[1:])
    except MecanumBaseError as error:
        print(f'mecanum {words[0]}: {error}', file=sys.stderr)
        return 2
    except ModuleNotFoundError as error:
        if (error.name or '').startswith('mecanum_base'):
            raise
        print(f'mecanum {words[0]}: needs the Python package {error.name!r}: {_advice(error)}',
              file=sys.stderr)
        return 2
    except Interrupted as stop:
        return _end_interrupted(words[0], str(stop))
    except KeyboardInterrupt:
        return _end_interrupted(words[0])
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 2


def _end_interrupted(verb: str, leftover: str = '') -> int:
    print(f'mecanum {verb}: interrupted{leftover}', file=sys.stderr)
    # CPython notes an interrupt inside exec('...') (dataclasses use it) as never caught and would
    # end `python -m` by the signal instead of our code; the next exec clears the note
    exec('')
    return INTERRUPTED


def _run(verb: str, words: list[str]) -> int:
    module = importlib.import_module(f'mecanum_base.cli.{verb}')
    parser = argparse.ArgumentParser(
        prog=f'mecanum {verb}', description=module.HELP,
        epilog='example:\n  ' + '\n  '.join(module.EXAMPLE.strip().splitlines()),
        formatter_class=argparse.RawDescriptionHelpFormatter)
    module.add_arguments(parser)
    if getattr(module, 'PASSES_ROS_ARGUMENTS', False):  # the nodes hand the rest to rclpy
        options, rest = parser.parse_known_args(words)
        options.ros_arguments = rest
    else:
        options = parser.parse_args(words)
    leftover = Leftover(getattr(options, 'out', None))
    try:
        with kept():
            interrupts_are_raised()
            code: int = module.run(options)
    except KeyboardInterrupt:
        raise Interrupted(leftover.text()) from None
    return code


def _overview() -> str:
    width = max(len(verb) for verb in VERBS)
    lines = ['usage: mecanum COMMAND [options]', '', 'commands:']
    lines += [f'  {verb:<{width}}  {text}' for verb, text in VERBS.items()]
    lines += ['', 'mecanum COMMAND --help shows options and an example.']
    return '\n'.join(lines)


def _advice(error: ModuleNotFoundError) -> str:
    name = (error.name or '').split('.')[0]
    if name == 'rclpy' or name.endswith('_msgs') or name == 'std_srvs':
        return "source a ROS 2 Jazzy, or pip install 'mecanum_base[ros]' in a venv"
    extra = {'matplotlib': 'report', 'plotly': 'report', 'jinja2': 'report', 'numba': 'fast',
             'trimesh': 'mesh',
             'dask': 'fleet', 'distributed': 'fleet',
             'pyarrow': 'parquet'}.get(name)
    package = f'mecanum_base[{extra}]' if extra else name
    return f"pip install '{package}'"
