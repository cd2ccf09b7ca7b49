"""The launch file: complete wiring, checked with stand-ins, and with launch itself where it is.

The packages launch and launch_ros cannot be installed by pip, so stand-ins work out what the file
would start; the last test uses the real ones on a machine that has them.
"""

import pathlib
import re
import runpy
import sys
import time

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from launch_stand_ins import FILE, ROOT, description, everything, processes

OWN = ('drive_node', 'odometry_node')


@pytest.fixture(scope='module')
def built():
    return description()


def nodes(built):
    return [one for one in everything(built) if one.kind == 'Node']


def names(found):
    return [one.executable for one in found]


def test_every_argument_is_described_and_every_used_one_declared(built):
    declared = {one.arguments[0]: one.options for one in everything(built)
                if one.kind == 'DeclareLaunchArgument'}
    used = {one.arguments[0] for one in everything(built) if one.kind == 'LaunchConfiguration'}
    assert used == set(declared)
    assert {'robot', 'sim', 'namespace', 'record', 'rviz', 'foxglove'} <= set(declared)
    assert all(options['description'] for options in declared.values())


def test_the_guide_lists_exactly_the_arguments_with_their_defaults(built):
    guide = (ROOT / 'docs' / 'integration.md').read_text(encoding='utf-8')
    table = guide.split('## Launch file')[1].split('## ')[0]
    shown = dict(re.findall(r'^\| `(\w+)` \| ([^|]+?) \|', table, flags=re.M))
    declared = {one.arguments[0]: one.options['default_value'] for one in everything(built)
                if one.kind == 'DeclareLaunchArgument'}
    assert set(shown) == set(declared)
    for name, default in declared.items():
        if isinstance(default, str):
            assert shown[name] == (default or 'empty'), name
        else:
            assert default.arguments[0][-1] in shown[name]


def test_every_own_executable_is_installed_by_setup(built):
    setup = (ROOT / 'setup.py').read_text()
    own = [one for one in nodes(built) if one.options['package'] == 'mecanum_base']
    assert len(own) == 6
    for one in own:
        executable = one.options['executable']
        assert f"'{executable.removesuffix('_node')}'" in setup, executable
        path = ROOT / 'src' / 'mecanum_base' / 'ros' / f'{executable}.py'
        assert 'def main(' in path.read_text()
        assert one.options['parameters'][0].arguments == ('robot',)
        assert one.options['namespace'].arguments == ('namespace',)


def test_parameters_given_by_the_launch_file_exist(built):
    from mecanum_base.robot import all_rules

    known = {*all_rules(), 'use_sim_time'}
    for one in nodes(built):
        for entry in one.options['parameters']:
            if isinstance(entry, dict):
                assert set(entry) <= known


def test_without_arguments_it_drives_the_shipped_robot(built):
    found = processes(built)
    assert names(found) == list(OWN)
    for one in found:
        path = pathlib.Path(one.words[one.words.index('--params-file') + 1])
        assert path == ROOT / 'config' / 'mecanum4.yaml' and path.is_file()
        assert one.options == {'respawn': 'false'}


@pytest.mark.parametrize('given,expected', [
    ({'sim': 'true', 'goal': 'true'}, [*OWN, 'sim_node', 'goal_node']),
    ({'composed': 'true', 'record': 'true'}, ['base_node', 'record_node']),
    ({'rviz': 'true', 'foxglove': 'true'}, [*OWN, 'rviz2', 'foxglove_bridge'])])
def test_arguments_choose_what_is_started(built, given, expected):
    assert names(processes(built, **given)) == expected


def test_namespace_robot_and_respawn_reach_the_nodes(built):
    for one in processes(built, namespace='one', robot='mine.yaml', respawn='true'):
        assert one.words[one.words.index('-r') + 1] == '__ns:=/one'
        assert one.words[one.words.index('--params-file') + 1] == 'mine.yaml'
        assert one.options == {'respawn': 'true'}


def test_viewers_get_the_shipped_view_and_the_clock(built):
    rviz, bridge = processes(built, rviz='true', foxglove='true', use_sim_time='true')[-2:]
    assert rviz.words[0] == '-d' and pathlib.Path(rviz.words[1]).is_file()
    assert 'use_sim_time:=true' in rviz.words and 'use_sim_time:=true' in bridge.words


def test_the_simulation_is_the_clock_and_never_follows_one(built):
    sim = processes(built, sim='true', use_sim_time='true')[-1]
    assert sim.executable == 'sim_node'
    assert 'sim.publish_clock:=true' in sim.words
    assert not [word for word in sim.words if word.startswith('use_sim_time')]


def test_what_it_starts_drives_in_simulated_time(built):
    """The nodes with the very arguments that launch would give them, in one process."""
    pytest.importorskip('rclpy')
    from geometry_msgs.msg import Twist, Vector3
    from nav_msgs.msg import Odometry

    from mecanum_base.ros.base_node import node_class
    from mecanum_base.ros.scripted import Script
    with Script() as script:
        steer, odom = script.publisher(Twist, 'one/cmd_vel'), script.listen(Odometry, 'one/odom')
        for one in processes(built, sim='true', use_sim_time='true', namespace='one'):
            node = script.add(node_class(one.executable.removesuffix('_node')), words=one.words)
            assert node.get_namespace() == '/one'
        script.connect()
        last = 0.0

        def arrived():
            nonlocal last
            if time.monotonic() - last > 0.05:
                last = time.monotonic()
                steer.publish(Twist(linear=Vector3(x=0.4)))
            return odom and odom[-1].pose.pose.position.x > 0.05

        script.wait_for(arrived, 'odometry to move', 30.0)


def test_the_real_launch_package_accepts_the_file():
    pytest.importorskip('launch_ros')
    real = runpy.run_path(str(FILE))['generate_launch_description']()
    assert len(real.entities) > 10
