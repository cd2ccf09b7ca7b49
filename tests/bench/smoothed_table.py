"""The smoothed track against the causal one and the truth, over simulated scenarios.

    python tests/bench/smoothed_table.py [NAME ...] [--seeds 100-102] [--doc FILE]

Velocity is compared ten times a second, pose and slip at every sample of the truth; slip is scored
as in `make accuracy`. The table goes to standard output, or between the marks of the document.
"""

from __future__ import annotations

import argparse
import math
import pathlib

import numpy as np

from mecanum_base.accuracy.drift import at_stamps, drift_of
from mecanum_base.accuracy.slip_score import ON, score_of
from mecanum_base.accuracy.track import Track
from mecanum_base.cli.progress import Progress
from mecanum_base.core.estimation.estimator import Estimator
from mecanum_base.core.estimation.geometry import travel_per_radian
from mecanum_base.core.records import TickSample, WheelSample
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.headless import run
from mecanum_base.sim.scenario_file import load_scenario

NAMES = ('square', 'circle_spin', 'figure8', 'strafe', 'lap', 'carpet_tile', 'hallway', 'pushed',
         'wheel_jam', 'wheel_lift', 'uneven', 'slope', 'hard_accel', 'oil', 'ice_lane',
         'collision')
SPARSE = 10  # every tenth sample of the truth for velocities
MARK = 'smoothed'
HEAD = '''| scenario | velocity, mm/s | while slipping | slip F1 | latency, ms | position, mm |
|---|---|---|---|---|---|'''


def figures(simulated, speed, stamp_ns, pose, velocity, body, wheel):
    """Squared errors and slip score of one track (R rows) of a run."""
    inside = (simulated.stamp_ns >= stamp_ns[0]) & (simulated.stamp_ns <= stamp_ns[-1])
    stamp = simulated.stamp_ns[inside]
    drift = drift_of(at_stamps(Track(stamp_ns, pose), stamp), simulated.pose[inside])
    seconds, own = (stamp - stamp[0]) * 1e-9, (stamp_ns - stamp[0]) * 1e-9
    error = np.column_stack([np.interp(seconds[::SPARSE], own, velocity[:, i])
                             - simulated.twist[inside][::SPARSE, i] for i in (0, 1)])
    square = np.sum(error ** 2, axis=1)
    slips = np.abs(speed[inside][::SPARSE]).max(axis=1) > ON
    row = np.searchsorted(stamp_ns, stamp, side='right') - 1
    score = score_of(seconds, speed[inside], body[row], wheel[row], ())
    return drift.squares, drift.samples, square, square[slips], score


def compared(name, seed):
    """Figures of the causal and of the smoothed track of one run."""
    scenario = load_scenario(name)
    robot = load_robot(shipped() / scenario.robot)
    simulated = run(scenario, robot.base, robot.encoder, robot.imu, robot.sim, seed=seed)
    unused = TickSample if robot.encoder.source == 'joint_states' else WheelSample
    estimator = Estimator(robot.base, robot.encoder, robot.imu, robot.estimator, smoothed=True)
    found = []
    with np.errstate(all='ignore'):
        for sample in simulated.samples(commands=False):
            if not isinstance(sample, unused):
                found += estimator.handle(sample)
        found += estimator.flush()
    past = [piece.smoothed() for piece in estimator.past(last=True)]
    stamp_ns, track, slip = (np.concatenate([getattr(part, name) for part in past])
                             for name in ('stamp_ns', 'track', 'slip'))
    speed = simulated.slip_rate * travel_per_radian(robot.base)
    causal = figures(simulated, speed, np.array([e.stamp_ns for e in found]),
                     np.array([e.pose for e in found]), np.array([e.twist for e in found]),
                     np.array([e.slip.body_probability for e in found]),
                     np.array([e.slip.probability for e in found]))
    smoothed = figures(simulated, speed, stamp_ns, track[:, :3], track[:, 3:5], slip[:, -1],
                       slip[:, 1:-1:2])
    return causal, smoothed


def cells(runs):
    """Figures of several runs of a scenario as text."""
    scores = [r[4] for r in runs]
    hits = sum(s.hits for s in scores)
    wrong = sum(s.false_alarms + s.misses for s in scores)
    delays = [d for s in scores for d in s.delays]
    quiet = not sum(s.true_samples for s in scores)

    def rms(parts):
        whole = np.concatenate(parts)
        return f'{1e3 * math.sqrt(whole.mean()):.1f}' if len(whole) else ''

    return (rms([r[2] for r in runs]), '' if quiet else rms([r[3] for r in runs]),
            '' if quiet else f'{2 * hits / max(2 * hits + wrong, 1):.3f}',
            f'{1e3 * np.mean(delays):.0f}' if delays else '',
            f'{1e3 * math.sqrt(sum(r[0] for r in runs) / sum(r[1] for r in runs)):.0f}')


def table(names, seeds):
    """The table as Markdown; of each pair the causal figure comes first."""
    lines, everything = [HEAD], []
    with Progress('smoothed') as progress:
        for number, name in enumerate(names):
            runs = []
            for k, seed in enumerate(seeds):
                progress.update((number + k / len(seeds)) / len(names), name)
                runs.append(compared(name, seed))
            lines.append(line(name, runs))
            everything += runs
    return '\n'.join([*lines, line('**all**', everything)]) + '\n'


def line(name, runs):
    """One row of the table."""
    pairs = zip(cells([a for a, _ in runs]), cells([b for _, b in runs]))
    return f'| {name} | ' + ' | '.join(f'{a} → {b}' if a else '' for a, b in pairs) + ' |'


def main():
    """Print the table or put it into a document."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('name', nargs='*')
    parser.add_argument('--seeds', default='100-102')
    parser.add_argument('--doc', type=pathlib.Path)
    options = parser.parse_args()
    first, last = map(int, options.seeds.split('-'))
    text = table(options.name or NAMES, range(first, last + 1))
    if options.doc is None:
        print(text, end='')
        return
    begin, end = f'<!-- {MARK} -->\n', f'<!-- end of {MARK} -->'
    head, rest = options.doc.read_text().split(begin)
    options.doc.write_text(head + begin + text + end + rest.split(end)[1])


if __name__ == '__main__':
    main()
