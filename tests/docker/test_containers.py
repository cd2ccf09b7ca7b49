"""Container files: the compose file against its specification, commands and files that exist.

The schema check needs the package compose_spec (in .ci/run); no engine is needed for any of this.
"""

import pathlib
import re
import shlex

import pytest
import yaml

from mecanum_base.cli.verbs import VERBS

FOLDER = pathlib.Path(__file__).resolve().parents[2] / 'docker'
if not FOLDER.is_dir():
    pytest.skip('docker/ is not installed', allow_module_level=True)
COMPOSE = FOLDER / 'compose.yaml'


def interpolated(environment=()):
    """The text with ${NAME:-default} filled in, as compose does first."""
    known = dict(environment)
    return re.sub(r'\$\{(\w+):-([^}]*)\}', lambda m: known.get(m[1]) or m[2],
                  COMPOSE.read_text(encoding='utf-8'))


@pytest.fixture
def services():
    return yaml.safe_load(interpolated())['services']


def instructions(name):
    text = re.sub(r'\\\n', ' ', (FOLDER / name).read_text(encoding='utf-8'))
    return [line.split(' ', 1) for line in text.splitlines() if line and line[0] not in '# ']


def test_the_compose_file_fulfils_the_specification():
    compose_spec = pytest.importorskip('compose_spec')
    merged = yaml.safe_load(interpolated())  # yaml has worked the merge keys out
    compose = compose_spec.PyCompose.from_yaml(yaml.safe_dump(merged))
    compose.validate()
    assert set(compose.service_names()) == {'sim', 'drive', 'odometry'}


def test_a_key_that_compose_does_not_know_would_be_found():
    compose_spec = pytest.importorskip('compose_spec')
    spoilt = yaml.safe_load(interpolated())
    spoilt['services']['sim']['comand'] = ['sim']
    with pytest.raises(Exception, match='comand'):
        compose_spec.PyCompose.from_yaml(yaml.safe_dump(spoilt))


def test_both_profiles_run_drive_and_odometry_and_only_one_the_simulation(services):
    assert {name: one['profiles'] for name, one in services.items()} == {
        'sim': ['sim'], 'drive': ['sim', 'robot'], 'odometry': ['sim', 'robot']}


def test_every_service_runs_a_verb_with_the_robot_file_that_is_mounted(services):
    for name, one in services.items():
        assert one['command'][0] == name in VERBS
        source, target, mode = one['volumes'][0].split(':')
        assert one['command'][-1] == target and mode == 'ro'
        assert (FOLDER / source).is_file()  # paths are relative to the compose file
        assert (FOLDER / one['build']['context'] / one['build']['dockerfile']).is_file()
        assert one['environment']['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST'
        assert one['network_mode'] == 'host'


def test_the_robot_file_and_the_domain_come_from_the_environment():
    text = interpolated({'ROBOT': '/my.yaml', 'ROS_DOMAIN_ID': '7'})
    drive = yaml.safe_load(text)['services']['drive']
    assert drive['volumes'] == ['/my.yaml:/robot.yaml:ro']
    assert drive['environment']['ROS_DOMAIN_ID'] == 7


@pytest.mark.parametrize('name', ['Dockerfile', 'Dockerfile.ros'])
def test_an_image_runs_as_an_ordinary_user_with_a_health_check_and_files_that_exist(name):
    steps = instructions(name)
    words = [step[0] for step in steps]
    assert words[0] == 'FROM' and 'HEALTHCHECK' in words
    users = [step[1] for step in steps if step[0] == 'USER']
    assert users and all(user not in ('root', '0') for user in users)
    for step, rest in steps:
        if step == 'COPY':
            for source in shlex.split(rest.replace('--chown=robot:robot', ''))[:-1]:
                assert (FOLDER.parent / source).exists(), source


def test_the_image_that_was_only_linted_says_so():
    assert instructions('Dockerfile.ros')[0][1] == 'ros:jazzy-ros-base'
    assert 'linted, not built' in (FOLDER / 'Dockerfile.ros').read_text(encoding='utf-8')
