"""The idea of the estimator as a picture, from one simulated run: docs/estimator.png.

    python tests/bench/estimator_picture.py [--scenario oil] [--seed 100] [--out FILE]

Left: wheels and roller axes, the two diagonals in two colours. Middle: probability of each kind of
hypothesis around the first slip of the run. Right: velocity of the base, true, as the wheels claim
it, as odometry had it and as the smoothed track has it (the second look and the pass backwards).
"""

from __future__ import annotations

import argparse
import math
import pathlib

import matplotlib
import numpy as np

matplotlib.use('Agg')
from matplotlib import pyplot
from matplotlib.patches import Rectangle

from mecanum_base.core.estimation.assembly import hypotheses_of
from mecanum_base.core.estimation.estimator import Estimator
from mecanum_base.core.estimation.geometry import rolling_rows, travel_per_radian
from mecanum_base.core.estimation.hypotheses import Hypotheses
from mecanum_base.core.records import TickSample, WheelSample
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.headless import run
from mecanum_base.sim.scenario_file import load_scenario

ON = 0.05  # m/s, true slip along the roller axis
BEFORE, AFTER = 0.5, 1.7  # s shown around the first slip
DIAGONALS = ('tab:blue', 'tab:orange')


def families(tables: Hypotheses) -> dict[str, np.ndarray]:
    """Names of the kinds of hypothesis and which (M,) belong to each."""
    size = tables.member.sum(axis=1)
    kind = np.array(tables.kind)
    return {'nothing slips': size == 0, 'one wheel': (kind == 'subset') & (size == 1),
            'several wheels, each its own way': (kind == 'subset') & (size > 1),
            'a diagonal as one': kind == 'group',
            'the body against all wheels': kind == 'body'}


def played(scenario, robot, seed):
    """(simulated run, stamps, twists, chances of hypotheses, smoothed stamps and twists)."""
    simulated = run(scenario, robot.base, robot.encoder, robot.imu, robot.sim, seed=seed)
    unused = TickSample if robot.encoder.source == 'joint_states' else WheelSample
    subject = Estimator(robot.base, robot.encoder, robot.imu, robot.estimator, smoothed=True)
    stamp, twist, chance = [], [], []
    for sample in simulated.samples(commands=False):
        if isinstance(sample, unused):
            continue
        for estimate in subject.handle(sample):
            stamp.append(estimate.stamp_ns)
            twist.append(estimate.twist)
            chance.append(np.array(subject._filter.memory.mode))
    subject.flush()
    past = [piece.smoothed() for piece in subject.past(last=True)]
    late = np.concatenate([part.stamp_ns for part in past])
    track = np.concatenate([part.track for part in past])
    return (simulated, np.array(stamp), np.array(twist), np.array(chance), late, track[:, 3:6])


def draw_base(axes, base) -> None:
    """Wheels from above, each with the axis of the roller that touches the floor."""
    turn = np.radians(90.0)  # x points up on the page
    rows = rolling_rows(base)
    for i, name in enumerate(base.joint):
        x, y = -base.y[i], base.x[i]
        half = base.radius[i]
        direction = np.arctan2(rows[i, 1], rows[i, 0]) + turn
        colour = DIAGONALS[0 if rows[i, 0] * rows[i, 1] * rows[0, 0] * rows[0, 1] > 0 else 1]
        axes.add_patch(Rectangle((x - 0.45 * half, y - half), 0.9 * half, 2 * half, fill=False,
                                 color='0.5'))
        dx, dy = 0.9 * half * math.cos(direction), 0.9 * half * math.sin(direction)
        axes.plot([x - dx, x + dx], [y - dy, y + dy], color=colour, linewidth=3)
        axes.annotate(name.replace('_wheel_joint', '').replace('_', ' '), (x, y - 1.35 * half),
                      ha='center', fontsize=8)
    axes.annotate('', (0, 0.14), (0, 0.02), arrowprops={'arrowstyle': '->'})
    axes.annotate('x', (0.012, 0.125))
    axes.set_title('A diagonal measures one direction')
    axes.set_aspect('equal')
    axes.margins(0.18)
    axes.axis('off')


def main() -> None:
    """Draw it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog='example: '
                                     'python tests/bench/estimator_picture.py --seed 101')
    parser.add_argument('--scenario', default='oil', help='scenario with slip (default: oil)')
    parser.add_argument('--seed', type=int, default=100, help='seed of the run (default: 100)')
    parser.add_argument('--out', type=pathlib.Path, default=pathlib.Path('docs/estimator.png'))
    options = parser.parse_args()
    scenario = load_scenario(options.scenario)
    robot = load_robot(shipped() / scenario.robot)
    simulated, stamp, twist, chance, late, smooth = played(scenario, robot, options.seed)
    speed = np.abs(simulated.slip_rate * travel_per_radian(robot.base)).max(axis=1)
    slips = np.flatnonzero(speed > ON)
    if not len(slips):
        parser.error(f'nothing slips in {options.scenario} with seed {options.seed}')
    zero = simulated.stamp_ns[slips[0]]

    def seconds(stamps):
        return (stamps - zero) * 1e-9

    figure, axes = pyplot.subplots(1, 3, figsize=(14, 4.2), width_ratios=[1, 1.6, 1.6])
    draw_base(axes[0], robot.base)
    tables = hypotheses_of(robot.base)
    for name, mask in families(tables).items():
        axes[1].plot(seconds(stamp), chance[:, mask].sum(axis=1), label=name)
    axes[1].set_ylabel('probability')
    axes[1].set_title('All hypotheses are judged in every frame')
    claim = np.linalg.pinv(rolling_rows(robot.base)) @ (
        simulated.slip_rate * travel_per_radian(robot.base)).T
    truth = seconds(simulated.stamp_ns)
    part = (truth > -BEFORE) & (truth < AFTER)
    axis = int(np.argmax(np.abs(claim[:2, part]).max(axis=1)))  # along which most is lost
    axes[2].plot(truth, simulated.twist[:, axis] + claim[axis], color='0.7', label='wheels claim')
    axes[2].plot(truth, simulated.twist[:, axis], color='black', label='truth')
    axes[2].plot(seconds(stamp), twist[:, axis], label='odometry, at once')
    axes[2].plot(seconds(late), smooth[:, axis], '--', label='smoothed track')
    shown = np.concatenate([simulated.twist[part, axis], simulated.twist[part, axis]
                            + claim[axis, part]])
    axes[2].set_ylim(shown.min() - 0.1, shown.max() + 0.1)
    axes[2].set_ylabel(f'v{"xy"[axis]} [m/s]')
    axes[2].set_title('What later frames tell goes to the smoothed track')
    edges = np.flatnonzero(np.diff(np.r_[0, (speed > ON).astype(int), 0]))
    for plot in axes[1:]:
        for begin, end in zip(edges[::2], edges[1::2], strict=True):
            plot.axvspan(truth[begin], truth[end - 1], color='tab:red', alpha=0.12, linewidth=0)
        plot.set_xlim(-BEFORE, AFTER)
        plot.set_xlabel('time since the first slip [s]; red: a wheel truly slips')
        plot.legend(loc='upper center', bbox_to_anchor=(0.5, -0.17), ncols=2, fontsize=8,
                    frameon=False)
    figure.tight_layout()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(options.out, dpi=90, metadata={'Software': None})
    print(f'{options.out}: {options.scenario}, seed {options.seed}')


if __name__ == '__main__':
    main()
