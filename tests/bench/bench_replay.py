"""Speed of ``mecanum replay`` as a multiple of real time. Not a test: run it by hand.

    python tests/bench/bench_replay.py [--seconds 300]

Whole processes, start and imports included, over one generated bag of 100 Hz joint_states and
200 Hz Imu: the replay (estimator, four files written), beside programs that merely decode the same
messages with rosbags and merely read their records with mcap. Wall time of one run each.
"""

from __future__ import annotations

import argparse
import math
import os
import pathlib
import platform
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROBOT = ROOT / 'config' / 'mecanum4.yaml'
ROSBAGS = """
import pathlib, sys
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
with AnyReader([pathlib.Path(sys.argv[1])],
               default_typestore=get_typestore(Stores.ROS2_JAZZY)) as bag:
    print(sum(1 for c, _, raw in bag.messages() if bag.deserialize(raw, c.msgtype)))
"""
MCAP = """
import pathlib, sys
from mcap.reader import make_reader
total = 0
for path in sorted(pathlib.Path(sys.argv[1]).glob('*.mcap')):
    with path.open('rb') as stream:
        total += sum(1 for _ in make_reader(stream).iter_messages())
print(total)
"""


def generate(folder: pathlib.Path, seconds: float) -> int:
    """Write the bag; the number of its messages."""
    sys.path.insert(0, str(ROOT / 'tests' / 'core' / 'estimation'))
    import staged_drive as staged

    from mecanum_base.bag.simulated import SimulatedBag
    from mecanum_base.robot_file import load_robot

    legs = []
    while sum(leg[0] for leg in legs) < seconds:
        k = len(legs)
        legs.append((2.5, (0.5 * math.sin(k), 0.4 * math.cos(2 * k), 0.8 * math.sin(3 * k))))
    motion = staged.staged(*legs)
    angles = staged.wheel_angles(motion)
    random = np.random.default_rng(1)
    for begin in np.arange(10.0, motion.t[-1] - 2.0, 10.0):  # a slip every ten seconds
        extra = staged.summed((np.abs(motion.t - begin) < 0.2) * 6.0)
        angles[:, random.integers(4)] += extra
    samples = staged.merged(staged.imu(motion, xyz=(0.05, 0.0, 0.0)),
                            staged.frames(motion, angles))
    bag = SimulatedBag(folder, load_robot(ROBOT))
    for sample in samples:
        bag.reading(sample.stamp_ns, sample)
    bag.close()
    return len(samples)


def spent(command: list[str], environment: dict[str, str]) -> float:
    """Wall seconds of a process."""
    begin = time.perf_counter()
    subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, check=True)
    return time.perf_counter() - begin


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog='example: '
                                     'python tests/bench/bench_replay.py --seconds 60')
    parser.add_argument('--seconds', type=float, default=300.0, help='length of the bag')
    seconds = parser.parse_args().seconds
    with tempfile.TemporaryDirectory() as scratch:
        bag, out = pathlib.Path(scratch, 'bag'), pathlib.Path(scratch, 'out')
        count = generate(bag, seconds)
        size = sum(path.stat().st_size for path in bag.iterdir()) / 1e6
        print(f'Python {platform.python_version()}, numpy {np.__version__}, '
              f'{platform.machine()}: {seconds:g} s, {count} messages, {size:.1f} MB')
        replay = [sys.executable, '-m', 'mecanum_base', 'replay', str(bag), '--robot', str(ROBOT),
                  '--out', str(out)]
        plain = {**os.environ, 'MECANUM_BASE_FAST': '0'}
        rows = [('mecanum replay', replay, plain)]
        try:
            import numba  # noqa: F401
        except ImportError:
            pass
        else:
            fast = {**os.environ, 'MECANUM_BASE_FAST': '1'}
            rows.append(('mecanum replay, numba', replay, fast))
        rows += [('rosbags, decoding alone', [sys.executable, '-c', ROSBAGS, str(bag)], plain),
                 ('mcap, reading alone', [sys.executable, '-c', MCAP, str(bag)], plain)]
        print(f'{"process":26}{"s":>7}{"x real time":>13}{"us a message":>14}')
        for name, command, environment in rows:
            wall = spent(command, environment)
            print(f'{name:26}{wall:7.2f}{seconds / wall:13.0f}{1e6 * wall / count:14.1f}')


if __name__ == '__main__':
    main()
