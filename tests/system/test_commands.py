"""Every command that README and docs show is run: shortened, or by what it stands for.

`mecanum ...` runs in a folder that holds what the text assumes (robot.yaml, recordings ...).
Nodes, also behind `ros2 run` and `ros2 launch`, are made in this process from the very words of
the command. `ros2 topic`, `param` and `service`, which pip cannot install, are read and done with
rclpy. What is proven elsewhere is listed in ELSEWHERE; an unknown command fails.
"""

import importlib
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import time

import pytest
import yaml

pytest.importorskip('rclpy')
pytest.importorskip('rosbags')

from geometry_msgs.msg import Point, Twist
from nav_msgs.msg import Odometry
from std_srvs.srv import SetBool

from mecanum_base.cli.main import main
from mecanum_base.cli.verbs import VERBS
from mecanum_base.ros import base_node, drive_node, process
from mecanum_base.ros.base_node import node_class
from mecanum_base.ros.scripted import Script, parameter

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / 'launch'))
from launch_stand_ins import description, processes

ROOT = pathlib.Path(__file__).resolve().parents[2]
if not (ROOT / 'README.md').is_file():
    pytest.skip('the README is not installed', allow_module_level=True)

SHORTER = {  # added to a command, so that it takes a moment
    'mecanum sim --scenario oil --out oil_run': ['--duration', '1.0'],
    'mecanum sim --gallery --out gallery': ['--scenario', 'standing', '--duration', '1.0'],
    # two jobs: the pool is proven in tests/bag/test_analyze_command.py
    'mecanum analyze run2 --robot robot.yaml --compare better.yaml --out both': ['--workers', '1'],
}
FINDINGS = ('mecanum analyze ', 'mecanum doctor ', 'mecanum calibrate ',
            'mecanum check --from-controller ')  # may end with 1: there is something to say
ELSEWHERE = {
    r'make ': '.ci/run: make demo, make test',
    r'colcon build --packages-select mecanum_base$': '.ci/run: colcon build',
    r'\. \.venv/bin/activate$': '.ci/setup_venv.py: -m',
    r'export ROS_AUTOMATIC_DISCOVERY_RANGE=': 'tests/ros/conftest.py: SYSTEM_DEFAULT',
    r'export FASTRTPS_DEFAULT_PROFILES_FILE=': 'tests/ros/conftest.py: fastdds_udp.xml',
    r'dask (scheduler|worker tcp://host:8786)$': 'tests/bag/test_findings.py: scheduler_address',
    r'mecanum analyze .*--scheduler': 'tests/bag/test_findings.py: scheduler_address',
    # needs recordings of others, which are not in this project
    r'python tools/to_mcap.py ': 'tests/bench/recordings_table.py: to_mcap.py',
}
CONTROLLERS = """
mecanum_controller:
  ros__parameters:
    front_left_wheel_command_joint_name: fl
    front_right_wheel_command_joint_name: fr
    rear_right_wheel_command_joint_name: rr
    rear_left_wheel_command_joint_name: rl
    kinematics: {wheels_radius: 0.05, sum_of_robot_center_projection_on_X_Y_axis: 0.35}
"""


def shown(path):
    """Commands of the shell blocks and `mecanum ...` in the text of a Markdown file."""
    text = path.read_text(encoding='utf-8')
    for block in re.findall(r'```sh\n(.*?)```', text, flags=re.S):
        for line in block.replace('\\\n', ' ').splitlines():
            line = line.split(' #')[0].strip().removesuffix('&').strip()
            if line and not line.startswith('#'):
                yield line
    prose = re.sub(r'```.*?```', '', text, flags=re.S)
    for command in re.findall(r'`(mecanum [a-z][^`|]*)`', prose):
        if len(command.split()) > 2:  # `mecanum roller` only names a verb
            yield command


COMMANDS = sorted({command for path in (ROOT / 'README.md', *sorted((ROOT / 'docs').glob('*.md')))
                   for command in shown(path)})


@pytest.fixture(scope='module')
def assumed(tmp_path_factory):
    """A folder with everything the texts assume."""
    folder = tmp_path_factory.mktemp('user')
    shutil.copytree(ROOT / 'config', folder / 'config')
    shutil.copy(ROOT / 'config' / 'mecanum4.yaml', folder / 'robot.yaml')
    (folder / 'controllers.yaml').write_text(CONTROLLERS, encoding='utf-8')
    assert main(['sim', '--scenario', 'square', '--duration', '8', '--out',
                 str(folder / 'made')]) == 0
    shutil.move(folder / 'made' / 'bag', folder / 'run1')
    shutil.copy(next((folder / 'run1').glob('*.mcap')), folder / 'FILE')
    shutil.copytree(folder / 'run1', folder / 'run2')
    shutil.copytree(folder / 'run1', folder / 'run' / 'bag')  # as docs/recordings.md has it
    shutil.copy(ROOT / 'config' / 'mecanum4.yaml', folder / 'run' / 'robot.yaml')
    shutil.copy(ROOT / 'config' / 'mecanum4.yaml', folder / 'better.yaml')
    return folder


