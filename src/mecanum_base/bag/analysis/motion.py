"""What wheels and gyro say of the motion, as columns on the encoder's stamps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.recording import Recording, Series
from mecanum_base.bag.decode import IMU, JOINT_STATE, TICKS
from mecanum_base.bag.topics import Topics
from mecanum_base.core.estimation.sensors import EncoderConfig
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.robot import Robot

REST_SECONDS = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class WheelMotion:
    """Wheel angles on the encoder's stamps: ``angle`` (N, W) rad, unwrapped, sign applied."""

    joints: tuple[str, ...]
    stamp_ns: IntArray
    angle: FloatArray

    @property
    def seconds(self) -> FloatArray:
        """Seconds since the first sample."""
        found: FloatArray = (self.stamp_ns - self.stamp_ns[0]) / 1e9
        return found

    def rates(self) -> tuple[FloatArray, FloatArray]:
        """(middle times (N-1,) s since the first sample, rates (N-1, W) rad/s)."""
        seconds = self.seconds
        step = np.diff(seconds)
        return (seconds[1:] + seconds[:-1]) / 2.0, np.diff(self.angle, axis=0) / step[:, None]

    def resting(self, least: float = REST_SECONDS) -> Any:
        """Flag (N,): no wheel moves by more than 5 mrad for at least ``least`` seconds."""
        seconds = self.seconds
        flag = np.zeros(len(seconds), dtype=bool)
        start = 0
        moved = np.abs(np.diff(self.angle, axis=0)).max(axis=1) > 1e-4
        rows = self.angle.tolist()  # numbers of Python are quicker than rows of four
        anchor = rows[0]
        for index in (np.flatnonzero(moved) + 1).tolist():
            if any(abs(now - then) > 5e-3 for now, then in zip(rows[index], anchor)):
                if seconds[index - 1] - seconds[start] >= least:
                    flag[start:index] = True
                start, anchor = index, rows[index]
        if seconds[-1] - seconds[start] >= least:
            flag[start:] = True
        return flag


def encoder_series(recording: Recording, topics: Topics) -> Series | None:
    """The encoder topic of the recording; the only JointState topic if the name is not there."""
    found = recording.find(topics.encoder, (JOINT_STATE, *TICKS))
    if found is None:
        others = [s for s in recording.of_type(JOINT_STATE)
                  if 'command' not in s.channel.topic and 'slip' not in s.channel.topic]
        found = others[0] if len(others) == 1 else None
    return found


def imu_series(recording: Recording, topics: Topics) -> Series | None:
    """The IMU topic of the recording; the only Imu topic if the name is not there."""
    if topics.imu is None:
        return None
    found = recording.find(topics.imu, (IMU,))
    if found is None:
        others = recording.of_type(IMU)
        found = others[0] if len(others) == 1 else None
    return found


def wheel_motion(series: Series, encoder: EncoderConfig | None = None) -> WheelMotion | None:
    """Wheel angles of a JointState or ticks topic; None with less than three usable samples.

    Without an encoder block ticks are taken as they are (angles in counts).
    """
    if 'counts' in series.values:
        counts = series.values['counts']
        width = counts.shape[1]
        names = tuple(f'wheel {i}' for i in range(width))
        if encoder is None:
            angle = counts.astype(np.float64)
        else:
            bits = encoder.counter_bits
            step = np.diff(counts, axis=0)
            if bits < 64:
                half = 1 << (bits - 1)
                step = (step + half) % (1 << bits) - half
            per_turn, sign = encoder.for_wheels(width)
            whole = np.vstack([np.zeros((1, width)), np.cumsum(step, axis=0)])
            angle = whole * (2.0 * np.pi / per_turn) * sign
    elif 'position' in series.values:
        angle = np.array(series.values['position'])
        names = series.names
        good = np.isfinite(angle).all(axis=1)
        if good.sum() < 3:
            angle = _integrated(series)
            good = np.isfinite(angle).all(axis=1)
        series = _where(series, good)
        angle = angle[good]
        if encoder is not None:
            if encoder.position_wrap == 'two_pi':
                angle = np.unwrap(angle, axis=0)
            angle = angle * encoder.for_wheels(angle.shape[1])[1]
    else:
        return None
    keep = np.concatenate(([True], np.diff(np.maximum.accumulate(series.stamp_ns)) > 0)) \
        if len(series) else np.zeros(0, dtype=bool)
    if keep.sum() < 3:
        return None
    return WheelMotion(names, series.stamp_ns[keep], angle[keep])


