"""The command line of the Monte Carlo run: scenarios x seeds over a pool of processes."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import pathlib
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed

from mecanum_base.accuracy.summary import figures_of
from mecanum_base.accuracy.table import as_mapping, tables
from mecanum_base.accuracy.trial import Trial, run_trial
from mecanum_base.cli.progress import Progress
from mecanum_base.core.errors import ConfigError, MecanumBaseError
from mecanum_base.sim.scenario_file import find_scenario, load_scenario

DEFAULT = ('square', 'circle_spin', 'figure8', 'strafe', 'slope', 'carpet_tile', 'uneven',
           'hard_accel', 'oil', 'ice_lane', 'wheel_lift', 'wheel_jam', 'pushed', 'collision',
           'warehouse')
FIRST_SEED = 7000  # far from the seeds of the scenario files, which serve for development
QUICK = (('ice_lane',), 2, 13.0)  # scenarios, seeds, seconds
_EXAMPLE = """example:
  python -m mecanum_base.accuracy --out out/accuracy
  python -m mecanum_base.accuracy --out out/oil --scenarios oil,pushed --seeds 5 --workers 2
"""


def parser() -> argparse.ArgumentParser:
    """The options."""
    found = argparse.ArgumentParser(
        prog='python -m mecanum_base.accuracy', epilog=_EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description='Monte Carlo accuracy of the odometry: every scenario with many seeds, each '
        'with a true robot that differs from the robot file, ours against dead reckoning, a '
        'robot_localization-style filter and oracles. Writes accuracy.md and accuracy.json.')
    found.add_argument('--out', type=pathlib.Path, required=True, help='folder of the results')
    found.add_argument('--scenarios', default='', help='names or files, comma separated '
                       f'(default: {",".join(DEFAULT)})')
    found.add_argument('--seeds', type=int, default=20, help='runs a scenario (default 20)')
    found.add_argument('--first-seed', type=int, default=FIRST_SEED,
                       help=f'the seeds count up from here (default {FIRST_SEED})')
    found.add_argument('--workers', type=int, default=os.cpu_count() or 1,
                       help='processes (default: one a core)')
    found.add_argument('--told', action='store_true', help='run ours once more, told how well the '
                       'simulated robots are built: column "told" beside its NEES')
    found.add_argument('--quick', action='store_true',
                       help='a short slice that shows that everything works')
    found.add_argument('--json', type=pathlib.Path, help='write the figures here as well')
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run it; returns the exit code (2 for wrong input)."""
    options = parser().parse_args(arguments)
    try:
        return _run(options)
    except (MecanumBaseError, OSError) as error:
        print(f'accuracy: {error}', file=sys.stderr)
        return 2


def _run(options: argparse.Namespace) -> int:
    names = tuple(n for n in options.scenarios.split(',') if n) or DEFAULT
    seeds, duration = options.seeds, None
    if options.quick:
        quick, seeds, duration = QUICK
        names = quick if not options.scenarios else names
    for key, value, least in (('seeds', seeds, 1), ('workers', options.workers, 1),
                              ('first-seed', options.first_seed, 0)):
        if value < least:
            raise ConfigError(f'--{key}', value, f'must be >= {least}')
    names = tuple(dict.fromkeys(names))
    for name in names:
        find_scenario(name)
    options.out.mkdir(parents=True, exist_ok=True)
    tasks = [(name, options.first_seed + k, duration, options.told)
             for name in names for k in range(seeds)]
    trials = _trials(tasks, options.workers)
    figures = [figures_of([trials[task] for task in tasks if task[0] == name]) for name in names]
    setting = {'scenarios': list(names), 'seeds': seeds, 'first_seed': options.first_seed,
               'seconds': duration, 'told': options.told}
    text = tables(figures)
    head = (f'{seeds} seeds a scenario, {options.first_seed} to '
            f'{options.first_seed + seeds - 1}.\n\n')
    (options.out / 'accuracy.md').write_text(head + text, encoding='utf-8')
    document = json.dumps(as_mapping(figures, setting), indent=1, allow_nan=False) + '\n'
    for path in filter(None, (options.out / 'accuracy.json', options.json)):
        path.write_text(document, encoding='utf-8')
    print(head + text, end='')
    return 0


Task = tuple[str, int, 'float | None', bool]


def _trials(tasks: Sequence[Task], workers: int) -> dict[Task, Trial]:
    """All trials; which process runs which, and when, changes nothing in them."""
    found: dict[Task, Trial] = {}
    seconds = {task: task[2] or load_scenario(task[0]).duration for task in tasks}
    order = sorted(tasks, key=lambda task: -seconds[task])  # long ones first: no lone straggler
    total, done = sum(seconds.values()), 0.0
    with Progress('accuracy') as progress:
        if workers == 1 or len(tasks) == 1:
            for task in order:
                found[task] = run_trial(*task)
                done += seconds[task]
                progress.update(done / total, f'{task[0]} {task[1]}')
            return found
        context = multiprocessing.get_context('spawn')  # the same on every platform
        with ProcessPoolExecutor(min(workers, len(tasks)), context) as pool:
            waiting = {pool.submit(run_trial, *task): task for task in order}
            try:
                for future in as_completed(waiting):
                    task = waiting[future]
                    found[task] = future.result()
                    done += seconds[task]
                    progress.update(done / total, f'{task[0]} {task[1]}')
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
    return found