@pytest.fixture
def workspace(assumed, tmp_path, monkeypatch):
    """A copy of it, as the current folder."""
    folder = shutil.copytree(assumed, tmp_path / 'user')
    monkeypatch.chdir(folder)
    return folder


def remove_output(words):
    """Nothing is overwritten, so what a command writes must not be there yet."""
    for option, value in zip(words, words[1:]):
        if option in ('--out', '--output'):
            path = pathlib.Path(value)
            if path.is_dir():
                shutil.rmtree(path)
            path.unlink(missing_ok=True)


@pytest.fixture
def captured(monkeypatch):
    """(node classes, their words) of the node processes that a command would run."""
    found = []

    def note(factory, words=None, **_options):
        factories = factory if isinstance(factory, (list, tuple)) else [factory]
        found.extend((one, list(words or [])) for one in factories)
        return 0

    for module in (process, drive_node, base_node):
        monkeypatch.setattr(module, 'run', note)
    return found


def without_end_mark(words):
    """The words of one command line as rclpy takes them, `--` between two groups included."""
    return ['--ros-args', *words] if words and words[0] == '-p' else words


def run_nodes(found):
    """Make the nodes and let them work for a moment; topics they have."""
    assert found
    with Script() as script:
        for make, words in found:
            node = script.add(make, words=without_end_mark(words))
            script.wait_for(lambda: True, 'nothing')
            script.settle()
            yield node


def run_mecanum(command, captured):
    words = shlex.split(command)[1:]
    remove_output(words)
    code = main(words + SHORTER.get(command, []))
    assert code == 0 or (code == 1 and re.sub(' +', ' ', command).startswith(FINDINGS)), command
    for node in run_nodes(captured) if captured else ():
        assert node.get_name().endswith('_node')


def run_ros2_run(command):
    words = shlex.split(command)[2:]
    assert words[0] == 'mecanum_base'
    remapped = dict(re.findall(r'-r (\S+?):=(\S+)', command))
    for node in run_nodes([(node_class(words[1].removesuffix('_node')), words[2:])]):
        name = node.get_name()
        topics = {topic for ask in (node.get_publisher_names_and_types_by_node,
                                    node.get_subscriber_names_and_types_by_node)
                  for topic, _ in ask(name, '/')}
        assert set(remapped.values()) <= topics
        assert not {f'/{before}' for before in remapped} & topics


def run_ros2_launch(command):
    package, file, *given = shlex.split(command)[2:]
    assert package == 'mecanum_base' and (ROOT / 'launch' / file).is_file()
    found = processes(description(), **dict(word.split(':=', 1) for word in given))
    own = [one for one in found if one.package == 'mecanum_base']
    assert own
    for _ in run_nodes([(node_class(one.executable.removesuffix('_node')), one.words)
                        for one in own]):
        pass


def run_pip(command):
    extra = re.search(r"'mecanum_base\[(\w+)\]'", command)
    assert extra and f"'{extra[1]}':" in (ROOT / 'setup.py').read_text(encoding='utf-8')


def run_script(command):
    """A program of this project that needs data: its words are checked against its help."""
    words = shlex.split(command)[1:]
    helped = subprocess.run([sys.executable, ROOT / words[0], '--help'], capture_output=True,
                            text=True, timeout=120)
    assert helped.returncode == 0
    assert all(word in helped.stdout for word in words if word.startswith('--'))


def run_docker(command):
    """No engine is within reach: files, profiles and the words for `mecanum` are checked."""
    words = shlex.split(command)
    if words[1] == 'compose':
        services = yaml.safe_load((ROOT / words[3]).read_text())['services']
        profile = words[words.index('--profile') + 1]
        chosen = [one for one in services.values() if profile in one['profiles']]
        assert len(chosen) >= 2
    elif words[1] == 'build':
        assert (ROOT / words[words.index('-f') + 1]).is_file()
    else:
        verb = words[words.index('mecanum_base') + 1:]
        helped = subprocess.run([sys.executable, '-m', 'mecanum_base', verb[0], '--help'],
                                capture_output=True, text=True, timeout=60)
        assert all(word in helped.stdout for word in verb if word.startswith('--'))


def fill(message, values):
    """A message from the dictionary that the command line gives."""
    for name, value in values.items():
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        else:
            kind = type(getattr(message, name))
            setattr(message, name, kind(value))
    return message