def _integrated(series: Series) -> FloatArray:
    """Angles from the velocities of a JointState without positions."""
    rate = series.values['velocity']
    step = np.diff(series.stamp_ns, prepend=series.stamp_ns[:1]) / 1e9
    found: FloatArray = np.cumsum(rate * np.clip(step, 0.0, 1.0)[:, None], axis=0)
    return found


def _where(series: Series, good: Any) -> Series:
    return Series(series.channel, series.log_ns[good], series.stamp_ns[good], series.stamped,
                  {k: v[good] for k, v in series.values.items()}, series.names)


def wheel_matrix(robot: Robot) -> FloatArray | None:
    """H (W, 3) of a wheel robot; None for carriers, whose matrix depends on the hinges."""
    return wheels_from_body(robot.base) if isinstance(robot.base, Wheels) else None


def twist_of(motion: WheelMotion, matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(middle times (N-1,), least-squares twist (N-1, 3)) of the wheels."""
    seconds, rate = motion.rates()
    twist: FloatArray = rate @ body_from_wheels(matrix).T
    return seconds, twist


def dead_reckoned(motion: WheelMotion, matrix: FloatArray) -> FloatArray:
    """Pose (N, 3) from the wheels alone, start 0, 0, 0: the exact arc of each step."""
    step = np.diff(motion.angle, axis=0) @ body_from_wheels(matrix).T
    return integrated(step)


def integrated(step: FloatArray) -> FloatArray:
    """Poses (N + 1, 3) of body increments (N, 3), start 0, 0, 0 (SE(2) exponential)."""
    turn = step[:, 2]
    small = np.abs(turn) < 1e-4
    safe = np.where(small, 1.0, turn)
    s = np.where(small, 1.0 - turn**2 / 6.0, np.sin(safe) / safe)
    c = np.where(small, turn / 2.0, (1.0 - np.cos(safe)) / safe)
    dx, dy = s * step[:, 0] - c * step[:, 1], c * step[:, 0] + s * step[:, 1]
    yaw = np.concatenate(([0.0], np.cumsum(turn)))
    cos, sin = np.cos(yaw[:-1]), np.sin(yaw[:-1])
    x = np.concatenate(([0.0], np.cumsum(cos * dx - sin * dy)))
    y = np.concatenate(([0.0], np.cumsum(sin * dx + cos * dy)))
    found: FloatArray = np.column_stack([x, y, yaw])
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Gyro:
    """Inertial columns in base_link or sensor axes, sorted by stamp."""

    stamp_ns: IntArray
    rate: FloatArray  # (N, 3) rad/s
    accel: FloatArray  # (N, 3) m/s^2, NaN where absent


def gyro_motion(series: Series, robot: Robot | None = None,
                turned: bool = True) -> Gyro | None:
    """Inertial columns of an Imu topic, with gyro scale and lateness of the robot file; in sensor
    axes without a robot file or if not ``turned``. None with less than three samples."""
    if 'gyro' not in series.values or len(series) < 3:
        return None
    order = np.argsort(series.stamp_ns, kind='stable')
    stamp = series.stamp_ns[order]
    rate, accel = series.values['gyro'][order], series.values['accel'][order]
    if robot is not None:
        stamp = stamp - robot.imu.late_ns
        rate = rate / robot.imu.gyro_scale
    if robot is not None and turned:
        turn = robot.imu.base_from_sensor()
        rate, accel = rate @ turn.T, accel @ turn.T
    return Gyro(stamp, rate, accel)
