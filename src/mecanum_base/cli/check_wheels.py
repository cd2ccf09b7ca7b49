"""What `mecanum check` says of a base on roller wheels."""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.cli.columns import align
from mecanum_base.core.contact.passage import lateral_peak, yaw_sawtooth
from mecanum_base.core.kinematics.lines import name_motion
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.mobility import POOR, Mobility, require_mobile
from mecanum_base.core.kinematics.mounting import judge_mounting
from mecanum_base.core.kinematics.saturation import fastest
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.kinematics.visibility import Visibility, assess_visibility
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.robot import Robot

CLOSE = math.radians(10.0)  # traces nearer than this are confused by ordinary noise
DIRECTIONS = (('forward', (1.0, 0.0, 0.0), 'm/s'), ('backward', (-1.0, 0.0, 0.0), 'm/s'),
              ('left', (0.0, 1.0, 0.0), 'm/s'), ('right', (0.0, -1.0, 0.0), 'm/s'),
              ('45 deg to the left', (math.sqrt(0.5), math.sqrt(0.5), 0.0), 'm/s'),
              ('turning on the spot', (0.0, 0.0, 1.0), 'rad/s'))


def describe_wheels(wheels: Wheels, robot: Robot) -> tuple[list[str], list[str]]:
    """(lines for people, findings)."""
    verdict = require_mobile(wheels)
    mounting = judge_mounting(wheels)
    findings = []
    if verdict.condition < POOR:
        findings.append(verdict.text)
    if mounting.suspicious:
        findings.append(mounting.text())
    lines = [*_table(wheels), '', *_mobility(wheels, verdict), *_mounting(wheels), '',
             'slip that the encoders can see']
    lines += _sight(wheels, assess_visibility(wheels, gyro=False), 'encoders alone')
    lines += _sight(wheels, assess_visibility(wheels, gyro=True), 'with a gyro')
    lines += ['', 'largest speeds (one motion at a time)', *_speeds(wheels), '', 'contact',
              *_contact(wheels), '', 'encoder', *_encoder(wheels, robot)]
    return lines, findings


def _table(wheels: Wheels) -> list[str]:
    rows = [['wheel', 'x [m]', 'y [m]', 'axle [deg]', 'roller [deg]', 'radius [m]', 'rollers',
             'max [rad/s]']]
    for i, name in enumerate(wheels.joint):
        rows.append([name, f'{wheels.x[i]:.4g}', f'{wheels.y[i]:.4g}',
                     f'{math.degrees(wheels.axle[i]):.4g}',
                     f'{math.degrees(wheels.roller[i]):.4g}', f'{wheels.radius[i]:.4g}',
                     str(int(wheels.roller_count[i])) if wheels.roller_count[i] else 'unknown',
                     f'{wheels.max_speed[i]:.4g}'])
    return align(rows)


def _mobility(wheels: Wheels, verdict: Mobility) -> list[str]:
    reach = float(np.mean(np.hypot(wheels.x, wheels.y)))
    return ['mobility',
            f'  rank {verdict.rank} of 3, redundancy {verdict.redundancy}, condition '
            f'{verdict.condition:.3g} (1 = all directions alike, 0 = one is free)',
            f'  {verdict.text}',
            f'  least driven: {name_motion(verdict.weakest, reach).text()}']


def _mounting(wheels: Wheels) -> list[str]:
    if np.all(np.abs(np.cos(wheels.roller)) < 1e-9):
        return ['  Swedish wheels: rollers cannot be mounted mirrored']
    return [f'  {judge_mounting(wheels).text()}']


def _sight(wheels: Wheels, seen: Visibility, title: str) -> list[str]:
    checks = f'{seen.parities} independent check{"" if seen.parities == 1 else "s"}'
    lines = [f'  {title}: {checks}; {len(seen.hidden)} of {wheels.count} slip patterns look like '
             'motion and stay hidden']
    if seen.parities == 0:
        return [*lines, '    no slip of any wheel can be seen']
    if seen.parities == 1 and all(seen.seen):
        return [*lines, '    slip of a single wheel is seen, but not which wheel it is']
    rows = []
    for i, name in enumerate(wheels.joint):
        if not seen.seen[i]:
            text = 'its slip is not seen'
        elif seen.confused[i]:
            others = ', '.join(wheels.joint[j] for j in seen.confused[i])
            text = f'seen, but looks like {others}'
        elif seen.separation[i] < CLOSE:
            text = f'seen, hard to tell from others ({math.degrees(seen.separation[i]):.1f} deg)'
        else:
            text = f'seen and told apart ({math.degrees(seen.separation[i]):.0f} deg)'
        rows.append([f'  {name}', text])
    return lines + align(rows)


def _speeds(wheels: Wheels) -> list[str]:
    matrix = wheels_from_body(wheels)
    rows = []
    for name, direction, unit in DIRECTIONS:
        speed = fastest(matrix, np.array(direction), wheels.max_speed)
        rows.append([name, 'no limit given' if math.isinf(speed) else f'{speed:.3f} {unit}'])
    return align(rows)


def _contact(wheels: Wheels) -> list[str]:
    wanders = np.abs(np.cos(wheels.roller)) > 1e-9
    if not np.any(wanders):
        return ['  Swedish wheels: the contact point does not wander, nothing to correct']
    if np.any(wanders & (wheels.roller_count == 0)):
        names = [n for n, w, k in zip(wheels.joint, wanders, wheels.roller_count) if w and not k]
        return [f'  roller_count unknown for {", ".join(names)}: no correction; sideways odometry '
                'over-reads by 1-3 %']
    plain = body_from_wheels(wheels_from_body(wheels, corrected=False))
    over = np.diag(plain @ wheels_from_body(wheels)) - 1.0
    counts = sorted({int(k) for k, w in zip(wheels.roller_count, wanders) if w})
    ripple = lateral_peak(min(counts)) - 1.0
    lines = [f'  {"/".join(map(str, counts))} rollers a wheel: uncorrected odometry would '
             f'over-read {100 * over[1]:.2f} % sideways and {100 * over[2]:.2f} % in rotation; '
             'corrected in command and odometry',
             f'  left over: ripple of the wheel rates, up to {100 * ripple:.1f} % sideways']
    if np.all(wheels.roller_count > 0) and np.all((wheels.roller_pin_radius > 0.0) | ~wanders):
        saw = float(np.max(yaw_sawtooth(wheels) / np.maximum(
            np.abs(wheels_from_body(wheels, corrected=False)[:, 2]), 1e-12)))
        lines[-1] += f' and +-{100 * saw:.1f} % turning on the spot'
    return lines


def _encoder(wheels: Wheels, robot: Robot) -> list[str]:
    counts, _ = robot.encoder.for_wheels(wheels.count)
    quantum = 2.0 * math.pi * wheels.radius / counts
    span = (f'{1e3 * float(np.min(quantum)):.4g}' if np.ptp(quantum) < 1e-12 else
            f'{1e3 * float(np.min(quantum)):.4g} ... {1e3 * float(np.max(quantum)):.4g}')
    return [f'  {robot.encoder.source}, one count = {span} mm of rim']
