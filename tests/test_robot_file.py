"""Robot files: YAML errors, places of wrong values, number lists that ROS 2 refuses."""

import pytest

from mecanum_base.core.errors import ConfigError
from mecanum_base.robot_file import line_of, load_robot, parse_yaml, read_parameters, shipped

TEXT = (shipped() / 'mecanum4.yaml').read_text(encoding='utf-8')


def write(tmp_path, text):
    path = tmp_path / 'robot.yaml'
    path.write_text(text, encoding='utf-8')
    return path


def line_with(text):
    return next(i for i, line in enumerate(TEXT.splitlines(), 1) if text in line)


def test_the_shipped_robot_loads():
    assert load_robot(shipped() / 'mecanum4.yaml').base.count == 4
    assert 'wheels' in read_parameters(shipped() / 'mecanum4.yaml')


def test_a_wrong_value_is_found_by_file_and_line(tmp_path):
    path = write(tmp_path, TEXT.replace('radius: [0.05, 0.05', 'radius: [0.05, -0.05'))
    place = rf'robot\.yaml, line {line_with("radius: [0.05")}, wheels\.radius\[1\] = -0\.05'
    with pytest.raises(ConfigError, match=place):
        load_robot(path)


def test_a_missing_value_is_placed_at_its_block(tmp_path):
    text = '\n'.join(line for line in TEXT.splitlines() if ' y: ' not in line)
    with pytest.raises(ConfigError, match=rf'line {line_with("wheels:")}, wheels\.y: is missing'):
        load_robot(write(tmp_path, text))


def test_lines_of_keys_lists_and_unknown_blocks():
    assert line_of(TEXT, 'wheels.x[2]') == line_with(' x: ')
    assert line_of(TEXT, 'encoder') == line_with('encoder:')
    assert line_of(TEXT, 'goal.rate') == 0


@pytest.mark.parametrize(('text', 'match'), [
    ('a: [1, 2', r'robot\.yaml, line \d+, column \d+: is not valid YAML'),
    ('', 'must be a YAML mapping'), ('- 1\n- 2\n', 'must be a YAML mapping'),
    ('a: 1\n', 'must have a block'), ('/**: 3\n', 'must hold a block ros__parameters'),
    ('/**:\n  ros__parameters: 3\n', 'must hold a block ros__parameters')])
def test_a_file_that_is_no_robot_file_is_refused(tmp_path, text, match):
    with pytest.raises(ConfigError, match=match):
        load_robot(write(tmp_path, text))


def test_a_list_of_mixed_numbers_names_line_and_cure(tmp_path):
    text = TEXT.replace('x:      [0.20', 'x:      [0')
    with pytest.raises(ConfigError, match=rf'line {line_with(" x: ")}.*write 0\.0'):
        load_robot(write(tmp_path, text))


def test_lists_of_integers_alone_are_accepted(tmp_path):
    text = TEXT.replace('max_speed: [20.0, 20.0, 20.0, 20.0]', 'max_speed: [20, 20, 20, 20]')
    assert load_robot(write(tmp_path, text)).base.max_speed.tolist() == [20.0] * 4


def test_a_file_that_cannot_be_read_says_why(tmp_path):
    with pytest.raises(ConfigError, match='cannot be read: No such file'):
        load_robot(tmp_path / 'nothing.yaml')
    (tmp_path / 'robot.yaml').write_bytes(b'\xff\xfe\x00')
    with pytest.raises(ConfigError, match='cannot be read'):
        load_robot(tmp_path / 'robot.yaml')


def test_other_nodes_may_have_their_own_blocks_beside_ours(tmp_path):
    robot = load_robot(write(tmp_path, TEXT + '\nother_node:\n  ros__parameters: {a: 1}\n'))
    assert robot.ignored == ()


def test_parsing_needs_a_mapping():
    assert parse_yaml('a: [1.0, 2.0]', 'x') == {'a': [1.0, 2.0]}
