"""The README promises only what exists: commands, options, make targets, files, topics."""

import contextlib
import io
import pathlib
import re
import shlex

import pytest

from mecanum_base.cli.main import main
from mecanum_base.cli.verbs import VERBS
from mecanum_base.robot import all_rules

ROOT = pathlib.Path(__file__).resolve().parents[2]
if not (ROOT / 'README.md').is_file():
    pytest.skip('the README is not installed', allow_module_level=True)
README = (ROOT / 'README.md').read_text(encoding='utf-8')


def commands():
    for block in re.findall(r'```sh\n(.*?)```', README, flags=re.S):
        for line in block.splitlines():
            line = line.split('#')[0].strip().rstrip('&').strip()
            if line:
                yield line


def mecanum_lines():
    shown = [line for line in commands() if line.startswith('mecanum ')]
    return shown + re.findall(r'`(mecanum [a-z][^`]*)`', README)


def help_of(verb):
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
        main([verb, '--help'])
    return text.getvalue()


@pytest.mark.parametrize('line', sorted(set(mecanum_lines())))
def test_every_command_and_option_of_the_readme_exists(line):
    words = shlex.split(line)
    for verb in words[1].split('|'):
        assert verb in VERBS
        shown = help_of(verb)
        for word in words[2:]:
            if word == '--ros-args':
                break
            if word.startswith('--'):
                assert re.search(rf'{word}\b', shown), f'{verb} has no {word}'


def test_every_make_target_of_the_readme_exists():
    targets = set(re.findall(r'^([a-z]+):', (ROOT / 'Makefile').read_text(), flags=re.M))
    asked = {line.split()[1] for line in commands() if line.startswith('make ')}
    asked |= set(re.findall(r'`make ([a-z]+)`', README))
    assert {'demo', 'test'} <= asked
    assert asked <= targets


def test_every_file_the_readme_links_to_exists():
    links = re.findall(r'\]\(([^)#]+)\)', README)
    assert links
    missing = [link for link in links if '://' not in link and not (ROOT / link).exists()]
    assert missing == []


def test_every_parameter_the_readme_names_exists():
    blocks = ('wheels', 'encoder', 'imu', 'drive', 'sim', 'estimator', 'goal', 'record')
    named = re.findall(rf'`((?:{"|".join(blocks)})\.[a-z_]+)`', README)
    assert named
    assert set(named) <= set(all_rules())


def test_the_error_message_shown_is_the_one_printed(tmp_path, capsys):
    text = (ROOT / 'config' / 'mecanum4.yaml').read_text(encoding='utf-8')
    broken = tmp_path / 'robot.yaml'
    broken.write_text(text.replace('radius: [0.05, 0.05, 0.05,', 'radius: [0.05, 0.05, 0.0,'),
                      encoding='utf-8')
    assert main(['check', str(broken)]) == 2
    shown = re.search(r'`(wheels\.radius\[2\] [^`]+)`', README)
    assert shown and shown[1] in capsys.readouterr().err


@pytest.mark.parametrize('name', ['swedish3', 'swedish4', 'mecanum6', 'asymmetric', 'mixed',
                                  'dual_differential'])
def test_every_base_the_readme_names_has_a_file(name):
    assert f'`{name}`' in README
    assert (ROOT / 'config' / f'{name}.yaml').is_file()


def test_every_test_and_parameter_the_guide_names_exists():
    guide = (ROOT / 'docs' / 'integration.md').read_text(encoding='utf-8')
    tests = ''.join(path.read_text(encoding='utf-8')
                    for path in (ROOT / 'tests' / 'ros').glob('test_*.py'))
    named = set(re.findall(r'`(test_[a-z_]+)`', guide))
    assert len(named) > 15
    assert [name for name in named if f'def {name}(' not in tests] == []
    blocks = ('wheels', 'encoder', 'imu', 'drive', 'sim', 'estimator', 'goal', 'record')
    parameters = set(re.findall(rf'`((?:{"|".join(blocks)})\.[a-z_]+)`', guide))
    assert 'drive.command_timeout' in parameters
    assert parameters <= set(all_rules())
    files = set(re.findall(r'`((?:config|docker|docs|tests)/[^`*]+)`', guide))
    assert [name for name in files if not (ROOT / name).exists()] == []
