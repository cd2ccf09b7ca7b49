"""`mecanum replay`: run the estimator over a recording."""

from __future__ import annotations

import argparse
import atexit
import contextlib
import gc
import importlib.util
import os
import pathlib
import sys
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecanum_base.bag.export import BagExport

_FAST = 'MECANUM_BASE_FAST'  # environment variable: 1 asks for compiled kernels
_LONG = 15.0  # s of work that are worth a hint

HELP = 'run the estimator of the odometry node over a recorded bag; writes tracks and a summary'
EXAMPLE = 'mecanum replay run.mcap --robot config/mecanum4.yaml --out result'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the verb."""
    parser.add_argument('bag', nargs='+', metavar='BAG',
                        help='MCAP file or rosbag2 folder; several are read as one recording')
    parser.add_argument('--robot', required=True, metavar='FILE', help='robot file (YAML)')
    parser.add_argument('--out', required=True, metavar='DIR',
                        help='folder for odometry.tum, track.csv, slip.csv, the same as later '
                             'readings show it (track_smoothed.tum, track_smoothed.csv, '
                             'slip_smoothed.csv) and summary.json')
    parser.add_argument('--encoder-topic', metavar='T',
                        help='topic of the encoders (default: joint_states or wheel_ticks, as '
                             'the robot file says)')
    parser.add_argument('--imu-topic', metavar='T',
                        help='topic of the IMU (default: imu/data_raw)')
    parser.add_argument('--no-imu', action='store_true', help='leave the IMU out')
    parser.add_argument('--bag', dest='write_bag', action='store_true',
                        help='also write DIR/bag: the original topics with the new odometry and '
                             'slip beside them, for Foxglove or ros2 bag play')
    parser.add_argument('--parquet', action='store_true',
                        help='also write the four csv files as Parquet tables')


def run(options: argparse.Namespace) -> int:
    """Replay, write the files, print what was found."""
    # Modules and compiled code stay till the end: searching them for rubbish costs half a second
    gc.disable()
    atexit.register(gc.freeze)
    try:
        return _replay(options)
    finally:
        gc.enable()


def _replay(options: argparse.Namespace) -> int:
    if os.environ.get(_FAST) == '1':
        _prepare()
    from mecanum_base.bag.replay import Sink, replay_into
    from mecanum_base.bag.summary import summary_of, write_json
    from mecanum_base.bag.topics import Topics
    from mecanum_base.bag.track import SMOOTHED, TrackWriter
    from mecanum_base.cli.compiling import CompileNotice
    from mecanum_base.cli.progress import Progress
    from mecanum_base.core.errors import BagError
    from mecanum_base.core.estimation.acceleration import COMPILED
    from mecanum_base.core.estimation.prepared import BEFORE, CODE
    from mecanum_base.robot_file import load_robot
    robot = load_robot(options.robot)
    topics = Topics.of(robot, options.encoder_topic, options.imu_topic,
                       not options.no_imu)
    if options.parquet:
        import pyarrow.parquet  # noqa: F401  fail before the work, not after it
    out = pathlib.Path(options.out)
    exports: list[BagExport] = []

    def sink() -> Sink:
        track = TrackWriter(out, robot.base.joint, compiled=COMPILED)
        if not options.write_bag:
            return track
        from mecanum_base.bag.export import BagExport
        try:
            exports.append(BagExport(out / 'bag', robot, track))
        except BagError:  # there is one already
            track.close()
            raise
        return exports[0]

    with contextlib.ExitStack() as stack:
        notices: list[CompileNotice] = []

        def watch() -> None:
            notices.append(stack.enter_context(CompileNotice('mecanum replay')))
        if CODE:
            BEFORE.append(watch)
        elif COMPILED:
            watch()
        progress = stack.enter_context(Progress('replay'))
        begin: tuple[float, float] | None = None

        def step(share: float, seconds: float) -> None:
            nonlocal begin
            now = time.perf_counter()
            for notice in notices:
                notice.end()
            if begin is None:  # loading and compiling are over
                begin = now, seconds
                progress.mark(share)
                gc.enable()
                return
            rate = (seconds - begin[1]) / max(now - begin[0], 1e-9)
            progress.update(share, f'{rate:.0f} x real time')
        done = replay_into(options.bag, robot, sink, topics, step,
                           lambda: TrackWriter(out, robot.base.joint, SMOOTHED, COMPILED))
    summary = summary_of(done, topics, options.robot)
    write_json(out / 'summary.json', summary)
    for export in exports:
        for topic in export.complete(options.bag):
            print(f'mecanum replay: {topic} is not copied: its definition is not known',
                  file=sys.stderr)
    if options.parquet:
        from mecanum_base.bag.export import write_parquet
        write_parquet(out)
    if done.bag.loss:
        print(f'mecanum replay: {done.bag.loss.text()}', file=sys.stderr)
    for key in robot.ignored:
        print(f'mecanum replay: {options.robot}: {key} is not a block of a robot file',
              file=sys.stderr)
    for note in summary['notes']:
        print(f'note: {note}')
    pose = summary['final_pose'] or [0.0, 0.0, 0.0]
    print(f'{done.course.rows} poses over {summary["duration"]:.1f} s, '
          f'{summary["distance"]:.2f} m; end at x {pose[0]:.3f} m, y {pose[1]:.3f} m, '
          f'yaw {pose[2]:.3f} rad; {len(summary["slip_episodes"])} slip episodes; '
          f'{summary["run"]["times_real_time"]:.0f} times real time')
    print(f'written to {options.out}')
    if not COMPILED:
        _advise(done.wall_seconds)
    elif not CODE:  # numba was needed: not by the next one
        from mecanum_base.bag.machine_entry import keep
        if sys.stderr.isatty():
            print('mecanum replay: keeps the machine code for the next time', file=sys.stderr)
        keep()
    return 0


def _prepare() -> None:
    """Have machine code of an earlier process at hand, or else all of numba."""
    # All matrices are small, and the cores have other work: helpers of BLAS would only wait
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    sys.setswitchinterval(0.001)  # s: three threads take turns in Python, for short spells
    from mecanum_base.bag.machine_code import load
    from mecanum_base.cli.quick_start import load_blas, load_numba
    from mecanum_base.core.estimation.prepared import BEFORE
    imported = 'mecanum_base.core.estimation.acceleration' in sys.modules
    if not imported and not os.environ.get('NUMBA_DISABLE_JIT') and load():
        load_blas()
        BEFORE.append(load_numba)
    else:
        load_numba()


def _advise(seconds: float) -> None:
    """How to be faster next time: asked for in vain always, else on terminals after long waits."""
    asked = os.environ.get(_FAST) == '1'
    there = all(importlib.util.find_spec(name) is not None for name in ('numba', 'scipy'))
    install = '' if there else "pip install 'mecanum_base[fast]', then "
    if asked and not there:
        print("mecanum replay: MECANUM_BASE_FAST=1 has no effect: numba is not installed; pip "
              "install 'mecanum_base[fast]'", file=sys.stderr)
    elif not asked and seconds > _LONG and sys.stderr.isatty():
        print(f'hint: {install}MECANUM_BASE_FAST=1 mecanum replay ... is some fifteen times '
              'faster (its first run compiles for some minutes)', file=sys.stderr)
