"""`mecanum replay`: run the estimator over a recording."""

from __future__ import annotations

import argparse
import pathlib
import sys
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecanum_base.bag.export import BagExport

HELP = 'run the estimator of the odometry node over a recorded bag; writes tracks and a summary'
EXAMPLE = 'mecanum replay run.mcap --robot config/mecanum4.yaml --out result'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the verb."""
    parser.add_argument('bag', nargs='+', metavar='BAG',
                        help='MCAP file or rosbag2 folder; several are read as one recording')
    parser.add_argument('--robot', required=True, metavar='FILE', help='robot file (YAML)')
    parser.add_argument('--out', required=True, metavar='DIR',
                        help='folder for odometry.tum, track.csv, slip.csv, summary.json')
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
                        help='also write track.parquet and slip.parquet')


def run(options: argparse.Namespace) -> int:
    """Replay, write the files, print what was found."""
    from mecanum_base.bag.replay import Sink, replay_into
    from mecanum_base.bag.summary import summary_of, write_json
    from mecanum_base.bag.topics import Topics
    from mecanum_base.bag.track import TrackWriter
    from mecanum_base.cli.progress import Progress
    from mecanum_base.robot_file import load_robot
    robot = load_robot(options.robot)
    topics = Topics.of(robot, options.encoder_topic, options.imu_topic,
                       not options.no_imu)
    if options.parquet:
        import pyarrow.parquet  # noqa: F401  fail before the work, not after it
    begin = time.perf_counter()
    out = pathlib.Path(options.out)
    exports: list[BagExport] = []

    def sink() -> Sink:
        track = TrackWriter(out, robot.base.joint)
        if not options.write_bag:
            return track
        from mecanum_base.bag.export import BagExport
        exports.append(BagExport(out / 'bag', robot, track))
        return exports[0]

    with Progress('replay') as progress:
        def step(share: float, seconds: float) -> None:
            rate = seconds / max(time.perf_counter() - begin, 1e-9)
            progress.update(share, f'{rate:.0f} x real time')
        done = replay_into(options.bag, robot, sink, topics, step)
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
    return 0
