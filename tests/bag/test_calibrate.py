"""Calibration; the coverage campaign: python tests/bag/calibration_coverage.py 100."""

import json
import subprocess
import sys

import calibration_coverage as coverage
import driving
import numpy as np
import pytest

from mecanum_base.bag.analysis.calibrated_file import calibrated_wheels, rewritten, roller_text
from mecanum_base.bag.analysis.calibration import Calibration
from mecanum_base.bag.analysis.fitted_value import Value
from mecanum_base.bag.analysis.robust_fit import robust_fit, student
from mecanum_base.cli.main import main
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.robot import Robot
from mecanum_base.robot_file import load_robot, parse_parameters


def given(**scales):
    found = Calibration('test')
    for name in ('forward', 'sideways', 'turning'):
        value = scales.get(name)
        found.axes[name] = Value(name, value, value, value, '')
    return found


def test_values_are_within_half_a_percent_of_the_truth_and_hold_out_improves():
    found, real = coverage.one(7)
    for name in ('forward', 'sideways', 'turning'):
        assert found.axes[name].value == pytest.approx(real[name], abs=0.005)
    assert found.held_out['after'] < 0.5 * found.held_out['before']


def test_most_intervals_cover_the_truth():
    """6 bases x 8 values at 90 %: fewer than 70 % covered has a chance below 1 in 1000."""
    hits = [v for seed in range(6) for v in coverage.covered(*coverage.one(seed)).values()
            if v is not None]
    assert len(hits) > 40
    assert np.mean(hits) > 0.7


@pytest.mark.parametrize('axis', ['forward', 'sideways', 'turning'])
def test_what_the_motion_did_not_excite_is_refused_with_the_manoeuvre(axis):
    found, _ = coverage.one(1, **{axis: 0.0}, seconds=60.0)
    assert not found.axes[axis].given
    assert 'drive' in found.axes[axis].verdict or 'turn' in found.axes[axis].verdict


def test_the_known_trap_of_a_bag_that_hardly_strafes_gives_no_lateral_scale():
    found, _ = coverage.one(3, sideways=0.01, seconds=60.0)
    assert found.axes['forward'].given and not found.axes['sideways'].given


def test_a_gyro_alone_tells_the_yaw_only():
    found, real = coverage.one(4, truth=False)
    assert not found.axes['forward'].given and not found.axes['sideways'].given
    assert found.axes['turning'].low < real['turning'] < found.axes['turning'].high
    assert found.source == 'gyro'


def test_slipping_legs_do_not_spoil_the_fit():
    found, real = coverage.one(5, slip=0.15)
    assert found.axes['forward'].value == pytest.approx(real['forward'], abs=0.01)


def test_the_new_wheel_table_has_exactly_the_fitted_scales():
    robot = Robot.from_mapping(parse_parameters(driving.YAML, 'test'))
    scales = np.array([1.03, 0.98, 0.95])
    changed = calibrated_wheels(robot.base, given(forward=1.03, sideways=0.98, turning=0.95))
    old, new = (body_from_wheels(wheels_from_body(w)) for w in (robot.base, changed))
    np.testing.assert_allclose(new, old * scales[:, None], rtol=1e-9, atol=1e-12)


def test_only_the_given_scales_change_the_table():
    robot = Robot.from_mapping(parse_parameters(driving.YAML, 'test'))
    changed = calibrated_wheels(robot.base, given(turning=1.05))
    assert changed.radius.tolist() == robot.base.radius.tolist()
    assert changed.roller == pytest.approx(robot.base.roller)
    assert changed.x == pytest.approx(robot.base.x / 1.05)


def test_the_written_file_keeps_comments_and_other_keys_and_loads_again():
    text = driving.YAML.replace('    encoder:', '    # my note\n    encoder:') + '    imu: {}\n'
    robot = Robot.from_mapping(parse_parameters(text, 'test'))
    changed = calibrated_wheels(robot.base, given(forward=1.02))
    new = rewritten(text, 'test', changed, 'how it was made')
    assert new.startswith('# how it was made\n') and '# my note' in new
    again = Robot.from_mapping(parse_parameters(new, 'test'))
    assert again.base.radius == pytest.approx(robot.base.radius * 1.02, abs=1e-9)
    assert again.base.joint == robot.base.joint


def test_block_lists_in_the_file_are_replaced_too():
    text = driving.YAML.replace('radius: [0.05, 0.05, 0.05, 0.05]',
                                'radius:\n      - 0.05\n      - 0.05\n      - 0.05\n      - 0.05')
    robot = Robot.from_mapping(parse_parameters(text, 'test'))
    new = rewritten(text, 'test', calibrated_wheels(robot.base, given(forward=1.1)), 'x')
    again = Robot.from_mapping(parse_parameters(new, 'test'))
    assert again.base.radius == pytest.approx(robot.base.radius * 1.1)


def test_a_lateral_factor_is_compared_with_the_contact_correction_of_rollers():
    robot = Robot.from_mapping(parse_parameters(driving.YAML, 'test'))
    # sin(pi/9)/(pi/9) = 0.97982: nine rollers
    assert '9 rollers' in roller_text(given(forward=1.0, sideways=0.9798), robot.base)
    assert roller_text(given(forward=1.0), robot.base) == ''
    wide = given(forward=1.0, sideways=0.96)
    wide.axes['sideways'] = Value('sideways', 0.96, 0.94, 0.98, '')
    # 0.9549 (6), 0.9668 (7), 0.9745 (8), 0.9798 (9) lie between 0.94 and 0.98
    assert '6 to 9 rollers' in roller_text(wide, robot.base)
    assert 'no number' in roller_text(given(forward=1.0, sideways=1.05), robot.base)


