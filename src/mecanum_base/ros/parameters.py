"""The robot file as ROS 2 parameters: declared, described, validated, changed live.

Names, defaults, units, ranges and meanings all come from the dataclasses of the robot file, so a
parameter exists in one place only. Every node declares all blocks; those of the other base (a
robot has ``wheels`` or ``carriers``) stay undeclared. A list that was not given and has no finite
default is declared as the empty list, which ``ros2 param dump`` writes and rcl reads again.

Whole numbers are accepted where floats are meant (dynamic typing). A change while the node runs
is checked against the whole robot before anything is set, so several parameters set atomically
are judged together; only parameters marked live can be changed.
"""

from __future__ import annotations

import array
import dataclasses
import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Union

import numpy as np
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import ParameterNotDeclaredException
from rclpy.node import Node
from rclpy.parameter import Parameter

from mecanum_base import robot_file
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import Rule, nearest
from mecanum_base.robot import BLOCKS, Robot, all_rules

OWNED_BY_ROS = ('use_sim_time', 'start_type_description_service')
_LISTS = ('floats', 'ints', 'strs', 'float_or_floats')

RobotSource = Union[str, 'os.PathLike[str]', Mapping[str, Any]]


def declare(node: Node) -> Robot:
    """Declare every parameter on ``node`` and return the robot its overrides describe.

    Raises ConfigError where an override breaks a rule or is unknown inside a known block. Keys
    outside the known blocks (a shared Nav2 file) get one warning.
    """
    # The private name is the only way to see overrides that nobody declared: declaring them
    # automatically fails on an empty list.
    given = {name: _plain(item.value) for name, item in node._parameter_overrides.items()}
    robot = Robot.from_mapping(nested(given))
    for name, rule in all_rules().items():
        if _belongs(name, robot):
            node.declare_parameter(name, _declared_value(name, robot),
                                   descriptor(rule), ignore_override=True)
    if robot.ignored:
        node.get_logger().warning('parameters of no known block are ignored: '
                                  + ', '.join(robot.ignored))
    return robot


class LiveParameters:
    """Judges every change of a declared parameter and hands the changed robot to the node.

    ``apply`` is called once per accepted change with the new robot, between two callbacks of the
    executor; ``refuse`` is called with the reason of a refused one. Until the change is complete
    :attr:`robot` is the old one.
    """

    def __init__(self, node: Node, robot: Robot, apply: Callable[[Robot], None],
                 refuse: Callable[[str], None]) -> None:
        self._node, self.robot, self._apply, self._refuse = node, robot, apply, refuse
        node.add_pre_set_parameters_callback(self._look)
        node.add_on_set_parameters_callback(self._judge)
        node.add_post_set_parameters_callback(self._change)

    def _look(self, changes: list[Parameter]) -> list[Parameter]:
        """See every change first: rclpy itself refuses some without asking anybody."""
        problem = self._problem(changes)
        if problem:
            self._refuse(problem)
        if any(self._is_unknown(change) for change in changes):
            raise ParameterNotDeclaredException(problem)
        return changes

    def _judge(self, changes: list[Parameter]) -> SetParametersResult:
        problem = self._problem(changes)
        return SetParametersResult(successful=not problem, reason=problem)

    def _problem(self, changes: Sequence[Parameter]) -> str:
        """Why the changes cannot be accepted; '' if they can."""
        for change in changes:
            if self._is_unknown(change):
                known = [name for name in all_rules() if self._node.has_parameter(name)]
                return f'{change.name}: unknown parameter, {nearest(change.name, known)}'
            if change.name in all_rules() and not all_rules()[change.name].live:
                return f'{change.name}: read-only, it can only be set at the start'
        try:
            self._with(changes)
        except ConfigError as error:
            return str(error)
        return ''

    def _is_unknown(self, change: Parameter) -> bool:
        return not self._node.has_parameter(change.name) and not _is_ros(change.name)

    def _with(self, changes: Sequence[Parameter]) -> Robot:
        rules = all_rules()
        values = {name: _plain(self._node.get_parameter(name).value)
                  for name in rules if self._node.has_parameter(name)}
        values = {name: value for name, value in values.items() if value is not None}
        for change in changes:
            if change.name in rules:
                if change.type_ == Parameter.Type.NOT_SET:
                    raise ConfigError(change.name, None, 'cannot be unset while the node runs')
                values[change.name] = _plain(change.value)
        return Robot.from_mapping(nested(values))

    def _change(self, changes: list[Parameter]) -> None:
        if any(change.name in all_rules() for change in changes):
            self.robot = self._with(())
            self._apply(self.robot)


