"""mecanum demo: the main job end to end over ROS 2 topics."""

from __future__ import annotations

import argparse
import math
import os
import pathlib
import time

from mecanum_base.cli.progress import Progress

HELP = ('Drive a simulated base over ROS 2 topics in stepped time: cmd_vel to wheel speeds, '
        'simulated hardware, odometry and slip, compared with the truth.')
EXAMPLE = """
mecanum demo                          the lap: square, spin, strafe, oil; results in out/demo
mecanum demo --scenario oil --out out/oil
mecanum demo --scenario circle_spin --robot config/dual_differential.yaml
mecanum demo --list
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of this verb."""
    parser.add_argument('--scenario', default='lap', help='name of a shipped scenario or a file')
    parser.add_argument('--robot', help='robot file (default: the one the scenario names, beside '
                        'the scenario file or shipped)')
    parser.add_argument('--out', default=os.path.join('out', 'demo'), help='folder for bag, '
                        'picture and page (default: %(default)s)')
    parser.add_argument('--seed', type=int, help='seed of every random number')
    parser.add_argument('--headless', action='store_true',
                        help='only the table: no picture, no page')
    circle = parser.add_argument_group('the experiment circle_spin (goal_node drives)')
    circle.add_argument('--radius', type=float, default=0.25, help='m (default: %(default)s)')
    circle.add_argument('--angular-rate', type=float, default=math.pi / 7.0,
                        help='rad/s round the circle (default: pi/7)')
    circle.add_argument('--spin', type=float, default=math.pi / 30.0,
                        help='rad/s of the base (default: pi/30)')
    parser.add_argument('--list', action='store_true', help='name the scenarios and end')


def run(options: argparse.Namespace) -> int:
    """Perform the scenario, read its bag and show the comparison."""
    from mecanum_base.robot_file import read_parameters
    from mecanum_base.sim.scenario_file import find_scenario, load_scenario, shipped_scenarios

    if options.list:
        for name in shipped_scenarios():
            print(f'{name:<14} {load_scenario(name).title}')
        return 0
    from mecanum_base.cli.sim import robot_of
    from mecanum_base.core.command.trajectory import CircleSpin
    from mecanum_base.demo.experiment import NAME, Experiment
    from mecanum_base.demo.recording import read_result
    from mecanum_base.demo.stage import START_NS, perform, phases
    from mecanum_base.demo.table import table
    from mecanum_base.robot import Robot

    scenario = load_scenario(options.scenario)
    if options.seed is not None:
        scenario = scenario.replace(seed=options.seed)
    path = robot_of(scenario.robot, options.scenario, options.robot)
    parameters = read_parameters(path)
    robot = Robot.from_mapping(parameters)
    out = pathlib.Path(options.out)
    bag = _new_bag(out)
    print(f'demo {scenario.name}: {scenario.title}', flush=True)
    begin = time.monotonic()
    experiment = None
    if scenario.name == NAME:
        experiment = Experiment(
            CircleSpin(options.radius, options.angular_rate, options.spin), START_NS)
    with Progress('driving') as progress:
        perform(scenario, find_scenario(options.scenario), parameters, bag, progress.update,
                experiment)
    result = read_result(bag, robot, scenario.name, phases(scenario))
    print(table(result))
    if experiment is not None:
        print('\n'.join(experiment.lines(result, robot)))
    print()
    if not options.headless:
        from mecanum_base.demo.page import write_demo_page
        from mecanum_base.demo.picture import write_picture

        write_picture(out / 'demo.png', result)
        write_demo_page(out / 'demo.html', result)
        print(f'picture  {out / "demo.png"}')
        print(f'page     {out / "demo.html"}')
    print(f'bag      {bag}')
    print(f'robot    {path}')
    print(f'{time.monotonic() - begin:.0f} s of computing')
    return 0


def _new_bag(out: pathlib.Path) -> pathlib.Path:
    """The first free folder name below ``out``: earlier bags stay."""
    out.mkdir(parents=True, exist_ok=True)
    number = 1
    while (out / f'bag_{number}').exists():
        number += 1
    return out / f'bag_{number}'
