"""A killed recording is completed without losing a complete chunk."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import textwrap

import pytest

pytest.importorskip('mcap')
pytest.importorskip('rosbags')

import yaml
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from mecanum_base.bag.recorder import Recorder, description
from mecanum_base.bag.recover import recover
from mecanum_base.core.errors import BagError

STORE = get_typestore(Stores.ROS2_JAZZY)
START = 1_700_000_000_000_000_000
QOS = [{'history': 'keep_last', 'depth': 10, 'reliability': 'reliable', 'durability': 'volatile',
        'deadline': {'sec': 0, 'nsec': 0}, 'lifespan': {'sec': 0, 'nsec': 0},
        'liveliness': 'automatic', 'liveliness_lease_duration': {'sec': 0, 'nsec': 0},
        'avoid_ros_namespace_conventions': False}]


def header_bytes(index):
    time = STORE.types['builtin_interfaces/msg/Time'](sec=index, nanosec=7)
    header = STORE.types['std_msgs/msg/Header'](stamp=time, frame_id=f'frame {index}')
    return bytes(STORE.serialize_cdr(header, 'std_msgs/msg/Header'))


def record(folder, count, *, flush_every=10, close=True):
    recorder = Recorder(folder)
    channel = recorder.channel('/odometry_reset', 'std_msgs/msg/Header', QOS)
    for index in range(count):
        recorder.write(channel, START + index, START + index - 1, header_bytes(index))
        if (index + 1) % flush_every == 0:
            recorder.flush()
    if close:
        recorder.close()
    return recorder


def messages_of(folder):
    with Reader(folder) as reader:
        return [(connection.topic, stamp, bytes(raw))
                for connection, stamp, raw in reader.messages()]


def test_a_closed_recording_is_a_rosbag2_bag_with_the_very_bytes(tmp_path):
    record(tmp_path / 'bag', 25)
    assert messages_of(tmp_path / 'bag') == [
        ('/odometry_reset', START + i, header_bytes(i)) for i in range(25)]


def test_metadata_names_version_type_hash_qos_and_counts(tmp_path):
    record(tmp_path / 'bag', 25)
    info = yaml.safe_load((tmp_path / 'bag/metadata.yaml').read_text())[
        'rosbag2_bagfile_information']
    assert (info['version'], info['storage_identifier'], info['message_count']) == (9, 'mcap', 25)
    assert info['duration'] == {'nanoseconds': 24}
    assert info['starting_time'] == {'nanoseconds_since_epoch': START}
    topic = info['topics_with_message_count'][0]['topic_metadata']
    assert topic['type'] == 'std_msgs/msg/Header'
    # the hash every ROS 2 Jazzy prints for std_msgs/msg/Header (ros2 topic info -v)
    assert topic['type_description_hash'] == (
        'RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01')
    assert topic['offered_qos_profiles'] == QOS


def test_the_file_has_the_statistics_that_rosbag2_dereferences(tmp_path):
    recorder = record(tmp_path / 'bag', 25)
    with recorder.path.open('rb') as stream:
        summary = make_reader(stream).get_summary()
    assert summary.statistics.message_count == 25
    assert [s.encoding for s in summary.schemas.values()] == ['ros2msg']
    assert [c.message_encoding for c in summary.channels.values()] == ['cdr']
    assert yaml.safe_load(
        next(iter(summary.channels.values())).metadata['offered_qos_profiles']) == QOS


def test_definitions_carry_every_part_they_need():
    text, type_hash = description('nav_msgs/msg/Odometry')
    assert 'MSG: geometry_msgs/PoseWithCovariance' in text and '=' * 80 in text
    assert type_hash.startswith('RIHS01_') and len(type_hash) == 71


def test_an_unknown_type_is_refused_by_name(tmp_path):
    recorder = Recorder(tmp_path / 'bag')
    with pytest.raises(BagError, match='my_msgs/msg/Own'):
        recorder.channel('/own', 'my_msgs/msg/Own')
    recorder.close()


def test_an_existing_folder_is_never_overwritten(tmp_path):
    with pytest.raises(BagError, match='exists already'):
        Recorder(tmp_path)


KILLED = textwrap.dedent('''
    import os, signal, sys
    sys.path.insert(0, {tests!r})
    from test_recover import Recorder, START, header_bytes
    recorder = Recorder({folder!r})
    channel = recorder.channel('/odometry_reset', 'std_msgs/msg/Header')
    for index in range(57):
        recorder.write(channel, START + index, START + index, header_bytes(index))
        if (index + 1) % 10 == 0:
            recorder.flush()
    os.kill(os.getpid(), signal.SIGKILL)
''')


@pytest.fixture(scope='module')
def killed_once(tmp_path_factory):
    """The folder of a recording whose process was killed 7 messages after its last flush."""
    folder = tmp_path_factory.mktemp('once') / 'killed'
    script = KILLED.format(tests=str(pathlib.Path(__file__).parent), folder=str(folder))
    done = subprocess.run([sys.executable, '-c', script], timeout=60, check=False)
    assert done.returncode == -signal.SIGKILL
    return folder


@pytest.fixture
def killed(killed_once, tmp_path):
    """A copy of it for one test."""
    return shutil.copytree(killed_once, tmp_path / 'killed')


def test_a_killed_recorder_loses_only_what_came_after_the_last_flush(killed):
    with next(killed.glob('*.mcap')).open('rb') as stream:
        found = []
        with pytest.raises(EndOfFile):
            for _, _, message in NonSeekingReader(stream).iter_messages(log_time_order=False):
                found.append(message.log_time - START)
    assert found == list(range(50))


def test_recovery_makes_a_killed_recording_a_rosbag2_bag(killed):
    assert not (killed / 'metadata.yaml').exists()
    result = recover(next(killed.glob('*.mcap')))
    assert result.messages == 50
    assert any('no end mark' in text for text in result.losses)
    assert messages_of(killed) == [
        ('/odometry_reset', START + i, header_bytes(i)) for i in range(50)]
    with next(killed.glob('*.mcap')).open('rb') as stream:
        assert make_reader(stream).get_summary().statistics.message_count == 50
    assert sorted(os.listdir(killed)) == ['killed_0.mcap', 'metadata.yaml']


def test_a_file_cut_at_any_byte_gives_its_complete_chunks(tmp_path):
    whole = record(tmp_path / 'bag', 40).path.read_bytes()
    counts = []
    for cut in range(200, len(whole), 197):
        folder = tmp_path / f'cut{cut}'
        folder.mkdir()
        (folder / 'a.mcap').write_bytes(whole[:cut])
        counts.append(recover(folder).messages)
        assert [m[2] for m in messages_of(folder)] == [header_bytes(i) for i in range(counts[-1])]
    assert counts == sorted(counts) and counts[0] == 0 and counts[-1] == 40
    assert set(counts) <= {0, 10, 20, 30, 40}


def test_a_damaged_chunk_is_named_and_the_others_are_kept(tmp_path):
    recorder = record(tmp_path / 'bag', 40)
    data = bytearray(recorder.path.read_bytes())
    with recorder.path.open('rb') as stream:
        second = make_reader(stream).get_summary().chunk_indexes[1]
    data[second.chunk_start_offset + second.chunk_length - 20] ^= 0xFF
    recorder.path.write_bytes(data)
    result = recover(recorder.path)
    assert [raw for _, _, raw in messages_of(tmp_path / 'bag')] == [
        header_bytes(i) for i in range(40) if not 10 <= i < 20]
    assert len(result.losses) == 1 and str(second.chunk_start_offset) in result.losses[0]


def test_completing_twice_changes_nothing(killed):
    path = next(killed.glob('*.mcap'))
    recover(path)
    first = path.read_bytes(), (killed / 'metadata.yaml').read_text()
    assert recover(killed).losses == ()
    assert (path.read_bytes(), (killed / 'metadata.yaml').read_text()) == first


def test_publish_times_and_sequence_numbers_survive_recovery(killed):
    path = next(killed.glob('*.mcap'))
    recover(path)
    with path.open('rb') as stream:
        kept = [(m.log_time, m.publish_time, m.sequence)
                for _, _, m in make_reader(stream).iter_messages()]
    assert kept == [(START + i, START + i, i) for i in range(50)]


def test_a_running_recording_is_left_alone(tmp_path):
    recorder = Recorder(tmp_path / 'bag')
    with pytest.raises(BagError, match='being recorded'):
        recover(recorder.path)
    recorder.close()


def test_one_of_several_recordings_gets_no_metadata_that_hides_the_others(tmp_path):
    for name in ('a', 'b'):
        record(tmp_path / name, 10).path.rename(tmp_path / f'{name}.mcap')
    result = recover(tmp_path / 'a.mcap')
    assert result.metadata is None and not (tmp_path / 'metadata.yaml').exists()
    assert 'other recordings' in result.losses[0]


@pytest.mark.parametrize('content', [b'', b'no bag at all'])
def test_what_is_no_bag_is_refused(tmp_path, content):
    (tmp_path / 'x.mcap').write_bytes(content)
    with pytest.raises(BagError, match='x.mcap'):
        recover(tmp_path / 'x.mcap')


def test_a_folder_without_recordings_is_refused(tmp_path):
    with pytest.raises(BagError, match='no .mcap'):
        recover(tmp_path)
