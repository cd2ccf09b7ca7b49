"""Stamps of the IMU that are late: read with ``imu.late``, found and written by calibrate."""

import json

import driving
import numpy as np
import pytest

from mecanum_base.bag.analysis.arrival import Arrivals
from mecanum_base.bag.analysis.fitted_value import Value
from mecanum_base.bag.analysis.time_offset import OFFSET, lateness
from mecanum_base.bag.replay import replay
from mecanum_base.bag.topics import Topics
from mecanum_base.cli.main import main
from mecanum_base.core.errors import ConfigError
from mecanum_base.robot import Robot
from mecanum_base.robot_file import load_robot, parse_parameters, shipped

LATE = 0.0123456789  # s, in ns no whole number
LATE_NS = 12_345_679


def robot_of(imu):
    return Robot.from_mapping(parse_parameters(driving.YAML + f'    imu: {imu}\n', 'test'))


# --- reading ------------------------------------------------------------------------------------

@pytest.mark.parametrize('little_endian', [True, False])  # in bulk, message by message
def test_a_bag_read_with_the_lateness_of_its_stamps_gives_the_bytes_of_right_stamps(
        tmp_path, make, little_endian):
    made = driving.drive(seed=2, seconds=6.0, rest=0.5)
    tracks = []
    for name, moved, text in (('right', 0, '{}'), ('late', LATE_NS, f'{{late: {LATE}}}')):
        entries = [('/joint_states', int(s), make.joint_state(int(s), a))
                   for s, a in zip(made.wheel_ns, made.angle)]
        entries += [('/imu/data_raw', int(s) + 100, make.imu(int(s) + moved, g, a))
                    for s, g, a in zip(made.imu_ns, made.gyro, made.accel)]
        path = make.write_mcap(tmp_path / f'{name}.mcap', [
            (t, s, (m.__msgtype__, make.serialized(m, little_endian)))
            for t, s, m in sorted(entries, key=lambda e: e[1])])
        robot = robot_of(text)
        done = replay([path], robot, tmp_path / name, Topics.of(robot))
        assert not done.intake.health.rejected
        tracks.append((tmp_path / name / 'track.csv').read_bytes())
    assert tracks[0] == tracks[1] and tracks[0].count(b'\n') > 500


def test_lateness_beyond_half_a_second_is_refused():
    assert robot_of(f'{{late: {LATE}}}').imu.late_ns == LATE_NS
    with pytest.raises(ConfigError, match=r'imu\.late = 0\.6: must be >= -0\.5 and <= 0\.5 \[s\]'):
        robot_of('{late: 0.6}')


# --- calibrating --------------------------------------------------------------------------------

TEXT = (shipped() / 'mecanum4.yaml').read_text(encoding='utf-8')


def with_late(path, late):
    path.write_text(TEXT.replace('from_tf: false', f'from_tf: false\n      late: {late}'))
    return str(path)


@pytest.fixture(scope='module')
def simulated(tmp_path_factory):
    """Folder ``run`` of a robot whose driver stamps its IMU on arrival, 60 ms late."""
    folder = tmp_path_factory.mktemp('late')
    hardware = with_late(folder / 'hardware.yaml', 0.06)
    assert main(['sim', '--scenario', 'circle_spin', '--robot', hardware, '--duration', '12',
                 '--out', str(folder / 'run')]) == 0
    return folder / 'run'


def calibrated(simulated, tmp_path, late, code=0):
    old, new = with_late(tmp_path / 'old.yaml', late), tmp_path / 'new.yaml'
    words = ['calibrate', str(simulated / 'bag'), '--robot', old, '--out', str(new)]
    assert main(words) == code
    return old, new


def analyzed(simulated, robot, out):
    """Position error [m rms] of the estimator against the truth, and the codes of all findings."""
    assert main(['analyze', str(simulated / 'bag'), '--robot', str(robot), '--out', str(out),
                 '--no-html']) < 2
    found, = json.loads((out / 'findings.json').read_text())
    error, = [d['ate'] for d in found['drift'] if d['name'] == 'estimator']
    return error, [f['code'] for f in found['findings']]


def test_late_stamps_are_written_into_the_file_which_then_reads_the_recording_better(
        simulated, tmp_path, capsys):
    old, new = calibrated(simulated, tmp_path, 0.0)
    robot = load_robot(new)
    # the body follows its wheels 1 to 2 ms late, and a sample is the mean of the 5 ms before
    assert robot.imu.late == pytest.approx(0.060, abs=0.006)
    # messages come with their stamps: 60 ms behind the encoders', so that 20 ms would lose them
    assert robot.estimator.reorder_wait == pytest.approx(0.075, abs=0.01)
    told = capsys.readouterr().out
    assert 'imu.late = 0.06' in told and 'estimator.reorder_wait = 0.02 s' in told
    assert main(['check', str(new)]) == 0
    assert capsys.readouterr().err == ''
    before, found = analyzed(simulated, old, tmp_path / 'before')
    after, left = analyzed(simulated, new, tmp_path / 'after')
    assert after < 0.5 * before  # found: 3 mm instead of 40
    assert 'time_offset' in found and 'time_offset' not in left
    assert 'rejected' not in left  # of the messages that now count as late none is lost


