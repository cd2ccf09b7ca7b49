"""Stand-ins for launch and launch_ros, which pip cannot install, and what they would start.

:func:`description` builds the launch file with classes that only keep their arguments,
:func:`processes` gives the processes for given launch arguments, with conditions, groups and
substitutions worked out as launch does.
"""

import pathlib
import runpy
import sys
import types
from dataclasses import dataclass
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILE = ROOT / 'launch' / 'base.launch.py'
MODULES = {
    'launch': ['LaunchDescription'],
    'launch.actions': ['DeclareLaunchArgument', 'GroupAction'],
    'launch.conditions': ['IfCondition', 'UnlessCondition'],
    'launch.substitutions': ['LaunchConfiguration', 'PathJoinSubstitution'],
    'launch_ros': [],
    'launch_ros.actions': ['Node'],
    'launch_ros.substitutions': ['FindPackageShare'],
}


class Recorded:
    """Stands for any launch class: keeps its arguments."""

    def __init__(self, *arguments, **options):
        self.kind, self.arguments, self.options = type(self).__name__, arguments, options


def description():
    """What the launch file builds."""
    modules = {}
    for name, classes in MODULES.items():
        modules[name] = types.ModuleType(name)
        vars(modules[name]).update({each: type(each, (Recorded,), {}) for each in classes})
    with mock.patch.dict(sys.modules, modules):
        return runpy.run_path(str(FILE))['generate_launch_description']()


def everything(item):
    """All recorded objects inside ``item``."""
    if isinstance(item, Recorded):
        yield item
        yield from everything(item.arguments)
        yield from everything(item.options)
    elif isinstance(item, dict):
        yield from everything(list(item.values()))
    elif isinstance(item, (list, tuple)):
        for part in item:
            yield from everything(part)


@dataclass
class Started:
    """One process that launch would start; ``words`` are its arguments."""

    package: str
    executable: str
    words: list
    options: dict


def processes(built, **given):
    """The processes of a description for launch arguments; unknown arguments raise KeyError."""
    declared = {one.arguments[0]: one for one in everything(built)
                if one.kind == 'DeclareLaunchArgument'}
    values = {name: _text(one.options['default_value'], {}) for name, one in declared.items()}
    for name, value in given.items():
        if name not in declared:
            raise KeyError(name)
        values[name] = value
    return list(_started(built.arguments[0], values))


def _started(items, values):
    for item in items:
        if item.kind == 'GroupAction':
            if _holds(item.options.get('condition'), values):
                yield from _started(item.arguments[0], values)
        elif item.kind == 'Node' and _holds(item.options.get('condition'), values):
            yield _process(item.options, values)


def _process(options, values):
    words = [_text(word, values) for word in options.get('arguments', [])] + ['--ros-args']
    for entry in options['parameters']:
        if isinstance(entry, dict):
            for name, value in entry.items():
                words += ['-p', f'{name}:={_text(value, values)}']
        else:
            words += ['--params-file', _text(entry, values)]
    space = _text(options.get('namespace', ''), values)
    if space:
        words += ['-r', f'__ns:=/{space.lstrip("/")}']
    more = {name: _text(options[name], values) for name in ('respawn',) if name in options}
    return Started(_text(options['package'], values), _text(options['executable'], values), words,
                   more)


def _holds(condition, values):
    if condition is None:
        return True
    text = _text(condition.arguments[0], values).lower()
    assert text in ('true', 'false', '1', '0'), f'launch refuses {text!r} as a condition'
    return (text in ('true', '1')) == (condition.kind == 'IfCondition')


def _text(item, values):
    """A substitution worked out; the share folder of the package is the project itself."""
    if not isinstance(item, Recorded):
        return str(item)
    if item.kind == 'LaunchConfiguration':
        return values[item.arguments[0]]
    if item.kind == 'PathJoinSubstitution':
        return str(pathlib.Path(*(_text(part, values) for part in item.arguments[0])))
    if item.kind == 'FindPackageShare':
        assert item.arguments == ('mecanum_base',)
        return str(ROOT)
    raise TypeError(item.kind)
