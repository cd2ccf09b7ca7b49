"""Readings of an ideal robot on a scripted motion, made without the code under test.

The wheel law is written out here once more (mecanum textbook form, not the roller-axis rows), the
motion is integrated numerically in small steps, and slip is added to the wheel angles by hand.
"""

import math

import numpy as np

from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.records import ImuSample, WheelSample

RADIUS, LX, LY = 0.05, 0.2, 0.15
NAN4 = np.full(4, np.nan)
START = 1_000_000_000_000


def mecanum():
    """Front left, front right, rear left, rear right with rollers at 45 degrees."""
    quarter, half = math.pi / 4, math.pi / 2
    return Wheels(('fl', 'fr', 'rl', 'rr'), np.array([LX, LX, -LX, -LX]),
                  np.array([LY, -LY, LY, -LY]), np.full(4, half),
                  np.array([quarter, -quarter, -quarter, quarter]), np.full(4, RADIUS))


def parts(counts=8192.0, **tuning):
    """Arguments of an Estimator for the mecanum robot."""
    return mecanum(), EncoderConfig(counts_per_revolution=counts), ImuConfig(), \
        EstimatorConfig(**tuning)


def wheel_rates(twist):
    """u (4,) rad/s of twist (3,): forward minus and plus lateral and lever (R, inverse)."""
    vx, vy, w = twist
    lever = (LX + LY) * w
    return np.array([vx - vy - lever, vx + vy + lever, vx + vy - lever, vx - vy + lever]) / RADIUS


class Drive:
    """Runs twist(t) for some seconds: samples in order, and the true pose at each frame."""

    def __init__(self, twist, seconds, slip=None, noise=0.0, seed=0, accel=True, imu=True):
        rng = np.random.default_rng(seed)
        dt, self.samples, self.truth = 0.001, [], []
        pose, angle = np.zeros(3), np.zeros(4)
        self.slip_angle = np.zeros(4)
        before = np.asarray(twist(0.0), float)
        for k in range(round(seconds / dt)):
            t = k * dt
            v = np.asarray(twist(t), float)
            acc = (v - before) / dt
            stamp = START + k * 1_000_000
            if k % 5 == 0 and imu:
                force = np.array([acc[0] - v[2] * v[1], acc[1] + v[2] * v[0], 9.81])
                self.samples.append(ImuSample(
                    stamp, np.array([0.0, 0.0, v[2]]) + noise * 0.001 * rng.normal(size=3),
                    force + noise * 0.02 * rng.normal(size=3) if accel else np.full(3, np.nan)))
            if k % 10 == 0:
                count = 2 * math.pi / 8192
                self.samples.append(WheelSample(stamp, np.round(angle / count) * count, NAN4))
                self.truth.append((stamp, *pose))
            extra = np.zeros(4) if slip is None else np.asarray(slip(t), float)
            angle = angle + (wheel_rates(v) + extra) * dt
            self.slip_angle = self.slip_angle + extra * dt
            middle = pose[2] + 0.5 * v[2] * dt
            c, s = math.cos(middle), math.sin(middle)
            pose = pose + np.array([c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]]) * dt
            before = v
        self.truth = np.array(self.truth)
        self.pose = pose


def ramp(t, start, end, rise=0.5):
    """0 before start and after end, 1 between, straight flanks of ``rise`` seconds."""
    return float(np.clip(min((t - start) / rise, (end - t) / rise), 0.0, 1.0))


def run(estimator, samples):
    """All estimates of ``samples`` in the order given, flush included."""
    found = [e for s in samples for e in estimator.handle(s)]
    return found + list(estimator.flush())


def track(estimates):
    """Stamps [ns] and poses of the encoder estimates."""
    own = [e for e in estimates if e.source == 'encoder']
    return np.array([e.stamp_ns for e in own]), np.array([e.pose for e in own])


def error(estimates, drive):
    """Largest distance [m] between estimates and the truth."""
    stamps, poses = track(estimates)
    true = drive.truth
    at = np.searchsorted(true[:, 0], stamps)
    return float(np.max(np.hypot(poses[:, 0] - true[at, 1], poses[:, 1] - true[at, 2])))
