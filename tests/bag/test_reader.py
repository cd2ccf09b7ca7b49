import os
import sqlite3

import numpy as np
import pytest

from mecanum_base.bag.reader import Bag
from mecanum_base.bag.stream import SampleReader
from mecanum_base.bag.topics import Topics
from mecanum_base.core.errors import BagError


def messages_of(paths):
    with Bag(paths) as bag:
        found = [(block.channels[block.channel[i]].topic, int(block.log_ns[i]), block.payload(i))
                 for block in bag.blocks() for i in range(len(block))]
        return found, bag.loss


def expected(make, entries):
    return [(topic, int(log), make.serialized(msg)) for topic, log, msg in entries]


@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
@pytest.mark.parametrize('chunked', [True, False])
def test_every_message_is_read_in_log_order(tmp_path, make, compression, chunked):
    entries = make.drive()
    path = make.write_mcap(tmp_path / 'a.mcap', entries, compression, chunked=chunked)
    found, loss = messages_of(path)
    assert found == expected(make, entries)
    assert not loss


def test_messages_out_of_order_across_chunks_are_sorted_by_log_time(tmp_path, make):
    entries = make.drive()
    shuffled = list(entries)
    for i in range(0, len(shuffled) - 60, 45):  # swap stretches: chunks of 30 then overlap
        shuffled[i:i + 60] = shuffled[i + 30:i + 60] + shuffled[i:i + 30]
    path = make.write_mcap(tmp_path / 'a.mcap', shuffled, chunk_size=4000)
    found, _ = messages_of(path)
    assert [f[1] for f in found] == sorted(e[1] for e in entries)
    assert sorted(found) == sorted(expected(make, entries))


def test_several_files_are_one_recording(tmp_path, make):
    entries = make.drive()
    wheels = [e for e in entries if e[0] == '/joint_states']
    rest = [e for e in entries if e[0] != '/joint_states']
    paths = [make.write_mcap(tmp_path / 'wheels.mcap', wheels, 'lz4'),
             make.write_mcap(tmp_path / 'rest.mcap', rest)]
    found, _ = messages_of(paths)
    assert found == expected(make, entries)


def rosbag2_folder(make, place, entries, storage):
    from rosbags.rosbag2 import StoragePlugin, Writer
    with Writer(place, version=9, storage_plugin=StoragePlugin[storage]) as writer:
        connections = {}
        for topic, log, msg in entries:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msg.__msgtype__,
                                                           typestore=make.STORE)
            writer.write(connections[topic], int(log), make.serialized(msg))
    return str(place)


@pytest.mark.parametrize('storage', ['MCAP', 'SQLITE3'])
def test_a_rosbag2_folder_is_read_with_either_storage(tmp_path, make, storage):
    entries = make.drive()
    place = rosbag2_folder(make, tmp_path / 'bag', entries, storage)
    found, loss = messages_of(place)
    assert found == expected(make, entries)
    assert not loss


@pytest.mark.parametrize('storage', ['MCAP', 'SQLITE3'])
def test_a_folder_whose_metadata_is_missing_or_damaged_is_read_all_the_same(
        tmp_path, make, storage):
    entries = make.drive(0.5)
    place = tmp_path / 'bag'
    rosbag2_folder(make, place, entries, storage)
    (place / 'metadata.yaml').write_text('rosbag2_bagfile_information: [broken')
    assert messages_of(place)[0] == expected(make, entries)
    (place / 'metadata.yaml').unlink()
    assert messages_of(place)[0] == expected(make, entries)


def test_metadata_cannot_point_outside_the_folder(tmp_path, make):
    outside = make.write_mcap(tmp_path / 'secret.mcap', make.drive(0.1))
    place = tmp_path / 'bag'
    place.mkdir()
    (place / 'metadata.yaml').write_text(
        f'rosbag2_bagfile_information:\n  relative_file_paths: ["../secret.mcap", {outside!r}]\n')
    with pytest.raises(BagError, match='missing'):
        Bag(place)


def test_a_packed_file_is_unpacked_first(tmp_path, make):
    import zstandard
    entries = make.drive(0.5)
    plain = make.write_mcap(tmp_path / 'a.mcap', entries)
    packed = tmp_path / 'a.mcap.zstd'
    with open(plain, 'rb') as source:
        packed.write_bytes(zstandard.compress(source.read()))
    os.unlink(plain)
    assert messages_of(packed)[0] == expected(make, entries)


