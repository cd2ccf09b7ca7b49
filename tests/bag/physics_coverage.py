"""How often the 90 % intervals of the calibration cover the truth, in the physics simulator.

    python tests/bag/physics_coverage.py [RUNS] [FIRST_SEED]

Motors, friction, loads, errors of every wheel and the datasheet errors of three IMUs, mounted by
chance 1 deg off; the base wanders for 100 s. True scales are those of the same robot driven
steadily along each axis over more than hundred rollers, true axes and gyro scale are how the
simulated IMU really sees the axes of the base (it is asked). The true time offset is the mean over
all runs: delay of the sensor, and 1 to 2 ms by which a base follows its wheels (creep).
"""

from __future__ import annotations

import argparse
import dataclasses
import functools
import math
import sys

import numpy as np

from mecanum_base.bag.analysis.calibrate_bags import fitted
from mecanum_base.bag.analysis.drift import Track, at_stamps
from mecanum_base.bag.analysis.evidence import Evidence
from mecanum_base.bag.analysis.imu_mount import levelling
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.bag.analysis.time_offset import time_offset
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.records import ImuSample, WheelSample
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.driving import read_driving
from mecanum_base.sim.headless import run
from mecanum_base.sim.inertial import Inertial
from mecanum_base.sim.scenario import Scenario

PUSH, TURN = 10.0, 4.0  # m/s2, rad/s: within the range of every sensor
OFFSET = 'gyro time offset [s]'
PRESETS_TRIED = ('mpu6050', 'bno055', 'bmi088')
SECONDS = 100.0
WANDER = {'wander': {'area': [-2.0, 2.0, -2.0, 2.0], 'pause': 1.0}, 'speed': 0.6, 'accel': 1.0,
          'turn_speed': 1.2, 'wait': 3.0}
STEADY = ((0.5, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, 1.0))
ROBOT = load_robot(shipped() / 'mecanum4.yaml')
MATRIX = wheels_from_body(ROBOT.base)


def driven(driving, sim, seed, seconds):
    """The run of one robot."""
    scenario = Scenario(driving=read_driving(driving, 'driver'), seed=seed, duration=seconds)
    return run(scenario, ROBOT.base, ROBOT.encoder, ROBOT.imu, sim, seed=seed)


def wheel_motion(done):
    """(wheel columns, IMU readings) of a run."""
    readings = [item.reading for item in done.published]
    wheels = [r for r in readings if isinstance(r, WheelSample)]
    return WheelMotion(done.joints, np.array([r.stamp_ns for r in wheels]),
                       np.array([r.position for r in wheels])), [
                           r for r in readings if isinstance(r, ImuSample)]


@functools.cache
def true_scales(seed):
    """Scale of each axis: true way over that of the wheels by the robot file, driven steadily."""
    found = []
    for axis, twist in enumerate(STEADY):
        done = driven({'script': [{'seconds': 20.0, 'twist': list(twist)}]},
                      ROBOT.sim, seed, 14.0)
        motion, _ = wheel_motion(done)
        whole = (motion.stamp_ns - done.start_ns) > 3_000_000_000  # up to speed
        turned = motion.angle[whole]
        own = (body_from_wheels(MATRIX) @ (turned[-1] - turned[0]))[axis]
        pose = at_stamps(Track(done.stamp_ns, done.pose), motion.stamp_ns[whole][[0, -1]])
        step = pose[1] - pose[0]
        found.append(float((step[2] if axis == 2 else np.hypot(step[0], step[1])) / own))
    return found


def seen_axes(imu, config):
    """Matrices (3, 3): what the simulated accelerometer and gyro read of the axes of the base."""
    sensor, count = Inertial(imu, config), 1000  # noise lets the mean see between the steps
    means = []
    for unit in (*np.eye(3), np.zeros(3)):
        sensor.restart()  # the same noise every time
        row = np.tile(unit, (count, 1))
        means.append([r.mean(axis=0) for r in sensor.read(row * TURN, row * PUSH,
                                                          np.zeros(count))])
    gyro, accel = (np.array([m[k] for m in means]) for k in (0, 1))
    return (accel[:3] - accel[3]).T / PUSH, (gyro[:3] - gyro[3]).T / TURN


def true_turns(seen):
    """Turns about x, y and z [rad] that level and align what is seen (file: axes of the base)."""
    up = seen @ [0.0, 0.0, 1.0]
    up /= np.linalg.norm(up)
    x, y = up[1], -up[0]
    flat = (levelling(x, y) @ seen)[:2, :2]
    return {'about x (roll)': x, 'about y (pitch)': y,
            'about z (yaw)': math.atan2(flat[0, 1] - flat[1, 0], flat[0, 0] + flat[1, 1])}


def one(seed, preset):
    """(fitted values by name, true values by name) of one robot."""
    sim = dataclasses.replace(ROBOT.sim, imu_preset=preset, mount_error=math.radians(1.0))
    done = driven(WANDER, sim, seed, SECONDS)
    motion, imu = wheel_motion(done)
    gyro = Gyro(np.array([r.stamp_ns for r in imu]), np.array([r.gyro for r in imu]),
                np.array([r.accel for r in imu]))
    evidence = Evidence(ROBOT, motion, gyro, Track(done.stamp_ns, done.pose), None)
    offsets = []
    found = fitted([evidence], [time_offset(evidence, offsets)], MATRIX)
    values = {**found.axes, **{v.name: v for v in (*found.constants, *offsets)},
              **{v.name: v for v in found.mount.turns.values()}}
    accel, reads = seen_axes(ROBOT.imu, dataclasses.replace(sim, seed=seed))
    up = found.mount.applied(ROBOT.imu.base_from_sensor())[2]
    real = dict(zip(('forward', 'sideways', 'turning'), true_scales(seed)))
    real |= true_turns(ROBOT.imu.base_from_sensor() @ accel)
    real['gyro scale'] = float(up @ reads[:, 2])
    return values, real


def main(runs, first):
    for preset in PRESETS_TRIED:
        done = [one(seed, preset) for seed in range(first, first + runs)]
        offset = np.mean([values[OFFSET].value for values, _ in done if values[OFFSET].given])
        for name in (*done[0][1], OFFSET):
            pairs = [(values[name], real.get(name, offset)) for values, real in done
                     if values[name].given]
            if not pairs:
                continue
            error = np.array([value.value - true for value, true in pairs])
            half = np.array([(value.high - value.low) / 2.0 for value, _ in pairs])
            print(f'{preset:8s} {name:20s} given {len(pairs):3d} of {runs}, covered '
                  f'{100.0 * np.mean(np.abs(error) <= half):5.1f} %, mean error '
                  f'{error.mean():+.5f}, rms {np.sqrt(np.mean(error**2)):.5f}, half width '
                  f'{half.mean():.5f}', flush=True)
    return 0


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('runs', type=int, nargs='?', default=100, help='runs an IMU')
    parser.add_argument('first', type=int, nargs='?', default=0, help='first seed')
    chosen = parser.parse_args()
    sys.exit(main(chosen.runs, chosen.first))
