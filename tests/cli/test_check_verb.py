"""`mecanum check` as a new user runs it."""

import pytest

from mecanum_base.cli.main import main
from mecanum_base.robot_file import shipped

TEXT = (shipped() / 'mecanum4.yaml').read_text(encoding='utf-8')


def check(tmp_path, capsys, text, *words):
    path = tmp_path / 'robot.yaml'
    path.write_text(text, encoding='utf-8')
    code = main(['check', str(path), *words])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def with_rollers(text, *angles):
    lines = [f'      roller: [{", ".join(map(str, angles))}]' if ' roller: ' in line else line
             for line in text.splitlines()]
    return '\n'.join(lines)


def test_a_good_file_tells_what_the_robot_can_do_and_its_encoders_see(tmp_path, capsys):
    code, out, err = check(tmp_path, capsys, TEXT)
    assert code == 0 and err == ''
    for words in ('rank 3 of 3, redundancy 1', 'encoders alone: 1 independent check',
                  'with a gyro: 2 independent checks', 'looks like rear_right_wheel_joint',
                  'turning on the spot', '2.06 % sideways', '1.18 % in rotation', '0.0767 mm',
                  'findings: none'):
        assert words in out


@pytest.mark.parametrize('late, wait, told', [
    (0.06, 0.02, ('messages of the IMU', 'to 0.08 s')),
    (-0.03, 0.02, ('messages of the encoders', 'to 0.05 s')),
    (0.06, 0.06, ()), (0.0, 0.0, ())])
def test_lateness_of_the_imu_beyond_the_wait_of_the_merge_is_warned_of(tmp_path, capsys, late,
                                                                       wait, told):
    text = TEXT.replace('from_tf: false', f'from_tf: false\n      late: {late}').replace(
        '    imu:', f'    estimator: {{reorder_wait: {wait}}}\n    imu:', 1)
    code, _, err = check(tmp_path, capsys, text)
    assert code == 0 and (err == '') == (told == ())
    if told:
        assert err.startswith(f'warning: imu.late = {late:g} s') and err.count('\n') == 1
        assert all(part in err for part in told)


def test_mirrored_rollers_are_a_finding_that_is_explained(tmp_path, capsys):
    code, out, _ = check(tmp_path, capsys, with_rollers(TEXT, -0.7854, 0.7854, 0.7854, -0.7854))
    assert code == 1
    assert 'rollers seem to be mirrored' in out.split('findings:')[1]


def test_a_nearly_singular_base_is_a_finding(tmp_path, capsys):
    text = with_rollers(TEXT, -0.7854, 0.7854, 0.7854, -0.7854).replace(
        '[0.15, -0.15, 0.15, -0.15]', '[0.199, -0.199, 0.199, -0.199]')
    code, out, _ = check(tmp_path, capsys, text)
    assert code == 1 and 'nearly singular' in out.split('findings:')[1]


def test_an_invalid_file_is_one_line_with_the_place(tmp_path, capsys):
    code, out, err = check(tmp_path, capsys, TEXT.replace('0.05, 0.05, 0.05, 0.05', '0.05'))
    assert code == 2 and out == ''
    assert len(err.splitlines()) == 1 and 'robot.yaml, line' in err and 'wheels.radius' in err


def test_unknown_keys_are_one_warning_or_an_error_when_strict(tmp_path, capsys):
    text = TEXT + '    goall: {max_speed: 0.3}\n    controller_server: {a: 1}\n'
    code, _, err = check(tmp_path, capsys, text)
    assert code == 0 and len(err.splitlines()) == 1
    assert 'goall (did you mean goal?)' in err and 'controller_server' in err
    code, _, err = check(tmp_path, capsys, text, '--strict')
    assert code == 2 and 'goall' in err


def test_unknown_roller_counts_are_told_to_cost_accuracy(tmp_path, capsys):
    _, out, _ = check(tmp_path, capsys, TEXT.replace('[9, 9, 9, 9]', '[0, 0, 0, 0]'))
    assert 'no correction; sideways odometry over-reads by 1-3 %' in out


def test_a_platform_has_its_own_description(capsys):
    assert main(['check', str(shipped() / 'dual_differential.yaml')]) == 0
    out = capsys.readouterr().out
    for words in ('omnidirectional', 'Lie rank 3, with first brackets 5', 'at the worst',
                  'pull the hinges apart'):
        assert words in out


def test_a_platform_that_will_flip_its_carriers_is_a_finding(tmp_path, capsys):
    text = (shipped() / 'dual_differential.yaml').read_text(encoding='utf-8')
    code, out, _ = check(tmp_path, capsys, text.replace('[-0.1, -0.1]', '[-0.1, 0.1]'))
    assert code == 1 and 'carrier rear does not trail' in out


@pytest.mark.parametrize('name', ['swedish3', 'mixed', 'asymmetric', 'mecanum6', 'swedish4'])
def test_other_bases_are_described_without_a_word_too_many(name, capsys):
    assert main(['check', str(shipped() / f'{name}.yaml')]) == 0
    out = capsys.readouterr().out
    assert 'nan' not in out and 'inf' not in out.replace('information', '')
    assert ('Swedish wheels: the contact point' in out) == name.startswith('swedish')