def test_messages_packed_one_by_one_are_unpacked(tmp_path, make):
    import zstandard
    entries = make.drive(0.5)
    place = tmp_path / 'bag'
    place.mkdir()
    packed = [(t, log, (m.__msgtype__, zstandard.compress(make.serialized(m))))
              for t, log, m in entries]
    make.write_mcap(place / 'bag_0.mcap', packed)
    (place / 'metadata.yaml').write_text(
        'rosbag2_bagfile_information:\n  relative_file_paths: [bag_0.mcap]\n'
        '  compression_format: zstd\n  compression_mode: MESSAGE\n')
    assert messages_of(place)[0] == expected(make, entries)


def chunk_spans(path):
    """(start, end) byte positions of the chunk records, from the mcap library's own index."""
    from mcap.reader import make_reader
    with open(path, 'rb') as file:
        return [(c.chunk_start_offset, c.chunk_start_offset + c.chunk_length)
                for c in make_reader(file).get_summary().chunk_indexes]


def test_a_cut_file_gives_every_complete_chunk_and_states_the_loss(tmp_path, make):
    entries = make.drive()
    whole = make.write_mcap(tmp_path / 'whole.mcap', entries)
    spans = chunk_spans(whole)
    assert len(spans) > 4
    with open(whole, 'rb') as file:
        data = file.read()
    everything = expected(make, entries)
    per_chunk = []
    for _, end in spans:
        solo = tmp_path / 'solo.mcap'
        solo.write_bytes(data[:end])
        per_chunk.append(len(messages_of(solo)[0]))
    assert per_chunk == sorted(per_chunk) and per_chunk[-1] == len(everything)
    for cut in np.random.default_rng(1).integers(spans[0][1], spans[-1][1], 40):
        path = tmp_path / 'cut.mcap'
        path.write_bytes(data[:cut])
        complete = sum(end <= cut for _, end in spans)
        found, loss = messages_of(path)
        assert found == everything[:per_chunk[complete - 1]]
        assert loss
        inside = [start for start, end in spans if start < cut < end]
        if inside and cut - inside[0] > 60:  # the chunk's head is there and tells its time span
            assert loss.bytes == cut - inside[0]
            lost = everything[per_chunk[complete]:][:1]
            span = (lost or everything[-1:])[0][1] - found[-1][1]
            assert loss.seconds_known
            assert abs(loss.seconds * 1e9 - span) < 25e6  # one message period


