"""The launch file: complete wiring, checked with stand-ins, and with launch itself where it is.

The packages launch and launch_ros cannot be installed by pip, so stand-ins record what the file
builds; the last test uses the real ones on a machine that has them.
"""

import pathlib
import runpy
import sys
import types

import pytest

ROOT = pathlib.Path(__file__).parents[2]
FILE = ROOT / 'launch' / 'base.launch.py'


class Recorded:
    """Stands for any launch class: keeps its arguments."""

    def __init__(self, *arguments, **options):
        self.kind, self.arguments, self.options = type(self).__name__, arguments, options


def stand_in(names):
    return {name: type(name, (Recorded,), {}) for name in names}


@pytest.fixture
def description(monkeypatch):
    modules = {
        'launch': ['LaunchDescription'],
        'launch.actions': ['DeclareLaunchArgument', 'GroupAction'],
        'launch.conditions': ['IfCondition', 'UnlessCondition'],
        'launch.substitutions': ['LaunchConfiguration', 'PathJoinSubstitution'],
        'launch_ros': [],
        'launch_ros.actions': ['Node'],
        'launch_ros.substitutions': ['FindPackageShare'],
    }
    for name, classes in modules.items():
        module = types.ModuleType(name)
        vars(module).update(stand_in(classes))
        monkeypatch.setitem(sys.modules, name, module)
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


def nodes(description):
    return [one for one in everything(description) if one.kind == 'Node']


def test_every_argument_is_described_and_every_used_one_declared(description):
    declared = {one.arguments[0]: one.options for one in everything(description)
                if one.kind == 'DeclareLaunchArgument'}
    used = {one.arguments[0] for one in everything(description)
            if one.kind == 'LaunchConfiguration'}
    assert used == set(declared)
    assert {'robot', 'sim', 'namespace', 'record', 'rviz', 'foxglove'} <= set(declared)
    assert all(options['description'] for options in declared.values())


def test_every_own_executable_is_installed_by_setup(description):
    setup = (ROOT / 'setup.py').read_text()
    own = [one for one in nodes(description) if one.options['package'] == 'mecanum_base']
    assert len(own) == 6
    for one in own:
        executable = one.options['executable']
        assert f"'{executable.removesuffix('_node')}'" in setup, executable
        path = ROOT / 'src' / 'mecanum_base' / 'ros' / f'{executable}.py'
        assert 'def main(' in path.read_text()
        assert one.options['parameters'][0].arguments == ('robot',)
        assert one.options['namespace'].arguments == ('namespace',)


def test_parameters_given_by_the_launch_file_exist(description):
    from mecanum_base.robot import all_rules

    known = {*all_rules(), 'use_sim_time'}
    for one in nodes(description):
        for entry in one.options['parameters']:
            if isinstance(entry, dict):
                assert set(entry) <= known


def test_the_simulation_is_the_clock_and_never_follows_one(description):
    by_name = {one.options['executable']: one for one in nodes(description)}
    given = {key for entry in by_name['sim_node'].options['parameters'] if isinstance(entry, dict)
             for key in entry}
    assert given == {'sim.publish_clock'}


def test_the_default_robot_file_is_shipped(description):
    robot = next(one for one in everything(description) if one.kind == 'DeclareLaunchArgument'
                 and one.arguments[0] == 'robot')
    parts = robot.options['default_value'].arguments[0]
    assert parts[0].arguments == ('mecanum_base',)
    assert ROOT.joinpath(*parts[1:]).is_file()


def test_the_view_of_rviz_is_shipped(description):
    rviz = next(one for one in nodes(description) if one.options['executable'] == 'rviz2')
    flag, path = rviz.options['arguments']
    assert flag == '-d' and ROOT.joinpath(*path.arguments[0][1:]).is_file()


def test_the_real_launch_package_accepts_the_file():
    pytest.importorskip('launch_ros')
    built = runpy.run_path(str(FILE))['generate_launch_description']()
    assert len(built.entities) > 10
