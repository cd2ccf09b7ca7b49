"""The robot file as ROS 2 parameters: declared, described, validated, changed, dumped."""

import pathlib

import pytest
import rclpy
import yaml
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.context import Context
from rclpy.parameter import Parameter, parameter_value_to_python

from mecanum_base import robot_file
from mecanum_base.core.errors import ConfigError
from mecanum_base.robot import all_rules
from mecanum_base.ros.parameters import changed, nested, overrides
from mecanum_base.ros.robot_node import RobotNode
from mecanum_base.ros.scripted import Script, parameter

CARRIERS = yaml.safe_load("""
carriers:
  name: [front, rear]
  x: [0.3, -0.3]
  y: [0, 0]
  axle_offset: [-0.1, -0.1]
  half_track: [0.12, 0.12]
  wheel_radius: [0.05, 0.05]
  left_joint: [a, b]
  right_joint: [c, d]
encoder: {counts_per_revolution: 4096}
""")


class Noting(RobotNode):
    """Notes what it was told."""

    def __init__(self, **options):
        self.configured, self.refused = [], []
        super().__init__('noting', **options)

    def configure(self, robot):
        self.configured.append(robot)

    def refuse(self, reason):
        self.refused.append(reason)


@pytest.fixture
def script():
    with Script() as made:
        yield made


def make(script, robot, **parameters):
    return script.add(Noting, robot=robot, parameters=parameters)


def test_every_parameter_of_the_robot_is_declared_with_its_meaning(script, robot_path):
    node = make(script, robot_path)
    for name, rule in all_rules().items():
        assert node.has_parameter(name) == (not name.startswith('carriers.')), name
        if node.has_parameter(name):
            shown = node.describe_parameter(name)
            assert rule.meaning in shown.description and rule.unit in shown.description, name
            assert shown.read_only == (not rule.live), name
            if rule.choices:
                assert all(choice in shown.description for choice in rule.choices), name


def test_values_and_defaults_are_those_of_the_robot(script, robot_path):
    node = make(script, robot_path, **{'drive.clock_timeout': 1.0})  # scripts set it to 0
    robot = robot_file.load_robot(robot_path)
    assert list(node.get_parameter('wheels.radius').value) == list(robot.base.radius)
    assert node.get_parameter('drive.rate').value == robot.drive.rate
    assert node.get_parameter('odom_frame_id').value == 'odom'
    assert list(node.get_parameter('drive.max_velocity').value) == []  # no limit
    assert changed(node.robot, robot) == ()


def test_a_range_with_two_ends_is_declared_as_a_range(script, robot_path):
    node = make(script, robot_path)
    bounds = node.describe_parameter('drive.rate').floating_point_range[0]
    assert (bounds.from_value, bounds.to_value) == (1.0, 1000.0)
    assert 'must be > 0' in node.describe_parameter('wheels.radius').additional_constraints


def test_whole_numbers_are_taken_where_floats_are_meant(script):
    node = make(script, CARRIERS, **{'drive.rate': 20})
    assert list(node.robot.base.y) == [0.0, 0.0]
    assert node.robot.encoder.counts_per_revolution == 4096.0
    assert node.robot.drive.rate == 20.0
    assert node.set_parameters([parameter('drive.rate', 30)])[0].successful
    assert node.robot.drive.rate == 30.0


def test_a_robot_on_carriers_has_no_wheel_parameters(script):
    node = make(script, CARRIERS)
    assert node.has_parameter('carriers.axle_offset') and not node.has_parameter('wheels.x')


@pytest.mark.parametrize(('name', 'value', 'message'), [
    ('drive.rat', 20.0, "drive.rat = 20.0: unknown key, did you mean 'rate'?"),
    ('wheels.radii', [0.05], "did you mean 'radius'?"),
    ('wheels.radius', [0.05, 0.0, 0.05, 0.05], 'wheels.radius[1] = 0.0: must be > 0 [m]'),
    ('wheels.radius', [0.05, 0.05], 'wheels.radius = [0.05, 0.05]: must have one entry a wheel'),
    ('drive.rate', 'fast', "drive.rate = 'fast': must be a number [Hz]"),
    ('drive.cmd_vel_type', 'twists', 'must be one of auto, twist, twist_stamped'),
    ('encoder.sign', [1, 1, 0, 1], 'encoder.sign[2] = 0: must be 1 or -1'),
    ('drive.command_joints', ['a', 'b'], 'must name every wheel once'),
    ('drive', 7, 'drive = 7: must be a block'),
])
def test_a_broken_rule_is_named_with_key_value_and_rule(script, robot_path, name, value, message):
    with pytest.raises(ConfigError) as error:
        make(script, robot_path, **{name: value})
    assert message in str(error.value)


def test_a_missing_geometry_value_is_an_error(script, robot_path):
    mapping = robot_file.read_parameters(robot_path)
    del mapping['wheels']['x']
    with pytest.raises(ConfigError, match=r'wheels\.x: is missing and has no default.*\[m\]'):
        make(script, mapping)


def test_foreign_blocks_get_one_warning_and_those_of_ros_none(script, robot_path, capfd):
    make(script, robot_path, **{'controller_server.frequency': 20.0, 'amcl.alpha1': 0.2,
                                'controller_server.plugin': 'x',
                                'qos_overrides./odom.publisher.depth': 5})
    log = capfd.readouterr()
    text = log.out + log.err
    assert text.count('ignored') == 1
    assert 'controller_server, amcl, qos_overrides' in text and 'use_sim_time' not in text