def test_a_chunk_that_fails_its_checksum_is_left_out_and_its_span_is_stated(tmp_path, make):
    entries = make.drive()
    path = make.write_mcap(tmp_path / 'a.mcap', entries, 'none')
    spans = chunk_spans(path)
    with open(path, 'r+b') as file:
        start, end = spans[2]
        file.seek(start + (end - start) // 2)
        old = file.read(1)
        file.seek(-1, os.SEEK_CUR)
        file.write(bytes([old[0] ^ 0x10]))
    found, loss = messages_of(path)
    assert 0 < len(found) < len(entries)
    assert loss.bytes == end - start
    missing = sorted(set(expected(make, entries)) - set(found), key=lambda f: f[1])
    assert loss.seconds == pytest.approx((missing[-1][1] - missing[0][1]) / 1e9, abs=1e-9)
    assert 'checksum' in loss.text()


def test_reading_goes_on_behind_a_damaged_stretch(tmp_path, make):
    entries = make.drive()
    path = make.write_mcap(tmp_path / 'a.mcap', entries)
    spans = chunk_spans(path)
    with open(path, 'r+b') as file:
        file.seek(spans[1][0] - 20)
        file.write(b'\xff' * 60)  # runs into the head of chunk 1
    found, loss = messages_of(path)
    logs = {f[1] for f in found}
    assert entries[-1][1] in logs and entries[0][1] in logs
    assert len(found) >= len(entries) * (len(spans) - 2) // len(spans)
    assert loss.bytes >= spans[1][1] - spans[1][0]


def test_a_lying_size_is_refused_before_memory_is_taken(tmp_path, make):
    path = make.write_mcap(tmp_path / 'a.mcap', make.drive(), 'zstd')
    start = chunk_spans(path)[0][0]
    with open(path, 'r+b') as file:
        file.seek(start + 9 + 16)
        file.write((1 << 50).to_bytes(8, 'little'))
    found, loss = messages_of(path)
    assert found and 'claims' in loss.text()


def test_a_file_without_an_end_mark_says_so_and_loses_nothing(tmp_path, make):
    entries = make.drive()
    path = make.write_mcap(tmp_path / 'a.mcap', entries)
    last = chunk_spans(path)[-1][1]
    os.truncate(path, last)
    found, loss = messages_of(path)
    assert found == expected(make, entries)
    assert loss.bytes == 0 and 'no end mark' in loss.text()


def test_a_split_bag_with_one_file_missing_reads_the_rest(tmp_path, make):
    entries = make.drive()
    place = tmp_path / 'bag'
    place.mkdir()
    make.write_mcap(place / 'bag_0.mcap', entries[:200])
    (place / 'metadata.yaml').write_text(
        'rosbag2_bagfile_information:\n  relative_file_paths: [bag_0.mcap, bag_1.mcap]\n')
    found, loss = messages_of(place)
    assert found == expected(make, entries[:200])
    assert 'bag_1.mcap' in loss.text()


def test_a_damaged_database_gives_what_can_be_read_and_states_the_loss(tmp_path, make):
    entries = make.drive(20.0)
    place = tmp_path / 'bag'
    rosbag2_folder(make, place, entries, 'SQLITE3')
    path = next(place.glob('*.db3'))
    size = path.stat().st_size
    with open(path, 'r+b') as file:
        file.seek(size // 2 // 4096 * 4096)
        file.write(b'\xaa' * 65536)
    try:
        found, loss = messages_of(place)
    except BagError as error:
        assert 'readable' in str(error)
    else:
        assert loss.bytes > 0 or len(found) == len(entries)
        assert 'damaged' in loss.text()


@pytest.mark.parametrize('content, reason', [
    (b'', 'empty'), (b'hello, this is text', 'no MCAP'), (b'\x89MCAP0\r\n', 'no readable message'),
    (b'SQLite format 3\x00' + b'\0' * 50, 'rosbag2 database')])
def test_what_is_no_bag_is_refused_in_one_line(tmp_path, content, reason):
    path = tmp_path / 'x.mcap'
    path.write_bytes(content)
    with pytest.raises(BagError, match=reason) as caught:
        Bag(path)
    assert '\n' not in str(caught.value) and 'x.mcap' in str(caught.value)


def test_missing_paths_and_empty_folders_are_named(tmp_path):
    with pytest.raises(BagError, match='does not exist'):
        Bag(tmp_path / 'none.mcap')
    with pytest.raises(BagError, match='holds no bag'):
        Bag(tmp_path)


def test_a_bag_can_be_read_twice_and_counts_by_channel(tmp_path, make):
    path = make.write_mcap(tmp_path / 'a.mcap', make.drive())
    with Bag(path) as bag:
        first = sum(len(b) for b in bag.blocks())
        second = sum(len(b) for b in bag.blocks(lambda c: c.topic == '/imu/data_raw'))
        assert (first, second) == (400, 200)
        assert {c.topic: n for c, n in bag.counts.items()} == {
            '/imu/data_raw': 200, '/joint_states': 100, '/wheel_ticks': 100}
        assert bag.read_bytes == bag.piece_bytes


def test_the_database_fixture_is_what_ros_writes(tmp_path, make):
    """Guards the sqlite tests: the columns are those of rosbag2's schema."""
    place = tmp_path / 'bag'
    rosbag2_folder(make, place, make.drive(0.1), 'SQLITE3')
    base = sqlite3.connect(next(place.glob('*.db3')))
    columns = [row[1] for row in base.execute('PRAGMA table_info(messages)')]
    base.close()
    assert columns == ['id', 'topic_id', 'timestamp', 'data']


def test_memory_does_not_grow_with_the_length_of_a_recording(tmp_path, make):
    """Peak of reading and decoding, by Python's own count, for 4 s and for 32 s of data."""
    import tracemalloc

    def peak(seconds):
        path = make.write_mcap(tmp_path / f'{seconds}.mcap', make.drive(seconds),
                               chunk_size=50_000)
        reader = SampleReader(make.WHEELS, Topics(), lambda stream, reason: None)
        tracemalloc.start()
        try:
            with Bag(path) as bag:
                for block in bag.blocks():
                    reader.batch(block)
            return tracemalloc.get_traced_memory()[1], sum(reader.read.values())
        finally:
            tracemalloc.stop()

    peak(4)  # loads what is loaded once
    (short, few), (long, many) = peak(4), peak(32)
    assert many == 8 * few
    # all data at once would be 2 MB; the rest is the index of pieces, 0.5 kB for each chunk
    assert long < 1.25 * short + 50_000
