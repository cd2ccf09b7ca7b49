"""Write a robot file as text, with units behind every line, so that people can go on editing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mecanum_base.robot import all_rules


def robot_text(mapping: Mapping[str, Any], head: Sequence[str] = ()) -> str:
    """YAML text of a robot file from ``mapping`` (blocks of keys); ``head`` lines become comments.

    Every key is followed by its unit and meaning. Floats are written with a decimal point, as the
    ROS 2 parameter parser wants them.
    """
    rules = all_rules()
    lines = [f'# {line}' for line in head] + ['/**:', '  ros__parameters:']
    for name, value in mapping.items():
        if not isinstance(value, Mapping):
            lines.append(_line(4, name, value, rules[name].text()))
            continue
        lines.append(f'    {name}:')
        lines += [_line(6, key, item, rules[f'{name}.{key}'].text())
                  for key, item in value.items()]
    return '\n'.join(lines) + '\n'


def _line(indent: int, key: str, value: Any, meaning: str) -> str:
    if value is None:
        return f'{" " * indent}# {key}:   <- fill in: {meaning}'
    return f'{" " * indent}{key}: {scalar(value)}  # {meaning}'


def scalar(value: Any) -> str:
    """A value as YAML: floats always with a point, texts quoted only where needed."""
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, float):
        text = repr(round(value, 12) + 0.0)
        return text if any(c in text for c in '.n') else text.replace('e', '.0e')
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        plain = value.replace('_', '').replace('-', '').replace('/', '')
        return value if plain.isalnum() and not plain[0].isdigit() else repr(value)
    return '[' + ', '.join(scalar(item) for item in value) + ']'
