import json
import pathlib
import subprocess
import sys

import numpy as np
import pytest

from mecanum_base.bag.replay import replay
from mecanum_base.bag.summary import summary_of
from mecanum_base.bag.topics import Topics
from mecanum_base.bag.track import FILES, SMOOTHED
from mecanum_base.core.errors import BagError
from mecanum_base.core.estimation import smoother
from mecanum_base.robot import Robot
from mecanum_base.robot_file import parse_parameters

ROBOT = '''/**:
  ros__parameters:
    wheels:
      joint: [front_left_wheel_joint, front_right_wheel_joint, rear_left_wheel_joint,
              rear_right_wheel_joint]
      x: [0.2, 0.2, -0.2, -0.2]
      y: [0.15, -0.15, 0.15, -0.15]
      axle: [1.5707963267948966, 1.5707963267948966, 1.5707963267948966, 1.5707963267948966]
      roller: [0.7853981633974483, -0.7853981633974483, -0.7853981633974483, 0.7853981633974483]
      radius: [0.05, 0.05, 0.05, 0.05]
    encoder: {counts_per_revolution: 4096.0}
    imu: {}
'''


def robot_of(text=ROBOT):
    return Robot.from_mapping(parse_parameters(text, 'test'))


def run(path, out, robot=None, topics=None):
    robot = robot or robot_of()
    return replay([str(path)], robot, out, topics or Topics.of(robot))


def column(out, name, file='track.csv'):
    lines = (pathlib.Path(out) / file).read_text().splitlines()
    index = lines[0].split(',').index(name)
    return [line.split(',')[index] for line in lines[1:]]


def test_straight_driving_gives_the_distance_of_the_wheels(tmp_path, make):
    done = run(make.write_mcap(tmp_path / 'a.mcap', make.drive(4.0)), tmp_path / 'out')
    # 199 steps of 4 rad/s / 50 Hz at 0.05 m radius
    assert float(column(tmp_path / 'out', 'x')[-1]) == pytest.approx(199 * 4 / 50 * 0.05, rel=0.01)
    assert float(column(tmp_path / 'out', 'y')[-1]) == pytest.approx(0.0, abs=0.01)
    assert set(column(tmp_path / 'out', 'source')) <= {'encoder', 'predicted'}
    assert done.course.path == pytest.approx(199 * 4 / 50 * 0.05, rel=0.05)
    assert len(column(tmp_path / 'out', 'stamp', 'slip.csv')) == len(
        column(tmp_path / 'out', 'stamp'))


def test_any_arrival_order_within_the_wait_gives_the_same_bytes(tmp_path, make):
    """Contract, section 5: log times shuffled by up to reorder_wait (20 ms), stamps kept.

    The intake goes through 50 orders in tests/system/test_live_equals_replay.py.
    """
    entries = [e for e in make.drive(0.4) if e[0] != '/wheel_ticks']
    generator = np.random.default_rng(1)
    tracks = set()
    for index in range(12):
        shuffled = sorted(((t, s + int(generator.integers(0, 19_000_000)), m)
                           for t, s, m in entries), key=lambda e: e[1])
        path = make.write_mcap(tmp_path / f'{index}.mcap', shuffled)
        run(path, tmp_path / 'out')
        tracks.add((tmp_path / 'out' / 'track.csv').read_bytes())
    assert len(tracks) == 1


def test_bulk_and_message_by_message_decoding_give_the_same_bytes(tmp_path, make):
    """Big-endian messages take the slow way."""
    entries = make.drive(1.0)
    run(make.write_mcap(tmp_path / 'a.mcap', entries), tmp_path / 'bulk')
    slow = [(t, s, (m.__msgtype__, make.serialized(m, False))) for t, s, m in entries]
    run(make.write_mcap(tmp_path / 'b.mcap', slow), tmp_path / 'slow')
    for name in ('track.csv', 'slip.csv', 'odometry.tum'):
        assert (tmp_path / 'bulk' / name).read_bytes() == (tmp_path / 'slow' / name).read_bytes()