def descriptor(rule: Rule) -> ParameterDescriptor:
    """Description, unit and range of a rule as ROS 2 shows them."""
    found = ParameterDescriptor(
        description=rule.text(), read_only=not rule.live,
        additional_constraints=_constraints(rule),
        dynamic_typing=rule.kind in ('float', *_LISTS))
    if rule.low is not None and rule.high is not None and not rule.open_low:
        if rule.kind == 'float':
            found.floating_point_range = [FloatingPointRange(
                from_value=float(rule.low), to_value=float(rule.high), step=0.0)]
        elif rule.kind == 'int':
            found.integer_range = [IntegerRange(
                from_value=int(rule.low), to_value=int(rule.high), step=1)]
    return found


def overrides(source: RobotSource, **more: Any) -> list[Parameter]:
    """Parameter overrides for a node made in this process: of a robot file or of a mapping.

    ``more`` are further parameters, dots written as ``__``: ``overrides(file, drive__rate=20.0)``.
    """
    mapping = source if isinstance(source, Mapping) else robot_file.read_parameters(source)
    values = {**flat(mapping), **{name.replace('__', '.'): value for name, value in more.items()}}
    return [Parameter(name, value=_as_ros(value)) for name, value in values.items()]


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Blocks of keys from full parameter names; an unset list counts as empty.

    Names that belong to ROS itself are left out; ``a.b.c`` becomes key ``b.c`` of block ``a``.
    """
    found: dict[str, Any] = {}
    rules = all_rules()
    for name, value in values.items():
        if _is_ros(name):
            continue
        if value is None and name in rules and rules[name].kind in _LISTS:
            value = []  # rcl reads an empty list as a parameter without a value
        block, dot, key = name.partition('.')
        if not dot:
            found[name] = value
        else:
            found.setdefault(block, {})
            if isinstance(found[block], dict):
                found[block][key] = value
    return found


def flat(mapping: Mapping[str, Any], prefix: str = '') -> dict[str, Any]:
    """Full parameter names from nested blocks."""
    found: dict[str, Any] = {}
    for key, value in mapping.items():
        name = f'{prefix}{key}'
        found.update(flat(value, f'{name}.') if isinstance(value, Mapping) else {name: value})
    return found


def _constraints(rule: Rule) -> str:
    bounds = rule.range_text() if rule.low is not None or rule.high is not None else ''
    choices = 'one of ' + ', '.join(rule.choices) if rule.choices else ''
    return ', '.join(part for part in (choices, bounds) if part)


def _belongs(name: str, robot: Robot) -> bool:
    """Whether the parameter is of this robot: not of the base it does not have."""
    block = name.partition('.')[0]
    return block not in ('wheels', 'carriers') or isinstance(robot.base, BLOCKS[block])


def _declared_value(name: str, robot: Robot) -> Any:
    """The value to declare; the empty list for one that has no finite default."""
    value = _as_ros(_robot_value(name, robot))
    if isinstance(value, list):
        finite = all(not isinstance(item, float) or math.isfinite(item) for item in value)
        return value if finite else []
    return value


def _robot_value(name: str, robot: Robot) -> Any:
    """The value of a parameter as the robot holds it."""
    block, dot, key = name.partition('.')
    if not dot:
        return getattr(robot.frames, name)
    section = robot.base if block in ('wheels', 'carriers') else getattr(robot, block)
    return getattr(section, key)


def _as_ros(value: Any) -> Any:
    """A value rclpy can store: lists instead of arrays and tuples, plain numbers."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (tuple, list)):
        items = [_as_ros(item) for item in value]
        numbers = {type(item) for item in items}
        return [float(item) for item in items] if numbers == {int, float} else items
    return value


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, (array.array, tuple)) else value


def _is_ros(name: str) -> bool:
    return name.partition('.')[0] in OWNED_BY_ROS


def changed(old: Robot, new: Robot) -> tuple[str, ...]:
    """Names of the blocks whose values differ."""
    return tuple(item.name for item in dataclasses.fields(Robot)
                 if _values(getattr(old, item.name)) != _values(getattr(new, item.name)))


def _values(section: Any) -> Any:
    if not dataclasses.is_dataclass(section):
        return section
    return {item.name: _as_ros(getattr(section, item.name))
            for item in dataclasses.fields(section)}
