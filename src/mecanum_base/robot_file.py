"""Read robot files: YAML that is at once a ROS 2 parameter file.

Besides YAML syntax this checks what the ROS 2 parameter parser (rcl) would refuse later with a
less helpful message: a list that mixes ``0`` and ``0.2``.
"""

from __future__ import annotations

import os
import pathlib
import re
import sys
from collections.abc import Iterator
from typing import Any

import yaml

from mecanum_base.core.errors import ConfigError
from mecanum_base.robot import Robot

_INT, _FLOAT = 'tag:yaml.org,2002:int', 'tag:yaml.org,2002:float'


def load_robot(path: str | os.PathLike[str], *, strict: bool = False) -> Robot:
    """The robot described by the file; ConfigError names file, line, key, value, rule and unit."""
    text = read_text(path)
    mapping = parse_parameters(text, str(path))
    try:
        return Robot.from_mapping(mapping, strict=strict)
    except ConfigError as error:
        line = line_of(text, error.key)
        raise error.located(f'{path}, line {line}' if line else str(path)) from None


def line_of(text: str, key: str) -> int:
    """Line of the file in which ``key`` (``wheels.radius[2]``) or its nearest parent stands.

    0 where not even its block is there.
    """
    node: Any = yaml.compose(text, Loader=yaml.SafeLoader)
    line = 0
    for depth, name in enumerate(['/**', 'ros__parameters', *re.findall(r'[^.\[\]]+', key)]):
        children = _children(node)
        if name not in children:
            return line if depth > 2 else 0
        line, node = children[name]
    return line


def _children(node: Any) -> dict[str, tuple[int, Any]]:
    """(line, node) of the entries of a YAML mapping by key, or of a list by index."""
    if isinstance(node, yaml.MappingNode):
        return {str(key.value): (key.start_mark.line + 1, value) for key, value in node.value}
    if isinstance(node, yaml.SequenceNode):
        return {str(i): (item.start_mark.line + 1, item) for i, item in enumerate(node.value)}
    return {}


def read_parameters(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The mapping below ``/**: ros__parameters:`` of a parameter file."""
    return parse_parameters(read_text(path), str(path))


def read_text(path: str | os.PathLike[str]) -> str:
    """Text of the file; ConfigError where it cannot be read."""
    try:
        return pathlib.Path(path).read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise ConfigError(str(path), None, f'cannot be read: {reason}') from None


def parse_parameters(text: str, name: str) -> dict[str, Any]:
    """As :func:`read_parameters`, from a text; ``name`` is shown in errors."""
    document = parse_yaml(text, name)
    for top in ('/**', '**'):
        if top in document:
            block = document[top]
            if not isinstance(block, dict) or not isinstance(block.get('ros__parameters'), dict):
                raise ConfigError(f'{name}: {top}', None, 'must hold a block ros__parameters')
            return dict(block['ros__parameters'])
    raise ConfigError(name, sorted(str(k) for k in document),
                      'must have a block "/**:" with "ros__parameters:" (README: add your robot)')


def parse_yaml(text: str, name: str) -> dict[str, Any]:
    """A YAML mapping; ConfigError with line and column for bad syntax or mixed number lists."""
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        document = yaml.safe_load(text)
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        where = f', line {mark.line + 1}, column {mark.column + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or str(error).splitlines()[0]
        raise ConfigError(name + where, None, f'is not valid YAML: {problem}') from None
    if not isinstance(document, dict):
        raise ConfigError(name, document, 'must be a YAML mapping')
    for key, item in _mixed_lists(node, ''):
        raise ConfigError(
            f'{name}, line {item.start_mark.line + 1}, {key}', item.value,
            f'mixes whole numbers and floats, which ROS 2 refuses: write {item.value}.0')
    return document


def _mixed_lists(node: Any, path: str) -> Iterator[tuple[str, Any]]:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield from _mixed_lists(value, f'{path}.{key.value}' if path else str(key.value))
    elif isinstance(node, yaml.SequenceNode):
        tags = {item.tag for item in node.value}
        if {_INT, _FLOAT} <= tags:
            index, item = next((i, v) for i, v in enumerate(node.value) if v.tag == _INT)
            yield f'{path}[{index}]', item
        for index, item in enumerate(node.value):
            yield from _mixed_lists(item, f'{path}[{index}]')


def shipped(folder: str = 'config') -> pathlib.Path:
    """The folder of robot files that comes with the package (source tree, pip or colcon)."""
    here = pathlib.Path(__file__).resolve()
    candidates = [here.parents[2] / folder]
    prefixes = [sys.prefix, *filter(None, os.environ.get('AMENT_PREFIX_PATH', '').split(':'))]
    candidates += [parent / 'share' / 'mecanum_base' / folder for parent in here.parents]
    candidates += [pathlib.Path(p) / 'share' / 'mecanum_base' / folder for p in prefixes]
    for candidate in candidates:
        if (candidate / 'mecanum4.yaml').is_file():
            return candidate
    raise ConfigError(folder, None, 'the shipped robot files are not installed')
