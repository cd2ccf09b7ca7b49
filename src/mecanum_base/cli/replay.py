"""`mecanum replay`: run the estimator over a recording."""

from __future__ import annotations

import argparse
import pathlib
import sys
import time

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


def run(options: argparse.Namespace) -> int:
    """Replay, write the files, print what was found."""
    from mecanum_base.bag.replay import replay
    from mecanum_base.bag.summary import summary_of, write_json
    from mecanum_base.bag.topics import Topics
    from mecanum_base.cli.progress import Progress
    from mecanum_base.robot_file import load_robot
    robot = load_robot(options.robot)
    topics = Topics.of(robot, options.encoder_topic, options.imu_topic,
                       not options.no_imu)
    begin = time.perf_counter()
    with Progress('replay') as progress:
        def step(share: float, seconds: float) -> None:
            rate = seconds / max(time.perf_counter() - begin, 1e-9)
            progress.update(share, f'{rate:.0f} x real time')
        done = replay(options.bag, robot, options.out, topics, step)
    summary = summary_of(done, topics, options.robot)
    write_json(pathlib.Path(options.out) / 'summary.json', summary)
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