def test_topics_are_found_with_and_without_a_leading_slash(tmp_path, make):
    entries = make.drive(0.5)
    run(make.write_mcap(tmp_path / 'a.mcap', entries), tmp_path / 'a')
    bare = [(t.lstrip('/'), s, m) for t, s, m in entries]
    run(make.write_mcap(tmp_path / 'b.mcap', bare), tmp_path / 'b')
    assert (tmp_path / 'a' / 'track.csv').read_bytes() == (
        tmp_path / 'b' / 'track.csv').read_bytes()


def test_recorded_set_pose_and_reset_are_applied_at_their_stamps(tmp_path, make):
    entries = make.drive(4.0)
    at = make.T0 + 1_000_000_000
    entries.append(('/set_pose', at + 1000, make.set_pose(at, (10.0, 5.0, 0.0))))
    later = make.T0 + 3_000_000_000
    entries.append(('/odometry_reset', later + 1000, make.header(later)))
    run(make.write_mcap(tmp_path / 'a.mcap', sorted(entries, key=lambda e: e[1])),
        tmp_path / 'out')
    stamp = np.array(column(tmp_path / 'out', 'stamp'), float) - 1_700_000_000
    x, y = (np.array(column(tmp_path / 'out', n), float) for n in 'xy')
    assert x[stamp < 0.99].max() < 1.0
    middle = (stamp > 1.02) & (stamp < 2.98)
    assert y[middle] == pytest.approx(5.0, abs=0.05)
    assert x[middle].min() > 9.9 and x[middle].max() < 10.6
    after = stamp > 3.02
    assert np.abs(y[after]).max() < 0.05 and x[after].max() < 0.5


def test_wheel_ticks_take_the_log_time(tmp_path, make):
    robot = robot_of(ROBOT.replace('encoder: {', 'encoder: {source: wheel_ticks, '))
    run(make.write_mcap(tmp_path / 'a.mcap', make.drive(2.0)), tmp_path / 'out', robot)
    stamps = column(tmp_path / 'out', 'stamp')
    # ticks are logged 70 us behind the grid of 20 ms
    assert '1700000001.000070000' in stamps
    assert float(column(tmp_path / 'out', 'x')[-1]) == pytest.approx(99 * 4 / 50 * 0.05, rel=0.02)


def test_the_imu_can_be_left_out(tmp_path, make):
    robot = robot_of()
    path = make.write_mcap(tmp_path / 'a.mcap', make.drive(1.0))
    done = run(path, tmp_path / 'out', robot, Topics.of(robot, use_imu=False))
    assert done.reader.read['imu'] == 0
    assert done.intake.estimator.health.imu == 'none'


def test_malformed_messages_are_counted_by_reason(tmp_path, make):
    entries = make.drive(1.0)
    bad = make.joint_state(make.T0 + 5, [1.0, 2.0], make.WHEELS)
    entries.insert(5, ('/joint_states', entries[5][1], bad))
    entries.insert(9, ('/joint_states', entries[9][1], ('sensor_msgs/msg/JointState', b'\0\1')))
    robot = robot_of()
    topics = Topics.of(robot)
    (tmp_path / 'r.yaml').write_text(ROBOT)
    done = run(make.write_mcap(tmp_path / 'a.mcap', entries), tmp_path / 'out', robot, topics)
    summary = summary_of(done, topics, str(tmp_path / 'r.yaml'))
    rejected = summary['messages']['joint_states']['rejected']
    assert rejected['array length differs from name'] == 1
    assert rejected['the bytes do not fit the type'] == 1
    assert summary['messages']['joint_states']['read'] == 52
    json.dumps(summary, allow_nan=False)


def test_a_bag_without_the_encoder_topic_names_what_it_has(tmp_path, make):
    entries = [(t.replace('/joint_states', '/robot/joint_states'), s, m)
               for t, s, m in make.drive(0.5)]
    path = make.write_mcap(tmp_path / 'a.mcap', entries)
    with pytest.raises(BagError, match='--encoder-topic /robot/joint_states'):
        run(path, tmp_path / 'out')
    robot = robot_of()
    done = run(path, tmp_path / 'out', robot, Topics.of(robot, encoder='robot/joint_states'))
    assert done.course.rows > 10


