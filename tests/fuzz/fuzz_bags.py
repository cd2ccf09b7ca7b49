"""Mutated recordings: no crash, no hang, bounded memory, and nothing is lost in silence.

    python tests/fuzz/fuzz_bags.py [--count 10000] [--seconds S] [--seed 1]

Each case takes a small valid bag, changes it (flipped bits, cuts, removed, doubled and swapped
stretches, lies in lengths, in times and in texts) and reads it as `mecanum replay` does. Allowed
are a BagError of one line, or messages. Where chunks carry checksums, every message that is read
must be one of the original, and if one is missing a loss must be stated.
"""

from __future__ import annotations

import argparse
import importlib.util
import pathlib
import resource
import signal
import sys
import tempfile
import time

import numpy as np

from mecanum_base.bag.analysis.recording import load
from mecanum_base.bag.reader import Bag
from mecanum_base.bag.stream import SampleReader
from mecanum_base.bag.topics import Topics
from mecanum_base.core.errors import BagError

SLOWEST = 20  # s a case may take on a busy machine
MEMORY = 3 << 30  # bytes of address space
GROWTH = 400 << 10  # kB the process may grow above its size at the start


class Silent(AssertionError):
    """Something was lost or changed and not stated."""


def builders():
    """The message builders of tests/bag/conftest.py."""
    path = pathlib.Path(__file__).parents[1] / 'bag' / 'conftest.py'
    spec = importlib.util.spec_from_file_location('bag_messages', path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def originals(folder):
    """[(path, strict)]: small bags of every kind; strict where every chunk has a checksum."""
    make = builders()
    entries = make.drive(1.0, 20, 40)
    at = make.T0 + 10**8
    entries += [('/ground_truth/odom', at + i * 10**7, make.odometry(at + i * 10**7, (0, 0, 0)))
                for i in range(20)]
    entries.append(('/set_pose', at, make.set_pose(at, (1, 2, 0.5))))
    entries.sort(key=lambda e: e[1])
    found = []
    for compression in ('none', 'lz4', 'zstd'):
        path = folder / f'{compression}.mcap'
        make.write_mcap(path, entries, compression, chunk_size=4096)
        found.append((path, True))
    make.write_mcap(folder / 'loose.mcap', entries, chunked=False)
    make.write_mcap(folder / 'plain.mcap', entries, 'zstd', chunk_size=4096, crc=False)
    found += [(folder / 'loose.mcap', False), (folder / 'plain.mcap', False)]
    from rosbags.rosbag2 import StoragePlugin, Writer
    with Writer(folder / 'sqlite', version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {}
        for topic, log, msg in entries:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msg.__msgtype__,
                                                           typestore=make.STORE)
            writer.write(connections[topic], int(log), make.serialized(msg))
    found.append((next((folder / 'sqlite').glob('*.db3')), False))
    return found


def mutated(data, generator):
    """A changed copy of the bytes."""
    raw = bytearray(data)
    kind = int(generator.integers(8))
    at = int(generator.integers(len(raw)))
    if kind == 0:
        for _ in range(int(generator.integers(1, 9))):
            raw[int(generator.integers(len(raw)))] ^= 1 << int(generator.integers(8))
    elif kind == 1:
        del raw[at:]
    elif kind == 2:
        del raw[at:at + int(generator.integers(1, 5000))]
    elif kind == 3:
        raw[at:at] = raw[at:at + int(generator.integers(1, 5000))]
    elif kind == 4:
        raw[at:at + int(generator.integers(1, 300))] = generator.bytes(
            int(generator.integers(1, 300)))
    elif kind == 5:  # a lie in a length, a time or a size: eight bytes of one extreme number
        value = int(generator.choice([0, 1, 2**31 - 1, 2**32 - 1, 2**40, 2**62, 2**63 - 1]))
        place = at
        marks = [i for i in range(max(0, at - 4000), at) if raw[i] in (3, 4, 5, 6)
                 and raw[i + 4:i + 9] == b'\0\0\0\0\0']
        if marks:  # behind the opcode of a record, or in the head of its content
            place = marks[-1] + 1 + 8 * int(generator.integers(0, 4))
        raw[place:place + 8] = value.to_bytes(8, 'little')
    elif kind == 6:
        size = int(generator.integers(1, 2000))
        other = int(generator.integers(len(raw)))
        raw[at:at + size], raw[other:other + size] = (raw[other:other + size], raw[at:at + size])
    else:
        words = [b'sensor_msgs/msg/Imu', b'sensor_msgs/msg/JointState', b'/joint_states', b'zstd',
                 b'lz4', b'std_msgs/msg/Int64MultiArray', b'cdr']
        word, new = (words[int(generator.integers(len(words)))] for _ in range(2))
        raw = bytearray(bytes(raw).replace(word, new.ljust(len(word))[:len(word)], 1))
    return bytes(raw)


def read(path):
    """({(topic, log, payload)}, loss) as replay reads, decoding included."""
    joints = builders_joints()
    rejected = []
    reader = SampleReader(joints, Topics(), lambda stream, reason: rejected.append(reason))
    found = []
    with Bag(path) as bag:
        for block in bag.blocks():
            for index in range(len(block)):
                found.append((block.channels[block.channel[index]].topic,
                              int(block.log_ns[index]), block.payload(index)))
            try:
                reader.batch(block)
            except BagError as error:
                assert '\n' not in str(error)
        return found, bag.loss


def builders_joints():
    return ('front_left_wheel_joint', 'front_right_wheel_joint', 'rear_left_wheel_joint',
            'rear_right_wheel_joint')


def check(path, strict, known):
    """Read one mutated file; raises whatever must not happen."""
    try:
        found, loss = read(str(path))
        load([str(path)])
    except BagError as error:
        if '\n' in str(error):
            raise AssertionError('more than one line') from error
        return 'refused'
    if strict:
        # names may come from a damaged summary where the chunk that holds them is lost
        contents = {k[1:] for k in known}
        strange = [f for f in found if f[1:] not in contents or (f not in known and not loss)]
        if strange:
            raise Silent(f'{len(strange)} messages that were never written')
        if len(set(found)) < len(known) and not loss:
            raise Silent(f'{len(known) - len(set(found))} messages missing, no loss stated')
    return 'loss stated' if loss else 'read'


def _too_long(signum, frame):
    raise TimeoutError(f'more than {SLOWEST} s')


def campaign(count, seconds, seed, folder, report=print):
    """Run until ``count`` cases or ``seconds`` are over; returns (cases, outcomes, failures)."""
    generator = np.random.default_rng(seed)
    bags = [(path, strict, path.read_bytes(), set(read(str(path))[0]))
            for path, strict in originals(folder)]
    end = time.monotonic() + seconds
    outcomes, failures, number = {}, [], 0
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    signal.signal(signal.SIGALRM, _too_long)
    while number < count and time.monotonic() < end:
        path, strict, data, known = bags[number % len(bags)]
        target = folder / f'case{path.suffix}'
        raw = mutated(data, generator)
        target.write_bytes(raw)
        signal.alarm(SLOWEST)
        try:
            result = check(target, strict, known)
        except (Exception, MemoryError) as error:
            result = f'FAILED: {type(error).__name__}: {error}'
            kept = folder / f'failure{len(failures)}{path.suffix}'
            kept.write_bytes(raw)
            failures.append((number, path.name, result))
            report(f'case {number} ({path.name}): {result}')
        finally:
            signal.alarm(0)
        outcomes[result.split(':')[0]] = outcomes.get(result.split(':')[0], 0) + 1
        number += 1
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    if grown > GROWTH:
        failures.append((number, '', f'memory grew by {grown} kB'))
    return number, outcomes, failures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--count', type=int, default=10_000)
    parser.add_argument('--seconds', type=float, default=1e9)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--keep', type=pathlib.Path, help='keep failing files in this folder')
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    with tempfile.TemporaryDirectory() as folder:
        place = options.keep or pathlib.Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        begin = time.monotonic()
        number, outcomes, failures = campaign(options.count, options.seconds, options.seed, place)
    print(f'{number} mutated bags in {time.monotonic() - begin:.0f} s: {outcomes}')
    for failure in failures:
        print('failure:', *failure)
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main())
