"""The robot: blocks assembled and checked against each other."""

import copy

import pytest

from mecanum_base.core.errors import ConfigError, GeometryError
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.robot import BLOCKS, Robot, all_rules
from mecanum_base.robot_file import read_parameters, shipped

MECANUM = read_parameters(shipped() / 'mecanum4.yaml')
PLATFORM = read_parameters(shipped() / 'dual_differential.yaml')


def changed(mapping=MECANUM, /, **blocks):
    copied = copy.deepcopy(mapping)
    for name, values in blocks.items():
        if values is None:
            del copied[name]
        elif isinstance(values, dict):
            copied[name] = {**copied.get(name, {}), **values}
        else:
            copied[name] = values
    return copied


def test_wheels_encoder_and_imu_are_a_complete_robot():
    robot = Robot.from_mapping({key: MECANUM[key] for key in ('wheels', 'encoder', 'imu')})
    assert isinstance(robot.base, Wheels) and robot.base.count == 4
    assert robot.frames.odom_frame_id == 'odom' and robot.ignored == ()


def test_two_carriers_are_a_robot_too():
    assert isinstance(Robot.from_mapping(PLATFORM).base, Carriers)


@pytest.mark.parametrize(('mapping', 'text'), [
    (changed(wheels=None), r'^wheels: is missing'),
    (changed(encoder=None), r'^encoder: is missing'),
    (changed(carriers=PLATFORM['carriers']), 'must not stand beside wheels'),
    (changed(wheels={'radius': [0.05, 0.05, 0.05]}), r'wheels\.radius.*one entry a wheel'),
    (changed(wheels={'joint': 'a'}), r'wheels\.joint.*list'),
    (changed(encoder={'sign': [1, -1]}), r'encoder\.sign.*one entry a wheel'),
    (changed(encoder={'sign': [1, 1, 1, 2]}), r'encoder\.sign\[3\] = 2: must be 1 or -1'),
    (changed(encoder={'counts_per_revolution': [1.0, 2.0]}), r'encoder\.counts_per_revolution'),
    (changed(encoder={'counter_bits': 24}), 'must be one of 16, 32, 64'),
    (changed(imu={'xyz': [0.0, 0.0]}), r'imu\.xyz.*three'),
    (changed(goal={'stop_radius': 3.0}), r'goal\.stop_radius.*below slow_radius'),
    (changed(wheels={'raduis': [1.0]}), r"wheels\.raduis.*did you mean 'radius'"),
    (changed(odom_frame_id=3), 'odom_frame_id = 3: must be a text'),
    (changed(enable_odom_tf='yes'), 'must be true or false')])
def test_a_wrong_robot_is_refused_by_name(mapping, text):
    with pytest.raises(ConfigError, match=text):
        Robot.from_mapping(mapping)


@pytest.mark.parametrize(('wrong', 'right'), [('encodr', 'encoder'), ('wheel', 'wheels'),
                                              ('Wheels', 'wheels')])
def test_a_misspelled_block_is_pointed_at(wrong, right):
    mapping = changed()
    mapping[wrong] = mapping.pop(right)
    with pytest.raises(ConfigError, match=f"^{wrong}: unknown block.*did you mean '{right}'"):
        Robot.from_mapping(mapping)


def test_a_misspelled_carriers_block_is_pointed_at():
    mapping = changed(PLATFORM)
    mapping['cariers'] = mapping.pop('carriers')
    with pytest.raises(ConfigError, match="^cariers: unknown block.*did you mean 'carriers'"):
        Robot.from_mapping(mapping)


def test_other_top_level_keys_are_ignored_by_name_or_refused_when_strict():
    mapping = changed(controller_server={'a': 1}, qos_overrides={})
    assert Robot.from_mapping(mapping).ignored == ('controller_server', 'qos_overrides')
    with pytest.raises(ConfigError, match='controller_server.*unknown key'):
        Robot.from_mapping(mapping, strict=True)


def test_a_base_that_cannot_turn_is_refused():
    square = {'x': [0.2, 0.2, -0.2, -0.2], 'y': [0.2, -0.2, 0.2, -0.2],
              'roller': [-0.785398163397448, 0.785398163397448, 0.785398163397448,
                         -0.785398163397448]}
    with pytest.raises(GeometryError, match='rank 2 of 3'):
        Robot.from_mapping(changed(wheels=square))


def test_replacing_a_block_leaves_the_others():
    robot = Robot.from_mapping(MECANUM)
    other = robot.replace(ignored=('x',))
    assert other.ignored == ('x',) and other.base is robot.base


def test_every_parameter_has_a_meaning():
    found = all_rules()
    assert {name.split('.')[0] for name in found if '.' in name} == set(BLOCKS)
    assert 'odom_frame_id' in found and all(rule.meaning for rule in found.values())
