import yaml

from mecanum_base.cli.main import main
from mecanum_base.robot_file import load_robot, shipped

CONTROLLER = """
mecanum_controller:
  ros__parameters:
    front_left_wheel_command_joint_name: fl
    front_right_wheel_command_joint_name: fr
    rear_right_wheel_command_joint_name: rr
    rear_left_wheel_command_joint_name: rl
    kinematics: {wheels_radius: 0.05, sum_of_robot_center_projection_on_X_Y_axis: 0.35}
"""


def test_a_controller_file_becomes_a_robot_file_that_is_valid(tmp_path, capsys):
    source, target = tmp_path / 'controllers.yaml', tmp_path / 'robot.yaml'
    source.write_text(CONTROLLER, encoding='utf-8')
    words = ['check', '--from-controller', str(source), '--out', str(target)]
    assert main([*words, '--counts-per-revolution', '1024']) == 0
    assert 'lx + ly' in capsys.readouterr().err
    assert load_robot(target, strict=True).base.joint == ('fl', 'fr', 'rl', 'rr')
    assert main([*words, '--counts-per-revolution', '1024']) == 2  # never overwritten
    assert 'exists already' in capsys.readouterr().err


def test_without_counts_the_gap_is_a_finding_and_the_line_is_left_to_fill_in(tmp_path, capsys):
    source = tmp_path / 'controllers.yaml'
    source.write_text(CONTROLLER, encoding='utf-8')
    assert main(['check', '--from-controller', str(source)]) == 1
    assert '# counts_per_revolution:   <- fill in' in capsys.readouterr().out


def test_a_missing_sum_is_refused_with_its_name(tmp_path, capsys):
    source = tmp_path / 'controllers.yaml'
    document = yaml.safe_load(CONTROLLER)
    kinematics = document['mecanum_controller']['ros__parameters']['kinematics']
    del kinematics['sum_of_robot_center_projection_on_X_Y_axis']
    source.write_text(yaml.safe_dump(document), encoding='utf-8')
    assert main(['check', '--from-controller', str(source)]) == 2
    assert 'sum_of_robot_center_projection_on_X_Y_axis' in capsys.readouterr().err


def test_urdf_and_policy_are_written_beside_the_verdict(tmp_path, capsys):
    urdf, policy = tmp_path / 'robot.urdf', tmp_path / 'policy.xml'
    robot = str(shipped() / 'mecanum4.yaml')
    assert main(['check', robot, '--urdf', str(urdf), '--policy', str(policy)]) == 0
    assert 'front_left_wheel_joint' in urdf.read_text(encoding='utf-8')
    assert '<topic>cmd_vel_limited</topic>' in policy.read_text(encoding='utf-8')
    assert f'written: {urdf}' in capsys.readouterr().out


def test_every_parameter_is_listed_with_its_value_and_unit(capsys):
    assert main(['check', str(shipped() / 'mecanum4.yaml'), '--parameters']) == 0
    lines = {line.split()[0]: line for line in capsys.readouterr().out.splitlines() if line}
    assert '[0.05, 0.05, 0.05, 0.05]' in lines['wheels.radius']
    assert '[m]' in lines['wheels.radius']
    assert '(live)' in lines['drive.command_timeout']
    assert 'carriers.x' not in lines
