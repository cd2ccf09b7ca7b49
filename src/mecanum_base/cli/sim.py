"""Verb ``sim``: simulated hardware, as a node or headless into a bag, and its picture book."""

from __future__ import annotations

import argparse
import pathlib
import time

from mecanum_base.cli.node_arguments import add_robot, words_for_ros
from mecanum_base.core.errors import ConfigError

HELP = ('simulated hardware: without --scenario the sim node; with it, a headless run into an '
        'MCAP bag with truth, as fast as this computer can')
EXAMPLE = """mecanum sim --robot robot.yaml
mecanum sim --scenario oil --out oil_run --seed 7
mecanum sim --list
mecanum sim --keys
mecanum sim --gallery --out gallery"""
PASSES_ROS_ARGUMENTS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    add_robot(parser)
    parser.add_argument('--scenario', metavar='NAME', help='shipped scenario or scenario file: '
                        'run it headless')
    parser.add_argument('--out', metavar='DIR', help='folder for the bag, the truth and copies of '
                        'robot and scenario file')
    parser.add_argument('--seed', type=int, metavar='N', help='seed instead of the scenario\'s')
    parser.add_argument('--duration', type=float, metavar='S', help='seconds instead of the '
                        'scenario\'s')
    parser.add_argument('--list', action='store_true', help='name the shipped scenarios')
    parser.add_argument('--keys', action='store_true', help='explain every key of a scenario '
                        'file')
    parser.add_argument('--gallery', action='store_true', help='run every shipped scenario and '
                        'draw it into one HTML page')


def run(options: argparse.Namespace) -> int:
    """Run what the options ask for."""
    if options.list:
        return _list()
    if options.keys:
        from mecanum_base.cli.scenario_keys import describe
        print(describe())
        return 0
    if options.scenario is None and not options.gallery:
        for name in ('out', 'seed', 'duration'):
            if getattr(options, name) is not None:
                raise ConfigError(f'--{name}', getattr(options, name),
                                  'needs --scenario (the node has the parameters sim.*)')
        from mecanum_base.ros.sim_node import main
        return main(words_for_ros(options))
    if options.ros_arguments:
        raise ConfigError(options.ros_arguments[0], None, 'is no option of a headless run')
    if options.out is None:
        raise ConfigError.missing('--out', 'folder for the results')
    if options.duration is not None and not 0.0 < options.duration < 1e6:
        raise ConfigError('--duration', options.duration, 'must be > 0', 's')
    if options.seed is not None and options.seed < 0:
        raise ConfigError('--seed', options.seed, 'must be >= 0')
    return _gallery(options) if options.gallery else _headless(options)


def _list() -> int:
    from mecanum_base.sim.scenario_file import load_scenario, shipped_scenarios
    shipped = shipped_scenarios()
    width = max(map(len, shipped), default=0)
    for name in shipped:
        scenario = load_scenario(name)
        print(f'{name:<{width}}  {scenario.duration:6.0f} s  {scenario.title}')
    return 0


def _headless(options: argparse.Namespace) -> int:
    from mecanum_base.bag.simulated import write_run
    from mecanum_base.cli.progress import Progress
    from mecanum_base.robot_file import load_robot, read_text
    from mecanum_base.sim.headless import Headless
    from mecanum_base.sim.scenario_file import find_scenario, load_scenario
    scenario = load_scenario(options.scenario)
    robot_path = robot_of(scenario.robot, options.scenario, options.robot)
    robot, out = load_robot(robot_path), pathlib.Path(options.out)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise ConfigError('--out', str(out), 'exists already and is not overwritten')
    headless = Headless(scenario, robot.base, robot.encoder, robot.imu, robot.sim,
                        seed=options.seed, duration=options.duration)
    out.mkdir(parents=True, exist_ok=True)
    (out / 'robot.yaml').write_text(read_text(robot_path), encoding='utf-8')
    (out / 'scenario.yaml').write_text(read_text(find_scenario(options.scenario)),
                                       encoding='utf-8')
    begin = time.perf_counter()
    seconds = (headless.end_ns - headless.start_ns) / 1e9
    with Progress(scenario.name) as progress:
        count, last = write_run(headless, robot, out,
                                lambda share: progress.update(share, _pace(seconds * share,
                                                                           begin)))
    x, y, yaw = last.pose if last is not None else (0.0, 0.0, 0.0)
    print(f'{scenario.name}, seed {headless.seed}: {seconds:.1f} s, {count} readings, '
          f'true end at x {x:.3f} m, y {y:.3f} m, yaw {yaw:.3f} rad; {_pace(seconds, begin)}')
    print(f'written to {out}: bag, truth.tum, truth.csv, robot.yaml, scenario.yaml')
    return 0


def _pace(seconds: float, begin: float) -> str:
    return f'{seconds / max(time.perf_counter() - begin, 1e-9):.0f} times real time'


def robot_of(name: str, scenario: str, given: str | None) -> pathlib.Path:
    """The robot file: the one given, else that beside the scenario file, else a shipped one."""
    from mecanum_base.robot_file import shipped
    from mecanum_base.sim.scenario_file import find_scenario
    beside = find_scenario(scenario).parent / name
    return pathlib.Path(given) if given else beside if beside.is_file() else shipped() / name


def _gallery(options: argparse.Namespace) -> int:
    from mecanum_base.cli.progress import Progress
    from mecanum_base.report.gallery import write_gallery
    from mecanum_base.sim.scenario_file import load_scenario
    robot = options.robot
    if options.scenario is not None:
        robot = str(robot_of(load_scenario(options.scenario).robot, options.scenario, robot))
    with Progress('gallery') as progress:
        page = write_gallery(pathlib.Path(options.out), options.scenario, options.seed,
                             options.duration, robot, progress.update)
    print(f'written to {page}')
    return 0
