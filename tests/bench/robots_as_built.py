"""How far robots with a known truth are from their robot files: what the estimator's doubts are
held against.

    python tests/bench/robots_as_built.py RUN [RUN ...]

A RUN is a folder with robot.yaml (fixed wheels), bag.mcap and truth.npz: t s, pose (x, y, yaw),
slip_rate rad/s of every wheel, slip_speed_per_rate m. By least squares over spans of 0.1 s
without slip beyond 3 cm/s, travel less slip against the true motion:

    dz_i - s_i T - A_i d = k_i A_i d + kY A_iy dy + kL A_iw dyaw,   d = (dx, dy, dyaw)

gyro scale and bias against the true yaw, and creep c of gripping wheels, s_i = c |v| F_i/N_i with
F_i/N_i = W/g (A+' f)_i from the true acceleration f. Values are given with their standard error;
what a run does not show (more than 0.2 %, creep: 0.05) is left out. The last line is the root
mean square over runs: common radius, each radius against it, lateral, lever, gyro scale.
"""

from __future__ import annotations

import argparse
import pathlib

import numpy as np

from mecanum_base.bag.analysis.evidence import evidence_of
from mecanum_base.core.estimation.geometry import rolling_rows, travel_per_radian
from mecanum_base.robot_file import load_robot

SPAN = 10  # samples of the truth
GRIPS = 0.03  # m/s of slip
STEADY = 0.25  # of the load: traction beyond which creep is no longer in proportion
SHOWN, CREEP_SHOWN = 0.002, 0.05  # standard errors
HEAD = ('common radius %', 'wheels %', 'lateral %', 'lever %', 'gyro scale %', 'creep')


def fitted(rows, values):
    """(solution, standard errors) of least squares."""
    solution = np.linalg.lstsq(rows, values, rcond=1e-9)[0]
    left = values - rows @ solution
    variance = left @ left / max(len(values) - len(solution), 1)
    return solution, np.sqrt(np.diag(np.linalg.pinv(rows.T @ rows)) * variance)


def of_run(folder):
    """{name: (value, standard error)} of one run; wheels: their spread about the common one."""
    robot = load_robot(folder / 'robot.yaml')
    seen = evidence_of(str(folder / 'bag.mcap'), robot)
    truth = np.load(folder / 'truth.npz')
    t, pose = truth['t'], truth['pose']
    slip = truth['slip_rate'] * float(truth['slip_speed_per_rate'])
    A, travel = rolling_rows(robot.base), travel_per_radian(robot.base)
    seconds = seen.motion.stamp_ns * 1e-9
    z = np.column_stack([np.interp(t, seconds, column) for column in seen.motion.angle.T]) * travel
    yaw, dt = np.unwrap(pose[:, 2]), np.diff(t)
    middle, step = 0.5 * (yaw[1:] + yaw[:-1]), np.diff(pose[:, :2], axis=0)
    c, s = np.cos(middle), np.sin(middle)
    moved = np.column_stack([c * step[:, 0] + s * step[:, 1], c * step[:, 1] - s * step[:, 0],
                             np.diff(yaw)])
    slid = 0.5 * (slip[1:] + slip[:-1])
    grips = np.abs(slid).max(axis=1) < GRIPS
    count = len(dt) // SPAN * SPAN

    def spans(values):
        return values[:count].reshape(count // SPAN, SPAN, -1).sum(axis=1)

    whole = spans(grips.astype(float))[:, 0] == SPAN
    d, left = spans(moved)[whole], spans(np.diff(z, axis=0) - slid * dt[:, None])[whole]
    wheels = len(A)
    rows, values = [], []
    for i in range(wheels):
        row = np.zeros((len(d), wheels + 2))
        row[:, i] = d @ A[i]
        row[:, wheels], row[:, wheels + 1] = A[i, 1] * d[:, 1], A[i, 2] * d[:, 2]
        rows.append(row)
        values.append(left[:, i] - d @ A[i])
    k, error = fitted(np.vstack(rows), np.concatenate(values))
    common = float(np.mean(k[:wheels]))
    found = {'common radius %': (100 * common, 100 * float(error[:wheels].mean())),
             'wheels %': (100 * float(np.sqrt(np.sum((k[:wheels] - common) ** 2) / (wheels - 1))),
                          100 * float(error[:wheels].mean())),
             'lateral %': (100 * k[wheels], 100 * error[wheels]),
             'lever %': (100 * k[wheels + 1], 100 * error[wheels + 1])}
    if seen.gyro is not None:
        at, rate = seen.gyro.stamp_ns * 1e-9, seen.gyro.rate[:, 2]
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(at))])
        g, error = fitted(np.column_stack([yaw - yaw[0], t - t[0], np.ones(len(t))]),
                          np.interp(t, at, turned))
        found['gyro scale %'] = (100 * (g[0] - 1.0), 100 * error[0])
    found['creep'] = creep(A, moved / dt[:, None], t[1:], slid, grips)
    return found


def creep(A, speed, t, slid, grips):
    """(c, standard error) of s_i = c |v| F_i/N_i where wheels grip and pull moderately."""
    smooth = np.column_stack([np.convolve(v, np.ones(7) / 7.0, 'same') for v in speed.T[:2]])
    change = np.gradient(smooth, t, axis=0)
    f = change + speed[:, 2:] * np.column_stack([-speed[:, 1], speed[:, 0]])
    pulls = len(A) / 9.81 * f @ np.linalg.pinv(A[:, :2])
    v = np.hypot(*speed[:, :2].T)
    used = grips & (np.abs(pulls).max(axis=1) < STEADY) & (v > 0.05)
    if used.sum() < 100:
        return float('nan'), float('inf')
    c, error = fitted((pulls * v[:, None])[used].reshape(-1, 1), slid[used].ravel())
    return float(c[0]), float(error[0])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description='How far robots with a known truth are from their robot files.',
        epilog='example: python tests/bench/robots_as_built.py DATA/*')
    parser.add_argument('run', type=pathlib.Path, nargs='+', help='folder with robot.yaml, '
                        'bag.mcap and truth.npz')
    options = parser.parse_args()
    missing = [str(run / name) for run in options.run
               for name in ('robot.yaml', 'bag.mcap', 'truth.npz') if not (run / name).is_file()]
    if missing:
        parser.error(f'not found: {", ".join(missing)}')
    print(f'{"run":20}' + ''.join(f'{name:>18}' for name in HEAD))
    shown = {name: [] for name in HEAD}
    for run in options.run:
        found, line = of_run(run), f'{run.name:20}'
        for name in HEAD:
            value, error = found.get(name, (float('nan'), float('inf')))
            told = error < (CREEP_SHOWN if name == 'creep' else 100 * SHOWN)
            line += f'{f"{value:+.3f} ({error:.3f})" if told else "-":>18}'
            if told:
                shown[name].append(value)
        print(line, flush=True)
    print(f'{"root mean square":20}' + ''.join(
        f'{np.sqrt(np.mean(np.square(v))):>18.3f}' if (v := shown[name]) else f'{"-":>18}'
        for name in HEAD))


if __name__ == '__main__':
    main()