def test_student_quantiles_match_the_table():
    """Two-sided 90 %: 2.353 (3), 1.943 (6), 1.812 (10), 1.645 (infinite)."""
    for freedom, wanted in ((3, 2.353), (6, 1.943), (10, 1.812), (10**6, 1.645)):
        assert student(0.9, freedom) == pytest.approx(wanted, rel=0.01)


def test_the_robust_fit_ignores_one_sided_outliers():
    generator = np.random.default_rng(1)
    x = generator.normal(size=400)
    y = 1.02 * x + 0.01 * generator.normal(size=400)
    y[::10] -= 0.5 * np.abs(x[::10]) + 0.3
    fit = robust_fit(x[:, None], y, np.arange(400) // 8)
    assert fit.value[0] == pytest.approx(1.02, abs=0.003)


def bag_of(make, path, made, names=driving.JOINTS, imu=False):
    entries = [('/joint_states', int(s), make.joint_state(int(s), a, names))
               for s, a in zip(made.wheel_ns[::4], made.angle[::4])]
    if imu:
        entries += [('/imu/data_raw', int(s), make.imu(int(s), gyro, accel))
                    for s, gyro, accel in zip(made.imu_ns[::2], made.gyro[::2], made.accel[::2])]
    entries += [('/ground_truth/odom', int(s), make.odometry(int(s), p))
                for s, p in zip(made.truth_ns[::2], made.pose[::2])]
    return make.write_mcap(path, sorted(entries, key=lambda e: e[1]))


def test_the_command_writes_a_file_whose_odometry_is_better(tmp_path, make):
    made = driving.drive(seed=5, seconds=60.0, lever=0.37, lateral=0.95,
                         radius=0.052 * np.array([0.98, 1.02, 1.02, 0.98]))
    path = bag_of(make, tmp_path / 'a.mcap', made)
    (tmp_path / 'robot.yaml').write_text(driving.YAML)
    command = [sys.executable, '-m', 'mecanum_base', 'calibrate', path, '--robot',
               str(tmp_path / 'robot.yaml'), '--out', str(tmp_path / 'new.yaml')]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ''
    assert '--per-wheel writes' in done.stdout
    base = Robot.from_mapping(parse_parameters((tmp_path / 'new.yaml').read_text(), 'new')).base
    scale = body_from_wheels(wheels_from_body(base)) / body_from_wheels(
        wheels_from_body(coverage.ROBOT.base))
    np.testing.assert_allclose(scale[:, 0], [1.04, 1.04 * 0.95, 1.04 * 0.35 / 0.37], rtol=0.01)


def test_the_gyro_scale_of_the_written_file_is_the_right_one_and_fitted_no_more(tmp_path, make,
                                                                               capsys):
    """Another recording of the same robot, read with the written file, shows a scale of 1."""
    files = [tmp_path / name for name in ('robot.yaml', 'first.yaml', 'second.yaml')]
    files[0].write_text(driving.YAML + '    imu: {gyro_scale: 1.01}\n')
    scales = []
    for seed, old, new in ((5, *files[:2]), (6, *files[1:])):
        made = driving.drive(seed=seed, seconds=60.0, gyro_scale=1.03)
        path = bag_of(make, tmp_path / f'{seed}.mcap', made, imu=True)
        assert main(['calibrate', path, '--robot', str(old), '--out', str(new), '--json']) == 0
        found = json.loads(capsys.readouterr().out)
        scales += [v['value'] for v in found['constants'] if v['name'] == 'gyro scale']
    assert scales[0] == pytest.approx(1.03 / 1.01, abs=0.002)
    assert scales[1] == pytest.approx(1.0, abs=0.002)
    assert load_robot(files[1]).imu.gyro_scale == pytest.approx(1.03, abs=0.002)


def test_a_folder_that_holds_bags_serves_too(tmp_path, make, mecanum):
    (tmp_path / 'runs').mkdir()
    made = driving.drive(seed=5, seconds=40.0)
    bag_of(make, tmp_path / 'runs' / 'a.mcap', made)
    (tmp_path / 'robot.yaml').write_text(driving.YAML)
    for verb, more in (('calibrate', ['--out', str(tmp_path / 'new.yaml')]), ('doctor', [])):
        done = mecanum(verb, tmp_path / 'runs', '--robot', tmp_path / 'robot.yaml', *more)
        assert done.returncode == 0, (done.stdout, done.stderr)


def test_a_bag_without_reference_writes_no_file_and_says_why(tmp_path, make, mecanum):
    made = driving.drive(seed=6, seconds=20.0)
    entries = [('/joint_states', int(s), make.joint_state(int(s), a))
               for s, a in zip(made.wheel_ns[::4], made.angle[::4])]
    path = make.write_mcap(tmp_path / 'a.mcap', entries)
    (tmp_path / 'robot.yaml').write_text(driving.YAML)
    done = mecanum('calibrate', path, '--robot', tmp_path / 'robot.yaml', '--out',
                   tmp_path / 'new.yaml')
    assert done.returncode == 1
    assert 'no reference for distances' in done.stdout
    assert not (tmp_path / 'new.yaml').exists()
