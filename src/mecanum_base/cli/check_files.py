"""Files that `mecanum check` writes: parameters, URDF, access policy, converted files."""

from __future__ import annotations

import argparse
import pathlib
import sys
from typing import Any

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.integration.controller import find_controller, robot_from_controller
from mecanum_base.integration.policy import policy
from mecanum_base.integration.robot_text import robot_text
from mecanum_base.integration.urdf import urdf
from mecanum_base.robot import BLOCKS, Robot, all_rules
from mecanum_base.robot_file import parse_yaml, read_text


def convert_controller(options: argparse.Namespace) -> int:
    """Write a robot file made from the YAML of a mecanum_drive_controller; 1 if it has gaps."""
    source = options.from_controller
    name, parameters = find_controller(parse_yaml(read_text(source), source))
    mapping, warnings = robot_from_controller(
        parameters, counts_per_revolution=options.counts_per_revolution)
    text = robot_text(mapping, [f'made by mecanum check from {name} in '
                                f'{pathlib.Path(source).name}', *warnings])
    if options.out:
        write(options.out, text)
    else:
        print(text, end='')
    for warning in warnings:
        print(f'warning: {warning}', file=sys.stderr)
    return 1 if options.counts_per_revolution is None else 0


def write_asked(options: argparse.Namespace, robot: Robot) -> None:
    """Write the files that were asked for and say so."""
    if options.urdf:
        write(options.urdf, urdf(robot))
    if options.policy:
        write(options.policy, policy())


def write(path: str, text: str) -> None:
    """Write a new file; an existing one is kept and refused."""
    try:
        with open(path, 'x', encoding='utf-8') as stream:
            stream.write(text)
    except FileExistsError:
        raise ConfigError(path, None, 'exists already and is not overwritten') from None
    except OSError as error:
        raise ConfigError(path, None, f'cannot be written: {error.strerror}') from None
    print(f'written: {path}')


def parameter_lines(robot: Robot) -> list[str]:
    """One line a parameter: name, value, and meaning with unit and range."""
    rows = []
    for name, rule in all_rules().items():
        found = _value(robot, name)
        if found is not None:
            rows.append((name, _shown(found[0]), rule.text() + (' (live)' if rule.live else '')))
    widths = [max(len(row[i]) for row in rows) for i in range(2)]
    return [f'{name:<{widths[0]}}  {value:<{widths[1]}}  {text}' for name, value, text in rows]


def _value(robot: Robot, name: str) -> tuple[Any] | None:
    """The value in use as a 1-tuple; None for a block that this robot does not have."""
    block, _, key = name.partition('.')
    if not key:
        return (getattr(robot.frames, name),)
    if block in ('wheels', 'carriers'):
        return (getattr(robot.base, key),) if isinstance(robot.base, BLOCKS[block]) else None
    return (getattr(getattr(robot, block), key),)


def _shown(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return '[' + ', '.join(_shown(item) for item in value) + ']'
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, float):
        return f'{value:g}'
    return str(value) if value != '' else "''"