def test_joints_that_are_not_in_the_robot_file_are_named(tmp_path, make):
    entries = [('/joint_states', s, make.joint_state(s, [0.1] * 4, ('a', 'b', 'c', 'd')))
               for s in range(make.T0, make.T0 + 10**9, 10**8)]
    with pytest.raises(BagError, match='names a wheel of the robot file'):
        run(make.write_mcap(tmp_path / 'a.mcap', entries), tmp_path / 'out')


def test_a_topic_of_the_wrong_type_is_named(tmp_path, make):
    robot = robot_of()
    with pytest.raises(BagError, match='needs sensor_msgs/msg/JointState or'):
        run(make.write_mcap(tmp_path / 'a.mcap', make.drive(0.2)), tmp_path / 'out', robot,
            Topics.of(robot, encoder='/imu/data_raw'))


SPREAD = ('shuffled', 'everything', 'clock goes back')  # something odd in most of the chunks


def odd(make, kind):
    """Entries with something out of the ordinary in the middle of plain driving."""
    entries = [e for e in make.drive(6.0) if e[0] != '/wheel_ticks']
    middle = len(entries) // 2
    topic, log, msg = entries[middle]
    if kind == 'late stamp':
        entries[middle] = (topic, log, make.imu(make.T0 + 10**9))
    elif kind == 'far stamp':
        entries[middle] = (topic, log, make.imu(make.T0 + 10**12))
    elif kind == 'jump':
        entries = [(t, s, make.joint_state(s, np.array(m.position) + (900 if s > log else 0)))
                   if t == '/joint_states' else (t, s, m) for t, s, m in entries]
    elif kind == 'missing wheel':
        entries[middle:middle] = [('/joint_states', log, make.joint_state(
            log, [1.0, 2.0], make.WHEELS[:2]))]
    elif kind == 'silence':
        entries = [e for e in entries if not 0 < e[1] - log < 10**9]
    elif kind == 'long silence':
        entries = [(t, s, m) if s < log else (
            t, s + 9 * 10**9, make.imu(s + 9 * 10**9) if t == '/imu/data_raw'
            else make.joint_state(s + 9 * 10**9, m.position)) for t, s, m in entries]
    elif kind == 'wild gyro':
        entries[middle] = ('/imu/data_raw', log, make.imu(log, (0, 0, 1e9), (1e9, 0, 0)))
    elif kind == 'clock goes back':
        entries += [(t, s + 10**9, make.imu(s - 5 * 10**9) if t == '/imu/data_raw'
                     else make.joint_state(s - 5 * 10**9, m.position))
                    for t, s, m in entries if s > log]
    elif kind == 'shuffled':
        generator = np.random.default_rng(1)
        entries = sorted(((t, s + int(generator.integers(0, 19_000_000)), m)
                          for t, s, m in entries), key=lambda e: e[1])
    elif kind == 'set pose':
        entries.insert(middle, ('/set_pose', log, make.set_pose(log, (3, 4, 1.0))))
    elif kind == 'everything':
        generator = np.random.default_rng(2)
        for index in range(50, len(entries)):
            topic, log, msg = entries[index]
            chance = generator.random()
            if chance < 0.02:  # comes later than anything waits for it
                entries[index] = (topic, log + 60_000_000, msg)
            elif chance < 0.025:
                entries[index] = (topic, log, make.imu(log + 10**12))
            elif chance < 0.03:
                entries[index] = ('/joint_states', log, make.joint_state(
                    log, [1.0, 2.0], make.WHEELS[:2]))
            elif chance < 0.035:
                entries[index] = (topic, log, make.imu(log, (0, 0, 1e9), (1e9, 0, 0)))
            elif chance < 0.04:
                entries[index] = ('/set_pose', log, make.set_pose(log, (3, 4, 1.0)))
            elif chance < 0.045:
                entries[index] = (topic, log, (msg.__msgtype__, b'\0\1'))
        entries.sort(key=lambda e: e[1])
    return entries


