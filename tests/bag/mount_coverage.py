"""How often the 90 % intervals of the IMU's mounting cover the truth, in the physics simulator.

    python tests/bag/mount_coverage.py [RUNS] [SCENARIO]

Motors, friction, loads, wheel errors and the datasheet errors of three IMUs, mounted by chance
1 deg off; true is how the simulated accelerometer really sees the axes of the base (it is asked).
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys

import numpy as np

from mecanum_base.bag.analysis.evidence import Evidence
from mecanum_base.bag.analysis.imu_fit import mount_fit
from mecanum_base.bag.analysis.imu_mount import levelling
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.records import ImuSample, WheelSample
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.headless import run
from mecanum_base.sim.inertial import Inertial
from mecanum_base.sim.scenario_file import load_scenario

PUSH = 10.0  # m/s2, within the range of every sensor


def seen_axes(imu, config):
    """Matrix (3, 3): what the simulated accelerometer reads of the axes of the base."""
    sensor, still = Inertial(imu, config), np.zeros((1, 3))
    columns = []
    for force in (*np.eye(3) * PUSH, np.zeros(3)):
        sensor.restart()  # the same noise every time
        columns.append(sensor.read(still, force[None, :], np.zeros(1))[1][0])
    return (np.array(columns[:3]) - columns[3]).T / PUSH


def true_turns(seen):
    """Turns about x, y and z [rad] that level and align what is seen (file: axes of the base)."""
    up = seen @ [0.0, 0.0, 1.0]
    up /= np.linalg.norm(up)
    x, y = up[1], -up[0]
    flat = (levelling(x, y) @ seen)[:2, :2]
    return {'x': x, 'y': y, 'z': math.atan2(flat[0, 1] - flat[1, 0], flat[0, 0] + flat[1, 1])}


def one(seed, name, preset):
    """(fitted turns, true turns) of one run of a scenario."""
    scenario = load_scenario(name)
    robot = load_robot(shipped() / scenario.robot)
    sim = dataclasses.replace(robot.sim, imu_preset=preset, mount_error=math.radians(1.0))
    done = run(scenario, robot.base, robot.encoder, robot.imu, sim, seed=seed)
    readings = [item.reading for item in done.published]
    wheels = [r for r in readings if isinstance(r, WheelSample)]
    imu = [r for r in readings if isinstance(r, ImuSample)]
    evidence = Evidence(
        robot, WheelMotion(done.joints, np.array([r.stamp_ns for r in wheels]),
                           np.array([r.position for r in wheels])),
        Gyro(np.array([r.stamp_ns for r in imu]), np.array([r.gyro for r in imu]),
             np.array([r.accel for r in imu])), None, None)
    config = dataclasses.replace(scenario.settings(sim), seed=seed)
    seen = robot.imu.base_from_sensor() @ seen_axes(robot.imu, config)
    found = mount_fit([evidence], [0.0], wheels_from_body(robot.base))
    return found.turns, true_turns(seen)


def main(runs, name):
    for preset in ('mpu6050', 'bno055', 'bmi088'):
        errors, halves = {axis: [] for axis in 'xyz'}, {axis: [] for axis in 'xyz'}
        for seed in range(runs):
            fitted, true = one(seed, name, preset)
            for axis, value in fitted.items():
                if value.given:
                    errors[axis].append(value.value - true[axis])
                    halves[axis].append((value.high - value.low) / 2.0)
        for axis in 'xyz':
            error, half = np.array(errors[axis]), np.array(halves[axis])
            print(f'{name} {preset:8s} about {axis}: given {len(error):3d} of {runs}'
                  + (f', covered {100 * np.mean(np.abs(error) <= half):5.1f} %, rms error '
                     f'{np.degrees(np.sqrt(np.mean(error**2))):.2f} deg, half width '
                     f'{np.degrees(half.mean()):.2f} deg' if len(error) else ''), flush=True)
    return 0


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('runs', type=int, nargs='?', default=100, help='runs an IMU')
    parser.add_argument('scenario', nargs='?', default='square', help='scenario to drive')
    chosen = parser.parse_args()
    sys.exit(main(chosen.runs, chosen.scenario))
