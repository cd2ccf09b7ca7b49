"""Doctor against injected faults; the whole table: python tests/bag/doctor_table.py 20."""

import subprocess
import sys

import doctor_table as table
import driving
import pytest


@pytest.mark.parametrize('name', list(table.FAULTS))
def test_each_fault_is_named_with_the_line_that_cures_it(name):
    result, verdict = table.judged(name, seed=11)
    assert result == 'found', verdict


@pytest.mark.parametrize('name', ['only forward', 'standing still',
                                  'only forward, wheels swapped'])
def test_poor_motion_is_answered_with_the_manoeuvre_to_drive(name):
    _, verdict = table.judged(name, seed=12)
    assert not verdict.diagnoses
    assert 'drive' in verdict.missing[0]


@pytest.mark.parametrize('name', ['none', 'swap front left / front right', 'reverse one',
                                  'mirrored rollers'])
def test_a_true_pose_serves_where_there_is_no_imu(name):
    result, verdict = table.judged(name, seed=13, imu=False)
    assert result == 'found', verdict


def test_without_imu_commands_or_truth_it_says_that_it_cannot_tell():
    made = driving.drive(seed=1, seconds=30.0)
    motion = table.WheelMotion(driving.JOINTS, made.wheel_ns, made.angle)
    verdict = table.examine(table.ROBOT, motion, None)
    assert not verdict.diagnoses and 'neither an IMU' in verdict.missing[0]


@pytest.mark.parametrize('name', ['none', 'reverse one', 'imu quarter turn'])
def test_slip_and_noise_never_make_it_wrongly_certain(name):
    for seed in (21, 22):
        result, verdict = table.judged(name, seed=seed, slip=0.4, creep=0.05, gyro_noise=0.02,
                                       accel_noise=0.5)
        assert result != 'wrong', verdict


def test_the_command_prints_the_corrected_line_and_exits_with_1(tmp_path, make):
    made = driving.drive(seed=3, seconds=25.0)
    made.angle = made.angle[:, [1, 0, 2, 3]]
    entries = [('/joint_states', int(s), make.joint_state(int(s), a))
               for s, a in zip(made.wheel_ns[::2], made.angle[::2])]
    entries += [('/imu/data_raw', int(s), make.imu(int(s), g, a))
                for s, g, a in zip(made.imu_ns[::2], made.gyro[::2], made.accel[::2])]
    path = make.write_mcap(tmp_path / 'a.mcap', sorted(entries, key=lambda e: e[1]))
    (tmp_path / 'robot.yaml').write_text(driving.YAML)
    done = subprocess.run([sys.executable, '-m', 'mecanum_base', 'doctor', path, '--robot',
                           str(tmp_path / 'robot.yaml')], capture_output=True, text=True,
                          timeout=60)
    assert done.returncode == 1, done.stderr
    assert 'joint: [front_right_wheel_joint, front_left_wheel_joint,' in done.stdout
    assert done.stderr == ''
