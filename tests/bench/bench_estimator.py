"""Cost of one estimator step, beside a Python loop of 1000 additions. Not a test: run it by hand.

    python tests/bench/bench_estimator.py [--seconds 60]

100 Hz encoders and 200 Hz IMU of four wheels, fed one sample after the other as the node does.
The base starts, cruises, stops and stands; with slip, a wheel or another spins half of the time.
A step is one IMU reading together with its half of the encoder frame: one frame and two IMU
samples are 2 steps. Per engine a process of its own; CPU time (other programs do not count),
median, mean and 99 % over the frames in microseconds, and in units of the loop
``s = 0.0; for i in range(1000): s += i * 0.5`` measured in the same process.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import time

import numpy as np

TESTS = pathlib.Path(__file__).resolve().parents[1]


def reference() -> float:
    """Microseconds of the loop, median of 200."""
    times = []
    for _ in range(200):
        begin = time.process_time()
        s = 0.0
        for i in range(1000):
            s += i * 0.5
        times.append(time.process_time() - begin)
    return 1e6 * statistics.median(times)


def measure(seconds: float) -> list[float]:
    """Loop, median, mean and 99 % of a step without and with slip, longest reading: microseconds.

    The longest is that of a slip found out by its end, which takes 2.5 s of readings once more.
    """
    sys.path.insert(0, str(TESTS / 'core' / 'estimation'))
    import staged_drive as staged

    legs = []
    while sum(leg[0] for leg in legs) < seconds:  # start, cruise along some curve, stop, stand
        k = len(legs)
        legs += [(4.0, (0.5 * math.sin(k), 0.3 * math.cos(2 * k), 0.4 * math.sin(3 * k))),
                 (1.5, (0.0, 0.0, 0.0))]
    motion = staged.staged(*legs)
    random = np.random.default_rng(1)
    loop, found = reference(), []
    for slipping in (False, True):
        angles = staged.wheel_angles(motion)
        if slipping:  # one wheel or another, half of the time
            for begin in np.arange(1.0, motion.t[-1] - 0.5, 1.0):
                extra = staged.summed((np.abs(motion.t - begin) < 0.25) * 8.0)
                angles[:, random.integers(4)] += extra
        samples = staged.merged(staged.imu(motion), staged.frames(motion, angles))
        subject = staged.estimator()
        for sample in samples[:300]:  # arming, compiling
            subject.handle(sample)
        times = []
        for k in range(300, len(samples) - 3, 3):
            begin = time.process_time()
            subject.handle(samples[k])
            subject.handle(samples[k + 1])
            subject.handle(samples[k + 2])
            times.append(0.5 * (time.process_time() - begin))
        found += [1e6 * statistics.median(times), 1e6 * statistics.mean(times),
                  1e6 * float(np.quantile(times, 0.99))]
    motion, angles, _, _ = staged.unloaded(0.05, 0.1)
    subject, longest = staged.estimator(), 0.0
    for sample in staged.merged(staged.imu(motion), staged.frames(motion, angles)):
        begin = time.process_time()
        subject.handle(sample)
        longest = max(longest, time.process_time() - begin)
    return [0.5 * (loop + reference()), *found, 1e6 * longest]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog='example: '
                                     'python tests/bench/bench_estimator.py --seconds 20')
    parser.add_argument('--seconds', type=float, default=60.0, help='length of the synthetic data')
    parser.add_argument('--one', action='store_true', help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.seconds)))
        return
    engines = {'plain': '0'}
    if importlib.util.find_spec('numba') is not None:
        engines['numba'] = '1'
    print(f'Python {platform.python_version()}, numpy {np.__version__}, {platform.machine()}, '
          f'{options.seconds:g} s of data')
    print(f'{"engine":8}{"data":10}{"loop us":>8}{"median us":>11}{"loops":>7}{"mean us":>9}'
          f'{"loops":>7}{"99 % us":>9}{"loops":>7}')
    for engine, switch in engines.items():
        done = subprocess.run(
            [sys.executable, __file__, '--one', '--seconds', str(options.seconds)],
            env={**os.environ, 'MECANUM_BASE_FAST': switch}, stdout=subprocess.PIPE, text=True,
            check=True)
        loop, *values = json.loads(done.stdout)
        for name, row in (('no slip', values[:3]), ('slipping', values[3:6])):
            median, mean, most = row
            print(f'{engine:8}{name:10}{loop:8.1f}{median:11.1f}{median / loop:7.2f}{mean:9.1f}'
                  f'{mean / loop:7.2f}{most:9.1f}{most / loop:7.2f}')
        print(f'{engine:8}longest reading, 2.5 s taken once more: {values[6] / 1000:.0f} ms')


if __name__ == '__main__':
    main()
