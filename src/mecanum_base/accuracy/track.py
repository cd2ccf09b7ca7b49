"""A track of poses, the sensor readings every method gets, and tracks made by dead reckoning.

The gyro is read as the simulated sensor gives it: each sample is the mean since the last one, so
its integral is known at every stamp; between stamps it is interpolated (half an IMU period of
hindsight, to the advantage of the methods compared with ours). The bias is the mean difference
to the true yaw rate over the first :data:`REST` seconds: what a perfect start-up calibration
would give, whether or not the base rests there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.estimation.encoder import WheelAngles
from mecanum_base.core.estimation.geometry import travel_per_radian
from mecanum_base.core.estimation.odometry import WheelOdometry
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.records import ImuSample, Sample, WheelSample
from mecanum_base.robot import Robot
from mecanum_base.sim.headless import Run

REST = 1.0  # s
_GAP = 3.0  # an IMU interval this many times the usual one has samples missing


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Poses (N, 3) [m, m, rad, yaw unwrapped] at stamps (N,) ns, in order."""

    stamp_ns: IntArray
    pose: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """What the sensors gave in one run, in the order of stamps.

    ``frames``: encoder samples; ``frame_ns`` (F,) their stamps, ``travel`` (F, W) m along the
    roller axes since the first. ``imu_ns`` (I,), ``gyro`` (I,) rad/s about z of base_link with
    the start-up bias removed, ``raw_gyro`` (I,) without, ``accel`` (I, 2) m/s^2 at base_link
    (lever arm removed), ``gap`` (I,) bool: samples are missing before this one.
    """

    frames: tuple[WheelSample, ...]
    frame_ns: IntArray
    travel: FloatArray
    imu_ns: IntArray
    gyro: FloatArray
    raw_gyro: FloatArray
    accel: FloatArray
    gap: FloatArray

    def yaw_at(self, stamp_ns: IntArray) -> FloatArray:
        """Integral of the gyro (N,) rad at any stamps."""
        step = np.diff(self.imu_ns, prepend=self.imu_ns[:1]) * 1e-9
        found: FloatArray = np.interp(stamp_ns, self.imu_ns, np.cumsum(step * self.gyro))
        return found


def readings_of(run: Run, robot: Robot, samples: list[Sample]) -> Readings:
    """Sort and convert the samples of a run; frames the encoder code refuses are left out."""
    assert isinstance(robot.base, Wheels)
    angles = WheelAngles(robot.encoder, robot.base.count, robot.base.max_speed)
    frames, stamps, turned = [], [], []
    for sample in sorted((s for s in samples if isinstance(s, WheelSample)), key=_stamp):
        reading = angles.read(sample)
        if not isinstance(reading, str):
            frames.append(sample)
            stamps.append(reading.stamp_ns)
            turned.append(reading.angle)
    imu = sorted((s for s in samples if isinstance(s, ImuSample)
                  and np.isfinite(s.gyro).all() and np.isfinite(s.accel).all()), key=_stamp)
    imu_ns = np.array([s.stamp_ns for s in imu], dtype=np.int64)
    turn = robot.imu.base_from_sensor()
    gyro = np.array([s.gyro for s in imu]) / robot.imu.gyro_scale @ turn.T
    accel = np.array([s.accel for s in imu]) @ turn.T
    step = np.diff(imu_ns, prepend=imu_ns[:1]) * 1e-9
    rate = gyro[:, 2]
    early = (imu_ns - imu_ns[0]) * 1e-9 < REST
    true = np.interp(imu_ns[early], run.stamp_ns, run.twist[:, 2])
    bias = float(np.mean(rate[early] - true))
    x, y = float(robot.imu.xyz[0]), float(robot.imu.xyz[1])
    change = np.gradient(rate - bias) / max(float(np.median(step)), 1e-6)
    still = (rate - bias)**2
    planar = np.column_stack([accel[:, 0] + still * x + change * y,
                              accel[:, 1] + still * y - change * x])
    return Readings(tuple(frames), np.array(stamps, dtype=np.int64),
                    np.array(turned) * travel_per_radian(robot.base), imu_ns, rate - bias, rate,
                    planar, (step > _GAP * float(np.median(step))).astype(np.float64))


def wheel_track(readings: Readings, robot: Robot, *, gyro_heading: bool) -> Track:
    """Dead reckoning from the wheels, with the wheels' own yaw or with that of the gyro."""
    odometry = WheelOdometry(robot.base, robot.encoder)
    turned = np.diff(readings.yaw_at(readings.frame_ns), prepend=0.0).tolist()
    poses = [odometry.handle(frame, turn if gyro_heading else None)
             for frame, turn in zip(readings.frames, turned)]
    return Track(readings.frame_ns, np.array(poses))


def _stamp(sample: WheelSample | ImuSample) -> int:
    return sample.stamp_ns
