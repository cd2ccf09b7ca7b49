"""Replay speed: the whole process against others that merely decode the same bag, in one run.

    python tests/bench/bench_replay.py [--seconds 600 3600] [--best-of 2]
                                       [--doc docs/recordings.md]

The bag holds encoders at 100 Hz and an IMU at 200 Hz. Given are wall and processor time of the
whole process, start to end, the multiple of real time, and its largest memory. Of several runs the
one with the least wall time counts; on a busy machine the processor time tells more. Of bags
beyond the first only the replay in fast mode is timed. All run with the bytecode of their modules
cached, as it is after an ordinary installation.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile
import time

BAG_TESTS = pathlib.Path(__file__).parents[1] / 'bag'

OTHERS = {
    'rosbags, decoding only': '''
import sys, pathlib
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
with AnyReader([pathlib.Path(sys.argv[1])],
               default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
    count = 0
    for connection, log, data in reader.messages():
        reader.deserialize(data, connection.msgtype)
        count += 1
''',
    'mcap-ros2-support, decoding only': '''
import sys
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
with open(sys.argv[1], 'rb') as file:
    for item in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
        pass
''',
    'ours, decoding only': '''
import sys
from mecanum_base.bag.reader import Bag
from mecanum_base.bag.stream import SampleReader
from mecanum_base.bag.topics import Topics
joints = tuple(f'{a}_{b}_wheel_joint' for a in ('front', 'rear') for b in ('left', 'right'))
reader = SampleReader(joints, Topics(), print)
with Bag(sys.argv[1]) as bag:
    for block in bag.blocks():
        reader.batch(block)
''',
}


def _load(name):
    spec = importlib.util.spec_from_file_location(name, BAG_TESTS / f'{name}.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def make_bag(folder, seconds):
    """A rosbag2 folder with real definitions, so that every reader can decode it."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    make, driving = _load('conftest'), _load('driving')
    made = driving.drive(seed=1, seconds=seconds)
    entries = [('/joint_states', int(s), make.joint_state(int(s), a))
               for s, a in zip(made.wheel_ns, made.angle)]
    entries += [('/imu/data_raw', int(s), make.imu(int(s), g, a))
                for s, g, a in zip(made.imu_ns, made.gyro, made.accel)]
    writer = Writer(folder / 'bag', version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=make.STORE)
                       for topic, kind in (('/joint_states', 'sensor_msgs/msg/JointState'),
                                           ('/imu/data_raw', 'sensor_msgs/msg/Imu'))}
        for topic, log, msg in sorted(entries, key=lambda e: e[1]):
            writer.write(connections[topic], log, make.serialized(msg))
    (folder / 'robot.yaml').write_text(driving.YAML)
    (folder / 'count').write_text(str(len(entries)))


def timed(command, fast=False):
    """(wall s, processor s, MB) of a process; None and the reason where it fails."""
    environment = {name: value for name, value in os.environ.items()
                   if name != 'PYTHONDONTWRITEBYTECODE'}
    environment['MECANUM_BASE_FAST'] = '1' if fast else '0'
    begin = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               env=environment)
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - begin
    text = process.stderr.read().decode()
    process.stderr.close()
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        return None, text.strip().splitlines()[-1] if text.strip() else 'failed'
    return (wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024), ''


def best(command, fast, runs, out):
    """The quickest of some runs; each makes the folder ``out`` anew."""
    found = []
    for _ in range(runs):
        shutil.rmtree(out, ignore_errors=True)
        found.append(timed(command, fast))
    good = [item for item in found if item[0] is not None]
    return min(good) if good else found[0]


def measured(seconds, runs_of_each, whole):
    """Lines of the table for one length of bag; all runs if ``whole``, else the fast one."""
    rows = []
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place)
        # made in a process of its own: what the parent used would count as memory of its children
        subprocess.run([sys.executable, __file__, '--make', place, '--seconds', str(seconds)],
                       check=True)
        bag, count = folder / 'bag' / 'bag.mcap', int((folder / 'count').read_text())
        print(f'{seconds:.0f} s of data, {count} messages, {bag.stat().st_size / 1e6:.1f} MB')
        replay = [sys.executable, '-m', 'mecanum_base', 'replay', str(bag), '--robot',
                  str(folder / 'robot.yaml'), '--out', str(folder / 'out')]
        runs = {'mecanum replay, plain': (replay, False)} if whole else {}
        if importlib.util.find_spec('numba') is not None:
            wall = timed(replay, True)[0][0]
            print(f'fast mode, first run: {wall:.0f} s (compiles where no cache is)')
            runs['mecanum replay, MECANUM_BASE_FAST=1'] = (replay, True)
        if whole:
            runs.update({name: ([sys.executable, '-c', code, str(bag)], False)
                         for name, code in OTHERS.items()})
        print(f'{"":36s} {"wall s":>8s} {"cpu s":>8s} {"x real time":>12s} {"MB":>6s}')
        for name, (command, fast) in runs.items():
            found, why = best(command, fast, runs_of_each, folder / 'out')
            if found is None:
                print(f'{name:36s} not run: {why}')
                continue
            wall, cpu, memory = found
            print(f'{name:36s} {wall:8.2f} {cpu:8.2f} {seconds / wall:12.0f} {memory:6.0f}',
                  flush=True)
            rows.append(f'| {name} | {seconds:.0f} | {wall:.1f} | {cpu:.1f} '
                        f'| {seconds / wall:.0f} | {memory:.0f} |')
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, nargs='+', default=[600.0],
                        help='length of the recording, or of several')
    parser.add_argument('--best-of', type=int, default=2, help='runs of each')
    parser.add_argument('--doc', type=pathlib.Path, help='document to put the table into')
    parser.add_argument('--make', metavar='DIR', help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.make:
        make_bag(pathlib.Path(options.make), options.seconds[0])
        return 0
    load = os.getloadavg()[0]
    print(f'Python {platform.python_version()}, {os.cpu_count()} cores, load {load:.1f}')
    rows = [row for number, seconds in enumerate(options.seconds)
            for row in measured(seconds, options.best_of, number == 0)]
    if options.doc:
        put(options.doc, '\n'.join([
            f'300 messages a second; {os.cpu_count()} cores, load of the computer {load:.1f}', '',
            '| | data s | wall s | cpu s | x real time | MB |',
            '| --- | --- | --- | --- | --- | --- |', *rows]))
    return 0


def put(doc, table):
    """Replace what stands between the marks of a document."""
    begin, end = '<!-- benchmark -->\n', '<!-- end of benchmark -->'
    head, rest = doc.read_text().split(begin)
    doc.write_text(head + begin + table + '\n' + end + rest.split(end)[1])


if __name__ == '__main__':
    sys.exit(main())
