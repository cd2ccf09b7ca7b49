"""Life of a node process: usage errors, bad files, help, several nodes, exit codes."""

import signal

import pytest
from geometry_msgs.msg import Twist
from rclpy.node import Node

from mecanum_base.core.errors import ConfigError
from mecanum_base.ros import process

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def refused(capsys, *words):
    """(exit code, last line of standard error) of a drive node that must not start."""
    from mecanum_base.ros import drive_node

    handlers = [signal.getsignal(number) for number in SIGNALS]
    code = drive_node.main(list(map(str, words)))
    assert [signal.getsignal(number) for number in SIGNALS] == handlers
    return code, capsys.readouterr().err.strip().splitlines()[-1]


def test_a_list_that_mixes_0_and_fractions_is_named_with_line_and_cure(capsys, tmp_path):
    path = tmp_path / 'robot.yaml'
    path.write_text('/**:\n  ros__parameters:\n    wheels:\n      x: [0.2, 0.2, 0, 0]\n')
    code, line = refused(capsys, '--ros-args', '--params-file', path)
    assert code == 2
    assert line.startswith(f'drive_node: {path}, line 4,')
    assert 'wheels.x[2]' in line and 'write 0.0' in line


def test_a_mixed_list_on_the_command_line_is_named_too():
    with pytest.raises(ConfigError, match=r'-p drive.max_jerk.*write 1\.0'):
        process.check_arguments(['--ros-args', '-p', 'drive.max_jerk:=[1, 0.5, 1]'])


def test_a_file_that_cannot_be_read_or_is_no_yaml_is_named(capsys, tmp_path):
    code, line = refused(capsys, '--ros-args', '--params-file', tmp_path / 'none.yaml')
    assert code == 2 and 'none.yaml' in line and 'No such file' in line
    path = tmp_path / 'bad.yaml'
    path.write_text('/**: {ros__parameters: [')
    code, line = refused(capsys, '--ros-args', '--params-file', path)
    assert code == 2 and 'bad.yaml, line 1' in line and 'not valid YAML' in line


def test_a_node_without_a_robot_says_what_is_missing(capsys):
    code, line = refused(capsys)
    assert code == 2
    assert line == 'drive_node: wheels: is missing and has no default: the wheel table'


def test_arguments_that_ros_refuses_are_one_line_too(capsys):
    code, line = refused(capsys, '--ros-args', '--remap', 'no-remap-rule')
    assert code == 2 and line.startswith('drive_node: ')


def test_unknown_words_are_wrong_usage(capsys):
    with pytest.raises(SystemExit) as end:
        process.run(Node, ['--robots', 'x.yaml', '--ros-args', '-p', 'a:=1', '--', 'more'])
    assert end.value.code == 2
    assert 'unrecognized arguments: --robots x.yaml more' in capsys.readouterr().err


def test_help_shows_topics_and_an_example(capsys):
    from mecanum_base.ros import drive_node

    with pytest.raises(SystemExit) as end:
        drive_node.main(['--help'])
    shown = capsys.readouterr().out
    assert end.value.code == 0
    assert 'cmd_vel_limited' in shown and 'ros2 run mecanum_base drive_node' in shown


def test_a_hangup_that_is_ignored_on_purpose_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with process._signals() as stop:
            signal.raise_signal(signal.SIGHUP)
            assert stop.reason == ''
            signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGINT)
            assert stop.reason == 'received SIGTERM'  # the first one counts
    finally:
        signal.signal(signal.SIGHUP, before)


SEVERAL = """
import sys
from rclpy.node import Node
from mecanum_base.ros import process
from mecanum_base.ros.drive_node import DriveNode
class Beside(Node):
    def __init__(self):
        super().__init__('beside')
        self.create_timer(0.05, lambda: print('beside is alive', flush=True))
sys.exit(process.run([DriveNode, Beside], sys.argv[1:], commands_wheels=True))
"""


def test_several_nodes_share_a_process_and_end_together(outside, start, robot_path):
    running = start('-c', SEVERAL, '--ros-args', '--params-file', robot_path)
    steer = outside.node.create_publisher(Twist, 'cmd_vel', 10)
    outside.until(lambda: steer.get_subscription_count() == 1, 'the drive node')
    outside.wait(0.2)
    running.send(signal.SIGTERM)
    assert running.finish() == 0
    assert 'beside is alive' in running.output
