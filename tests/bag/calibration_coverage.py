"""How often the 90 % intervals of the calibration cover the truth, and what is refused.

    python tests/bag/calibration_coverage.py [RUNS]
"""

from __future__ import annotations

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import driving

from mecanum_base.bag.analysis.calibration import calibrate
from mecanum_base.bag.analysis.calibration_windows import windows_of
from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.robot import Robot
from mecanum_base.robot_file import parse_parameters

ROBOT = Robot.from_mapping(parse_parameters(driving.YAML, 'made by hand'))
MATRIX = wheels_from_body(ROBOT.base)
UP = np.array([0.0, 0.0, 1.0])


def one(seed, truth=True, imu=True, **options):
    """(calibration, true scales by name) of one random base."""
    generator = np.random.default_rng(1000 + seed)
    rho, kappa = generator.uniform(0.95, 1.05), generator.uniform(0.93, 1.0)
    lam, gyro = generator.uniform(0.93, 1.07), generator.uniform(0.99, 1.01)
    # without truth the gyro is the reference; its scale error then has the stated spread
    if not truth:
        gyro = 1.0 + 0.005 * generator.normal()
    spread = 0.01 * generator.normal(size=4)
    spread -= spread.mean()
    setting = dict(seconds=80.0, radius=driving.RADIUS * rho * (1.0 + spread),
                   lever=(driving.LX + driving.LY) * lam, lateral=kappa, gyro_scale=gyro,
                   truth_noise=0.002)
    made = driving.drive(seed=seed, **{**setting, **options})
    motion = WheelMotion(driving.JOINTS, made.wheel_ns, made.angle)
    windows = windows_of(motion, Track(made.truth_ns, made.pose) if truth else None,
                         Gyro(made.imu_ns, made.gyro, made.accel) if imu else None, UP)
    return calibrate(windows, MATRIX), {
        'forward': rho, 'sideways': rho * kappa, 'turning': rho / lam, 'gyro scale': gyro,
        'wheels': 1.0 + spread}


def covered(found, real):
    """{name: covered or None where refused}."""
    values = {**found.axes, **{v.name: v for v in found.constants}}
    result = {name: (value.low <= real[name] <= value.high) if value.given else None
              for name, value in values.items() if name in real}
    for index, value in enumerate(found.wheels):
        result[f'wheel {index}'] = ((value.low <= real['wheels'][index] <= value.high)
                                    if value.given else None)
    return result


def main(runs):
    for label, options in (('true pose', {}), ('true pose, slip in every tenth leg',
                                               dict(slip=0.1)), ('gyro alone', dict(truth=False))):
        counts: dict[str, list[bool]] = {}
        for seed in range(runs):
            for name, value in covered(*one(seed, **options)).items():
                if value is not None:
                    counts.setdefault(name, []).append(value)
        print(label)
        for name, values in counts.items():
            print(f'  {name:12s} covered {100 * np.mean(values):5.1f} % of {len(values)}',
                  flush=True)
    for name, still in (('sideways', dict(sideways=0.0)), ('turning', dict(turning=0.0)),
                        ('forward', dict(forward=0.0))):
        given = sum(one(seed, **still)[0].axes[name].given for seed in range(runs))
        print(f'not excited {name:9s}: given {given} times of {runs}')
    return 0


if __name__ == '__main__':
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 100))