@pytest.mark.parametrize('kind', [
    'plain', 'late stamp', 'far stamp', 'jump', 'missing wheel', 'silence', 'long silence',
    'wild gyro', 'clock goes back', 'shuffled', 'set pose', 'everything'])
def test_columns_and_single_samples_give_the_same_bytes(tmp_path, make, monkeypatch, kind):
    import mecanum_base.bag.portion as module
    path = make.write_mcap(tmp_path / 'a.mcap', odd(make, kind), chunk_size=20_000)
    taken = []

    def counted(*arguments):
        taken.append(original(*arguments))
        return taken[-1]

    original = module.take
    monkeypatch.setattr(module, 'take', counted)
    monkeypatch.setattr(module, 'SIZE', 300)  # several chunks of 60 messages
    monkeypatch.setattr(smoother, 'PIECE', 10**9)
    monkeypatch.setattr(smoother, 'AHEAD', 10**9)
    fast = run(path, tmp_path / 'fast')
    by_columns = sum(len(rows.stamp_ns) for rows in taken if rows is not None)
    assert by_columns > fast.course.rows * (0.5 if kind in SPREAD else 0.75)
    monkeypatch.setattr(module, 'take', lambda *arguments: None)
    slow = run(path, tmp_path / 'slow')
    for name in (*FILES, *SMOOTHED):
        assert (tmp_path / 'fast' / name).read_bytes() == (tmp_path / 'slow' / name).read_bytes()
    first, second = fast.intake.estimator, slow.intake.estimator
    assert first.health == second.health
    assert [e.start_ns for e in first.episodes] == [e.start_ns for e in second.episodes]
    assert fast.course.path == pytest.approx(slow.course.path, rel=1e-12)
    stamps, source = (column(tmp_path / 'fast', name) for name in ('stamp', 'source'))
    assert column(tmp_path / 'fast', 'stamp', 'track_smoothed.csv') == [
        stamp for stamp, kind in zip(stamps, source) if kind == 'encoder']


def test_the_command_writes_its_files_and_keeps_the_pipe_clean(tmp_path, make):
    path = make.write_mcap(tmp_path / 'a.mcap', make.drive(1.0))
    (tmp_path / 'robot.yaml').write_text(ROBOT)
    done = subprocess.run(
        [sys.executable, '-m', 'mecanum_base', 'replay', path, '--robot',
         str(tmp_path / 'robot.yaml'), '--out', str(tmp_path / 'out')],
        capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and done.stderr == ''
    assert '\r' not in done.stdout and '\x1b' not in done.stdout
    assert sorted(p.name for p in (tmp_path / 'out').iterdir()) == [
        'odometry.tum', 'slip.csv', 'slip_smoothed.csv', 'summary.json', 'track.csv',
        'track_smoothed.csv', 'track_smoothed.tum']
    summary = json.loads((tmp_path / 'out' / 'summary.json').read_text())
    for key in ('messages', 'duration', 'distance', 'slip_episodes', 'health', 'run', 'versions',
                'robot_file'):
        assert key in summary
    assert len(summary['robot_file']['sha256']) == 64


@pytest.mark.parametrize('case', ['no bag', 'text', 'cut', 'robot'])
def test_bad_input_is_one_line_and_code_2_or_a_stated_loss(tmp_path, make, mecanum, case):
    good = make.write_mcap(tmp_path / 'a.mcap', make.drive(2.0), chunk_size=4096)
    robot = tmp_path / 'robot.yaml'
    robot.write_text(ROBOT)
    path = tmp_path / 'b.mcap'
    if case == 'text':
        path.write_text('not a bag')
    elif case in ('cut', 'robot'):
        path.write_bytes(pathlib.Path(good).read_bytes()[:9000])
    if case == 'robot':
        robot.write_text(ROBOT.replace('radius: [0.05', 'radius: [-0.05'))
    done = mecanum('replay', path, '--robot', robot, '--out', tmp_path / 'out')
    assert len(done.stderr.strip().splitlines()) == 1
    assert 'Traceback' not in done.stderr
    if case == 'cut':
        assert done.returncode == 0 and 'lost' in done.stderr and 'bytes' in done.stderr
    else:
        assert done.returncode == 2
