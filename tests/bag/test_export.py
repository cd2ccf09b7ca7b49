import csv

import numpy as np
import pytest

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
'''


@pytest.fixture
def replayed(tmp_path, make, mecanum):
    """Replays a drive, with more words, into the folder out."""
    def run(*flags, entries=None):
        path = make.write_mcap(tmp_path / 'a.mcap', entries or make.drive(1.0))
        (tmp_path / 'robot.yaml').write_text(ROBOT)
        return mecanum('replay', path, '--robot', tmp_path / 'robot.yaml', '--out',
                       tmp_path / 'out', *flags)
    return run


def rows(path):
    with open(path, newline='') as file:
        return list(csv.DictReader(file))


def test_the_new_bag_holds_the_old_topics_unchanged_and_the_new_odometry(tmp_path, make, replayed):
    """Read back with rosbags' own reader: a rosbag2 folder, deserialized by the library."""
    from rosbags.rosbag2 import Reader
    entries = make.drive(1.0)
    done = replayed('--bag', entries=entries)
    assert done.returncode == 0, done.stderr
    old, new = [], []
    with Reader(tmp_path / 'out' / 'bag') as reader:
        for connection, log, data in reader.messages():
            if connection.topic.startswith('/replayed/'):
                new.append((connection.topic, log, make.STORE.deserialize_cdr(
                    data, connection.msgtype)))
            else:
                old.append((connection.topic, log, bytes(data)))
    assert sorted(old) == sorted((t, s, make.serialized(m)) for t, s, m in entries)
    odometry = [(log, msg) for topic, log, msg in new if topic == '/replayed/odom']
    track = rows(tmp_path / 'out' / 'track.csv')
    assert len(odometry) == len(track)
    for (log, msg), row in zip(odometry, track):
        assert f'{log // 10**9}.{log % 10**9:09d}' == row['stamp']
        assert msg.pose.pose.position.x == float(row['x'])
        assert msg.pose.covariance[0] == float(row['cov_xx'])
    slip = rows(tmp_path / 'out' / 'slip.csv')
    wheels = [msg for topic, _, msg in new if topic == '/replayed/slip/wheels']
    np.testing.assert_array_equal(
        [msg.velocity[1] for msg in wheels],
        [float(row['front_right_wheel_joint.slip_rate']) for row in slip])


def test_topics_of_unknown_types_are_named_and_left_out(tmp_path, make, replayed):
    entries = [*make.drive(0.5), ('/mine', make.T0 + 10**9, ('my_msgs/msg/Thing', b'\0\1\0\0'))]
    done = replayed('--bag', entries=entries)
    assert done.returncode == 0
    assert done.stderr == ('mecanum replay: /mine (my_msgs/msg/Thing) is not copied: its '
                           'definition is not known\n')


def test_an_existing_bag_is_not_overwritten(tmp_path, make, replayed):
    (tmp_path / 'out' / 'bag').mkdir(parents=True)
    done = replayed('--bag')
    assert done.returncode == 2 and 'not overwritten' in done.stderr


def test_parquet_holds_the_numbers_of_the_csv_to_the_last_bit(tmp_path, make, replayed):
    parquet = pytest.importorskip('pyarrow.parquet', reason='needs the extra parquet')
    done = replayed('--parquet')
    assert done.returncode == 0, done.stderr
    table = parquet.read_table(tmp_path / 'out' / 'track.parquet').to_pydict()
    track = rows(tmp_path / 'out' / 'track.csv')
    assert [str(v) for v in table['stamp']] == [row['stamp'] for row in track]
    for name in ('x', 'yaw', 'cov_xyaw'):
        assert table[name] == [float(row[name]) for row in track]
    assert table['source'] == [row['source'] for row in track]
    later = parquet.read_table(tmp_path / 'out' / 'track_smoothed.parquet').to_pydict()
    smoothed = rows(tmp_path / 'out' / 'track_smoothed.csv')
    assert later['x'] == [float(row['x']) for row in smoothed]
    assert sorted(p.name for p in (tmp_path / 'out').glob('*.parquet')) == [
        'slip.parquet', 'slip_smoothed.parquet', 'track.parquet', 'track_smoothed.parquet']
