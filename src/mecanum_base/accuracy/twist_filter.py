"""An 8-state planar filter of the kind robot_localization's ekf_node is, for comparison.

    state  x, y, yaw (world), vx, vy, wz, ax, ay (body)
    model  constant acceleration:  p += R(yaw) (v dt + a dt^2/2),  yaw += wz dt,  v += a dt
    noise  Q = diag(q) dt with ekf_node's documented defaults for these states
    input  wheel twist (vx, vy, wz) and yaw rate of the gyro, as mecanum bases configure it

What it is: an own re-implementation of the method (constant-acceleration twist fusion with
default process noise and 2-D mode), predicted to every measurement and corrected with it in the
order of stamps; the gyro comes with its start-up bias removed, which ekf_node cannot do. What it
is not: their binary. The 30 Hz output timer, delays, rejection thresholds, IMU orientation and
accelerations are left out; rejection is off by default there too.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.accuracy.track import Readings, Track
from mecanum_base.core.parameter import FloatArray

# process noise of x, y, yaw, vx, vy, wz, ax, ay: ekf_node's defaults, per second
PROCESS_NOISE = (0.05, 0.05, 0.06, 0.025, 0.025, 0.02, 0.01, 0.01)
START_VARIANCE = 1e-9  # ekf_node's initial_estimate_covariance
WHEEL_SIGMA = (0.01, 0.01, 0.05)  # m/s, m/s, rad/s: what such drivers publish
GYRO_SIGMA = 0.005  # rad/s


class TwistFilter:
    """State ``x`` (8,) and covariance ``P`` (8, 8)."""

    def __init__(self) -> None:
        self.x: FloatArray = np.zeros(8)
        self.P: FloatArray = np.eye(8) * START_VARIANCE
        self._noise = np.diag(PROCESS_NOISE)

    def predict(self, dt: float) -> None:
        """Move on by ``dt`` [s]."""
        _, _, yaw, vx, vy, wz, ax, ay = self.x.tolist()
        c, s, half = math.cos(yaw), math.sin(yaw), 0.5 * dt * dt
        along, across = vx * dt + ax * half, vy * dt + ay * half
        F = np.eye(8)
        F[0, 2], F[1, 2] = -s * along - c * across, c * along - s * across
        F[0, 3:5], F[1, 3:5] = (c * dt, -s * dt), (s * dt, c * dt)
        F[0, 6:8], F[1, 6:8] = (c * half, -s * half), (s * half, c * half)
        F[2, 5] = F[3, 6] = F[4, 7] = dt
        self.x = self.x + np.array([c * along - s * across, s * along + c * across, wz * dt,
                                    ax * dt, ay * dt, 0.0, 0.0, 0.0])
        self.P = F @ self.P @ F.T + self._noise * dt

    def correct(self, place: int, value: float, sigma: float) -> None:
        """Take a measurement of one state, with its standard deviation."""
        row = self.P[place]
        gain = row / (row[place] + sigma * sigma)
        self.x = self.x + gain * (value - self.x[place])
        self.P = self.P - gain[:, None] * row


def twist_filter_track(readings: Readings, rows: FloatArray) -> Track:
    """Run the filter over a recording; ``rows`` (W, 3) are wheel travel over body motion."""
    inverse = np.linalg.pinv(rows)
    frames, imus = readings.frame_ns, readings.imu_ns
    step = np.diff(frames) * 1e-9
    twist = ((np.diff(readings.travel, axis=0) @ inverse.T) / step[:, None]).tolist()
    gyro = readings.gyro.tolist()
    stamp = np.concatenate([frames[1:], imus])
    wheels = np.concatenate([np.ones(len(step), dtype=bool), np.zeros(len(imus), dtype=bool)])
    index = np.concatenate([np.arange(len(step)), np.arange(len(imus))])
    order = np.argsort(stamp, kind='stable')
    keep = TwistFilter()
    poses: list[FloatArray] = [np.zeros(3)]
    now = int(frames[0])
    for place in order[stamp[order] > now].tolist():
        keep.predict((int(stamp[place]) - now) * 1e-9)
        now, k = int(stamp[place]), int(index[place])
        if wheels[place]:
            for state, value, sigma in zip((3, 4, 5), twist[k], WHEEL_SIGMA):
                keep.correct(state, value, sigma)
            poses.append(keep.x[:3].copy())
        else:
            keep.correct(5, gyro[k], GYRO_SIGMA)
    return Track(frames, np.array(poses))
