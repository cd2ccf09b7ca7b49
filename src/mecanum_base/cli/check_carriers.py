"""What `mecanum check` says of a platform on two differential carrier robots."""

from __future__ import annotations

import itertools
import math

import numpy as np

from mecanum_base.cli.columns import align
from mecanum_base.core.kinematics.saturation import fastest
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.platform.caster import flip_peak_rate, will_flip
from mecanum_base.core.platform.constraints import assess
from mecanum_base.core.platform.differential import wheels_from_body
from mecanum_base.core.platform.lie import reachable_rank
from mecanum_base.robot import Robot

ANGLES = 36  # hinge angles tried for the worst speed, a carrier
DIRECTIONS = (('forward', (1.0, 0.0, 0.0), 'm/s'), ('left', (0.0, 1.0, 0.0), 'm/s'),
              ('turning on the spot', (0.0, 0.0, 1.0), 'rad/s'))


def describe_carriers(carriers: Carriers, robot: Robot) -> tuple[list[str], list[str]]:
    """(lines for people, findings)."""
    angles = np.array(carriers.initial_angle)
    mobility = assess(carriers.hinges, angles)
    plain, bracketed = reachable_rank(carriers.hinges, angles)
    forward = np.array([1.0, 0.0, 0.0])
    findings = [
        f'carrier {name} does not trail when driving forward from its initial angle: it will '
        f'flip round, its wheels peaking at {_flip(carriers, i):.3g} rad/s per m/s'
        for i, (name, flips) in enumerate(zip(carriers.name, will_flip(carriers, angles, forward)))
        if flips]
    counts, _ = robot.encoder.for_wheels(carriers.count)
    quantum = 2.0 * math.pi * np.repeat(carriers.wheel_radius, 2) / counts
    lines = [
        *_table(carriers), '', 'mobility',
        f'  {mobility.twist_dof} of 3 platform motions without steering first: '
        + ('omnidirectional' if mobility.omnidirectional else 'not omnidirectional'),
        f'  degree of mobility {mobility.degree} (lateral constraints {mobility.lateral_rank}); '
        f'Lie rank {plain}, with first brackets {bracketed} of 5: every posture is reachable',
        f'  redundancy {carriers.count - 3}: the stretch between the hinges',
        *_measured(carriers), '', 'slip that the encoders can see',
        '  one independent check: slip that would pull the hinges apart or together is seen, but '
        'not which wheel it is',
        '  3 of 4 slip patterns look like motion and stay hidden, 2 of 4 with a gyro', '',
        'largest speeds', *_speeds(carriers, angles), '', 'encoder',
        f'  {robot.encoder.source}, one count = {1e3 * float(np.max(quantum)):.4g} mm of rim']
    return lines, findings


def _flip(carriers: Carriers, i: int) -> float:
    return flip_peak_rate(float(carriers.axle_offset[i]), float(carriers.half_track[i]),
                          float(carriers.wheel_radius[i]), 1.0)


def _table(carriers: Carriers) -> list[str]:
    rows = [['carrier', 'hinge x [m]', 'hinge y [m]', 'axle offset [m]', 'half track [m]',
             'wheel radius [m]', 'max [rad/s]', 'left joint', 'right joint']]
    for i, name in enumerate(carriers.name):
        rows.append([name, *(f'{getattr(carriers, key)[i]:.4g}' for key in (
            'x', 'y', 'axle_offset', 'half_track', 'wheel_radius', 'max_speed')),
            carriers.left_joint[i], carriers.right_joint[i]])
    return align(rows)


def _measured(carriers: Carriers) -> list[str]:
    unknown = [n for n, joint in zip(carriers.name, carriers.hinge_joint) if not joint]
    return [f'  hinge angle not measured: {", ".join(unknown)}; integrated from initial_angle and '
            'the wheels'] if unknown else ['  hinge angles measured']


def _speeds(carriers: Carriers, angles: np.ndarray) -> list[str]:
    limits = np.repeat(carriers.max_speed, 2)
    grid = [np.array(pair) for pair in itertools.product(
        2.0 * math.pi * np.arange(ANGLES) / ANGLES, repeat=2)]
    matrices = [wheels_from_body(carriers, pair) for pair in grid]
    rows = [['', 'at the initial hinge angles', 'at the worst']]
    for name, direction, unit in DIRECTIONS:
        here = fastest(wheels_from_body(carriers, angles), np.array(direction), limits)
        worst = min(fastest(matrix, np.array(direction), limits) for matrix in matrices)
        rows.append([name, *('no limit given' if math.isinf(v) else f'{v:.3f} {unit}'
                             for v in (here, worst))])
    return align(rows)
