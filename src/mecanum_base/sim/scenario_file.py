"""Scenario files: YAML, by path or by the name of a shipped one."""

from __future__ import annotations

import os
import pathlib
import sys
from collections.abc import Iterator

import yaml

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import nearest
from mecanum_base.sim.scenario import Scenario, scenario_from_mapping

_FOLDER = pathlib.Path('config') / 'scenarios'


def load_scenario(name: str | os.PathLike[str]) -> Scenario:
    """The scenario of a file, or the shipped one of that name (``oil``).

    Raises ConfigError with file, key path, value, rule and unit.
    """
    path = find_scenario(name)
    try:
        text = path.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(str(path), None, f'cannot be read: {error}') from None
    return parse_scenario(text, path.stem, str(path))


def parse_scenario(text: str, name: str, source: str) -> Scenario:
    """The scenario in a YAML text; ``source`` is shown in errors."""
    try:
        document = yaml.safe_load(text)
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        where = f', line {mark.line + 1}, column {mark.column + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or 'cannot be parsed'
        raise ConfigError(source + where, None, f'is not valid YAML: {problem}') from None
    try:
        return scenario_from_mapping(document, name)
    except ConfigError as error:
        raise ConfigError(f'{source}: {error.key}', error.value, error.rule,
                          error.unit) from None


def find_scenario(name: str | os.PathLike[str]) -> pathlib.Path:
    """The file of a scenario given by path or by the name of a shipped one."""
    path = pathlib.Path(name)
    if path.suffix in ('.yaml', '.yml') or path.is_file():
        return path
    known = shipped_scenarios()
    if str(name) not in known:
        raise ConfigError('scenario', str(name), f'is no file and no shipped scenario, '
                          f'{nearest(str(name), list(known))}')
    return known[str(name)]


def shipped_scenarios() -> dict[str, pathlib.Path]:
    """Files of the shipped scenarios by name, in alphabetical order."""
    for folder in _folders():
        if folder.is_dir():
            return {path.stem: path for path in sorted(folder.glob('*.yaml'))}
    return {}


def _folders() -> Iterator[pathlib.Path]:
    here = pathlib.Path(__file__).resolve()
    yield here.parents[3] / _FOLDER
    prefixes = [sys.prefix, *filter(None, os.environ.get('AMENT_PREFIX_PATH', '').split(':'))]
    for prefix in (*here.parents, *map(pathlib.Path, prefixes)):
        yield prefix / 'share' / 'mecanum_base' / _FOLDER