def test_accepted_changes_arrive_together_and_once(script, robot_path):
    node = make(script, robot_path)
    result = node.set_parameters_atomically([
        parameter('drive.max_velocity', [1.0, 0.5, 2.0]), parameter('drive.command_timeout', 0.3)])
    assert result.successful
    assert len(node.configured) == 1
    new = node.configured[0].drive
    assert list(new.max_velocity) == [1.0, 0.5, 2.0] and new.command_timeout == 0.3
    assert node.robot is node.configured[0]


def test_one_bad_value_refuses_all_of_an_atomic_change(script, robot_path):
    node = make(script, robot_path)
    result = node.set_parameters_atomically([
        parameter('drive.command_timeout', 0.3), parameter('drive.max_jerk', [1.0, -1.0, 1.0])])
    assert not result.successful and 'drive.max_jerk[1] = -1.0: must be > 0' in result.reason
    assert node.configured == [] and len(node.refused) == 1
    assert node.get_parameter('drive.command_timeout').value == 0.5
    assert node.robot.drive.command_timeout == 0.5


@pytest.mark.parametrize(('name', 'value', 'reason'), [
    ('wheels.radius', [0.06] * 4, 'read-only parameter: wheels.radius'),
    ('drive.rate', 0.5, 'drive.rate'),
    ('drive.rate', float('nan'), 'must be finite'),
    ('drive.limit_shape', 'round', 'must be one of ellipse, box'),
    ('drive.keep_yaw', 1, 'drive.keep_yaw'),
    ('drive.max_velocity', None, 'cannot be unset'),
])
def test_a_refused_change_has_a_reason_and_is_told_to_the_node_once(
        script, robot_path, name, value, reason):
    node = make(script, robot_path)
    before = node.get_parameter(name).value
    result = node.set_parameters([Parameter(name, value=value)])[0]
    assert not result.successful
    assert reason in result.reason or reason in node.refused[0]
    assert len(node.refused) == 1 and node.configured == []
    assert node.has_parameter(name) and node.get_parameter(name).value == before


def test_a_list_can_be_emptied_while_the_node_runs(script, robot_path):
    node = make(script, robot_path)
    assert node.set_parameters([parameter('drive.max_jerk', [])])[0].successful
    assert not any(map(lambda v: v < float('inf'), node.robot.drive.max_jerk))


def test_an_unknown_name_is_answered_with_the_nearest_one(script, robot_path):
    node = make(script, robot_path)
    value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=1.0)
    changes = [ParameterMessage(name='drive.max_velocty', value=value)]
    one = script.call(SetParameters, 'noting/set_parameters',
                      SetParameters.Request(parameters=changes)).results[0]
    whole = script.call(SetParametersAtomically, 'noting/set_parameters_atomically',
                        SetParametersAtomically.Request(parameters=changes)).result
    for result in (one, whole):
        assert not result.successful
        assert "did you mean 'drive.max_velocity'?" in result.reason
    assert len(node.refused) == 2


def test_simulated_time_can_still_be_switched(script, robot_path):
    node = make(script, robot_path)
    assert node.set_parameters([parameter('use_sim_time', False)])[0].successful
    assert node.configured == []


def dumped(node):
    """What ``ros2 param dump`` writes: nested values below the node's name."""
    tree = {}
    for name in node.list_parameters([], 0).names:
        *blocks, key = name.split('.')
        branch = tree
        for block in blocks:
            branch = branch.setdefault(block, {})
        value = parameter_value_to_python(node.get_parameter(name).get_parameter_value())
        branch[key] = list(value) if hasattr(value, 'typecode') else value
    return yaml.dump({'/noting': {'ros__parameters': tree}}, default_flow_style=False)


@pytest.mark.parametrize('source', ['file', 'carriers'])
def test_a_dump_of_all_parameters_loads_again(script, robot_path, tmp_path, source):
    node = make(script, robot_path if source == 'file' else CARRIERS,
                **{'drive.max_jerk': [9.0, 9.0, 20.0]})
    dump = pathlib.Path(tmp_path, 'dump.yaml')
    dump.write_text(dumped(node))
    context = Context()
    rclpy.init(args=['--ros-args', '--params-file', str(dump)], context=context)
    try:
        again = Noting(context=context)
        assert changed(again.robot, node.robot) == ()
        assert list(again.robot.drive.max_jerk) == [9.0, 9.0, 20.0]
        again.destroy_node()
    finally:
        rclpy.try_shutdown(context=context)


def test_blocks_are_made_from_full_names():
    values = {'wheels.x': [1.0], 'odom_frame_id': 'o', 'a.b.c': 1, 'use_sim_time': True,
              'drive.max_jerk': None}  # None = []
    assert nested(values) == {'wheels': {'x': [1.0]}, 'odom_frame_id': 'o', 'a': {'b.c': 1},
                              'drive': {'max_jerk': []}}


def test_overrides_of_a_mapping_keep_lists_of_one_type():
    made = {p.name: p for p in overrides({'wheels': {'x': [0, 0.2]}, 'n': 3}, drive__rate=20.0)}
    assert list(made['wheels.x'].value) == [0.0, 0.2]
    assert made['drive.rate'].value == 20.0 and made['n'].type_ == Parameter.Type.INTEGER