def is_talk(command):
    return re.match(r'ros2 (topic|param|service) ', command)


def command_of(start):
    found, = [command for command in COMMANDS if command.startswith(start)]
    return shlex.split(found)


@pytest.mark.parametrize('command', [c for c in COMMANDS if not is_talk(c)])
def test_a_command_of_the_texts_works(command, workspace, captured):
    for pattern, place in ELSEWHERE.items():
        if re.match(pattern, command):
            file, _, text = place.partition(': ')
            words = (ROOT / file).read_text(encoding='utf-8')
            assert all(part in words for part in text.split(', '))
            if command.startswith('make '):
                subprocess.run(['make', '-n', command.split()[1]], cwd=ROOT, check=True,
                               capture_output=True, timeout=60)
            return
    if command.startswith('mecanum '):
        run_mecanum(command, captured)
    elif command.startswith('ros2 run '):
        run_ros2_run(command)
    elif command.startswith('ros2 launch '):
        run_ros2_launch(command)
    elif command.startswith('pip install '):
        run_pip(command)
    elif command.startswith('docker '):
        run_docker(command)
    elif command.startswith('python '):
        run_script(command)
    else:
        pytest.fail(f'no test knows how to run: {command}')


def test_the_drive_it_block_moves_the_base(captured, workspace):
    """sim, drive and odometry as the README starts them, topic pub and echo as it types them."""
    publish, echo = command_of('ros2 topic pub'), command_of('ros2 topic echo')
    assert publish[2:6] == ['pub', '-r', '10', '/cmd_vel']
    assert publish[6] == 'geometry_msgs/msg/Twist'
    twist = fill(Twist(), yaml.safe_load(publish[7]))
    assert echo[2:] == ['echo', '/odom', '--field', 'pose.pose.position']
    for verb in ('sim', 'drive', 'odometry'):
        assert main(shlex.split(f'{verb} --robot config/mecanum4.yaml')) == 0
    assert {f'mecanum {verb} --robot config/mecanum4.yaml' for verb in
            ('drive', 'odometry')} <= {re.sub(r' +', ' ', command) for command in COMMANDS}
    with Script() as script:
        steer = script.publisher(Twist, publish[5].lstrip('/'))
        odom = script.listen(Odometry, echo[3].lstrip('/'))
        for make, words in captured:
            script.add(make, words=words)
        script.connect()
        due = time.monotonic()

        def moved():
            nonlocal due
            if time.monotonic() >= due:
                due += 0.1
                script.publish(steer, twist)
            place = odom[-1].pose.pose.position if odom else Point()
            return place.x > 0.05 and place.y > 0.02

        script.wait_for(moved, 'the base to move', 20.0)


def test_parameters_and_services_of_the_texts_work(workspace):
    """ros2 param set and ros2 service call, read from the text and done with rclpy."""
    setting, call = command_of('ros2 param set'), command_of('ros2 service call')
    handled = {'ros2 topic pub', 'ros2 topic echo', 'ros2 param set', 'ros2 service call'}
    assert {' '.join(c.split()[:3]) for c in COMMANDS if is_talk(c)} == handled
    with Script() as script:
        node = script.add(node_class('sim'), robot='robot.yaml', stepped=False,
                          start_ns=script.now_ns)
        assert setting[3] == '/sim_node' == '/' + node.get_name()
        answer, = node.set_parameters([parameter(setting[4], setting[5])])
        assert answer.successful
        node.step(0.01)
        assert node.simulation._injection.active.keys() == {setting[5]}
        assert call[4] == 'std_srvs/srv/SetBool'
        request = fill(SetBool.Request(), yaml.safe_load(call[5]))
        assert script.call(SetBool, call[3].lstrip('/'), request).success
        node.step(0.01)
        assert not node.simulation._injection.active


@pytest.mark.parametrize('verb', VERBS)
def test_the_examples_of_the_help_are_understood(verb, monkeypatch, capsys):
    """Their files are made up, so only the words are taken in."""
    module = importlib.import_module(f'mecanum_base.cli.{verb}')
    taken = []
    monkeypatch.setattr(module, 'run', lambda options: taken.append(options) or 0)
    text = re.sub(r'\\\n +', '', module.EXAMPLE).strip()
    lines = [line.split('  ')[0].split(' #')[0] for line in text.splitlines()
             if line and not line.startswith('exit codes: ')]
    for line in lines:
        words = shlex.split(line)
        assert words[:2] == ['mecanum', verb]
        assert main(words[1:]) == 0, line
    assert len(taken) == len(lines)
    passed_on = [word for options in taken for word in getattr(options, 'ros_arguments', [])]
    assert not passed_on or passed_on[0] == '--ros-args'