def test_what_the_file_already_knows_is_added(simulated, tmp_path):
    _, new = calibrated(simulated, tmp_path, 0.03)
    assert load_robot(new).imu.late == pytest.approx(0.060, abs=0.006)


def test_a_file_that_knows_it_is_left_alone(simulated, tmp_path, capsys):
    _, new = calibrated(simulated, tmp_path, 0.061, code=1)  # too short for any other constant
    told = capsys.readouterr()
    assert 'gyro time offset [s]' in told.out and 'imu.late' not in told.out
    assert 'no file written' in told.err and not new.exists()


@pytest.mark.parametrize('late', [0.0, 0.04])
def test_the_doctor_names_the_line_that_calibrate_writes(simulated, tmp_path, capsys, late):
    robot = with_late(tmp_path / 'robot.yaml', late)
    assert main(['doctor', str(simulated / 'bag'), '--robot', robot, '--json']) == 1
    diagnosis, = json.loads(capsys.readouterr().out)['diagnoses']
    assert diagnosis['fault'] == 'time_offset'
    key, value = diagnosis['lines'][0].split(': ')
    assert key == 'late' and float(value) == pytest.approx(0.060, abs=0.006)


def offset(value, half=0.001):
    return Value(OFFSET, value, value - half, value + half, 'observable')


@pytest.mark.parametrize('offsets, old, new, told', [
    ([0.042], 0.0, 0.042, ('42 ms too late', '2.4 deg', 'imu.late = 0.0420 s is written')),
    ([0.042], -0.012, 0.03, ('42 ms too late', 'imu.late = 0.0300 s is written')),
    ([-0.031, -0.029], 0.0, -0.03, ('30 ms too early', 'imu.late = -0.0300 s is written')),
    ([0.010, 0.055], 0.0, None, ('+10 to +55 ms', 'not written', 'synchronise')),
    ([0.2], 0.4, None, ('imu.late = 0.600 s', 'more than 0.5 s', 'driver'))])
def test_an_offset_is_written_with_the_one_of_the_file_or_refused(offsets, old, new, told):
    found, notes = lateness([offset(v) for v in offsets], old)
    assert found == (None if new is None else pytest.approx(new, abs=1e-9))
    assert all(part in notes[0] for part in told), notes


def test_an_offset_of_half_a_sample_or_none_or_an_uncertain_one_is_left_alone():
    assert lateness([offset(0.004), offset(-0.002, 0.003)], 0.0) == (None, [])
    assert lateness([offset(0.02, 0.025)], 0.0) == (None, [])
    assert lateness([Value(OFFSET, None, None, None, 'too little turning')], 0.0) == (None, [])


def test_the_sure_recording_counts_more_than_the_unsure_one():
    """Weights 1 / half width squared: (0.06 / 1 + 0.05 / 100) / (1 + 1 / 100) = 0.0599."""
    assert lateness([offset(0.06, 0.001), offset(0.05, 0.01)], 0.0)[0] == pytest.approx(0.0599)


# --- waiting ------------------------------------------------------------------------------------

def arrived(imu_stamp, imu_arrival, count=400):
    """Encoders every 10 ms, known at once; IMU every 5 ms, with these stamps and arrivals."""
    encoder = [(i * 10_000_000, i * 10_000_000, 0) for i in range(count)]
    imu = [(i * 5_000_000 + imu_arrival, i * 5_000_000 + imu_stamp, 1) for i in range(2 * count)]
    table = np.array(sorted(encoder + imu))
    return Arrivals(table[:, 1], table[:, 2])


def test_stamps_made_on_arrival_ask_for_a_wait_as_long_as_they_are_late():
    """Moved back by 60 ms each is 55 or 60 ms behind the newest encoder; 10 ms in reserve."""
    assert arrived(60_000_000, 60_000_000).wait(60_000_000, 0.02) == pytest.approx(0.07)
    assert arrived(60_000_000, 60_000_000).wait(60_000_000, 0.08) is None


def test_stamps_of_a_clock_ahead_ask_for_no_wait():
    assert arrived(60_000_000, 0).wait(60_000_000, 0.02) is None


def test_stamps_moved_ahead_make_the_encoders_late():
    assert arrived(0, 0).wait(-40_000_000, 0.02) == pytest.approx(0.05)
