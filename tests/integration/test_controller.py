import math

import numpy as np
import pytest
import yaml

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.integration.controller import find_controller, robot_from_controller
from mecanum_base.integration.robot_text import robot_text
from mecanum_base.robot import Robot
from mecanum_base.robot_file import parse_parameters

CONTROLLER = """
controller_manager:
  ros__parameters: {update_rate: 100}
platform_velocity_controller:
  ros__parameters:
    front_left_wheel_command_joint_name: fl
    front_right_wheel_command_joint_name: fr
    rear_right_wheel_command_joint_name: rr
    rear_left_wheel_command_joint_name: rl
    reference_timeout: 0.1
    kinematics:
      base_frame_offset: {x: 0.0, y: 0.0, theta: 0.0}
      wheels_radius: 0.0759
      sum_of_robot_center_projection_on_X_Y_axis: 0.59
    base_frame_id: base_footprint
"""


def controller(**kinematics):
    name, parameters = find_controller(yaml.safe_load(CONTROLLER))
    assert name == 'platform_velocity_controller'
    parameters['kinematics'] = {**parameters['kinematics'], **kinematics}
    return parameters


def upstream_rates(parameters, vx, vy, wz):
    """Wheel rates by upstream's own printed formula, in the order FL, FR, RL, RR."""
    kinematics = parameters['kinematics']
    offset, r = kinematics['base_frame_offset'], kinematics['wheels_radius']
    k = kinematics['sum_of_robot_center_projection_on_X_Y_axis']
    c, s = math.cos(offset['theta']), math.sin(offset['theta'])
    cx = c * vx - s * vy + offset['y'] * wz
    cy = s * vx + c * vy - offset['x'] * wz
    return np.array([cx - cy - k * wz, cx + cy + k * wz, cx + cy - k * wz, cx - cy + k * wz]) / r


@pytest.mark.parametrize('offset', [(0.0, 0.0, 0.0), (0.1, -0.05, 0.0), (0.07, 0.2, 0.6)])
def test_the_converted_robot_turns_its_wheels_as_the_controller_did(offset):
    parameters = controller(base_frame_offset=dict(zip(('x', 'y', 'theta'), offset)))
    mapping, _ = robot_from_controller(parameters, counts_per_revolution=4096.0)
    robot = Robot.from_mapping(mapping)
    for twist in ([0.3, 0.0, 0.0], [0.0, 0.4, 0.0], [0.0, 0.0, 1.1], [0.2, -0.3, 0.7]):
        assert wheels_from_body(robot.base) @ twist == pytest.approx(
            upstream_rates(parameters, *twist), abs=1e-9)


def test_the_written_file_loads_again_and_says_what_is_missing():
    mapping, warnings = robot_from_controller(controller())
    text = robot_text(mapping, ['converted'])
    assert any('counts_per_revolution' in w for w in warnings)
    assert any('lx + ly' in w for w in warnings)
    with pytest.raises(ConfigError, match='encoder.counts_per_revolution'):
        Robot.from_mapping(parse_parameters(text, 'robot.yaml'))
    mapping, warnings = robot_from_controller(controller(), counts_per_revolution=1024.0)
    robot = Robot.from_mapping(parse_parameters(robot_text(mapping), 'robot.yaml'), strict=True)
    assert robot.base.joint == ('fl', 'fr', 'rl', 'rr')
    assert robot.frames.base_frame_id == 'base_footprint'
    assert robot.base.radius.tolist() == [0.0759] * 4


@pytest.mark.parametrize('key', ['wheels_radius', 'sum_of_robot_center_projection_on_X_Y_axis'])
def test_a_zero_that_the_controller_would_divide_by_is_refused(key):
    with pytest.raises(ConfigError, match=key):
        robot_from_controller(controller(**{key: 0.0}))


def test_a_file_without_a_mecanum_controller_is_refused():
    with pytest.raises(ConfigError, match='mecanum_drive_controller'):
        find_controller({'controller_manager': {'ros__parameters': {}}})
