"""Where messages become samples: the one way into the estimator, live and in replay.

:class:`Intake` owns the estimator of a robot. Its methods take messages (of rclpy or of a bag,
see :mod:`mecanum_base.messages`) and return the estimates that became due; a malformed message is
counted and gives none. :meth:`Intake.handle` takes samples that were built elsewhere, with
``imu.late`` taken off their stamps. What
depends on data alone is decided here, so that live and replay agree: which poses can be applied
and when, and the mount of the IMU where it comes from /tf_static. Wheel commands go past the
estimator: they give notes and change no estimate.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from mecanum_base import messages
from mecanum_base.core.command.command_watch import CommandWatch
from mecanum_base.core.estimation.estimator import Estimator
from mecanum_base.core.estimation.health import Health
from mecanum_base.core.estimation.smoother import Piece
from mecanum_base.core.frame_tree import FrameTree
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.records import Estimate, ImuSample, PoseSample, ResetSample, Sample
from mecanum_base.messages import MalformedMessage
from mecanum_base.robot import Robot

Estimates = tuple[Estimate, ...]
Timed = TypeVar('Timed', bound=Sample)
MOUNT_WAIT = 5.0  # s of data that wait for the mount of the IMU before it is left out
_MOST_AHEAD = 16  # poses and resets that wait for data with their stamp
_FARTHEST = 1e9  # m, m^2: what a pose or its variance may be
_NANOSECONDS = 1_000_000_000


class Intake:
    """Turns messages into samples for the estimator of ``robot``.

    A pose or reset stamped later than all sensor data waits until the data has come that far, so
    that a clock ahead of the robot's makes no sample late; stamp 0 means the newest sensor stamp.

    With ``imu.from_tf`` samples wait until :meth:`static_transform` has told the mount; after
    :data:`MOUNT_WAIT` seconds of data the estimator starts without the IMU, and it is started
    anew at its last pose when the mount comes later.
    """

    def __init__(self, robot: Robot, smoothed: bool = False) -> None:
        """``smoothed``: also keep what is learnt later about every frame, for :meth:`past`."""
        self.robot = robot
        self._smoothed = smoothed
        self._past: list[Piece] = []
        self.joints = robot.base.joint
        self.command_watch = CommandWatch(self.joints, robot.encoder)
        self._frames = FrameTree()
        self._ahead: list[PoseSample | ResetSample] = []
        self._held: list[Sample] = []
        self._last: Estimate | None = None
        self.mount_known = not robot.imu.from_tf
        self._holding = not self.mount_known
        self.estimator = self._estimator()

    @property
    def direct(self) -> bool:
        """True while sensor samples go to the estimator as they are: nothing waits here."""
        return self.mount_known and not self._holding and not self._ahead

    def joint_states(self, msg: Any) -> Estimates:
        """Wheel angles (sensor_msgs/JointState)."""
        return self._convert('joint_states', self._wheels, msg)

    def wheel_ticks(self, msg: Any, arrival_ns: int) -> Estimates:
        """Encoder counts (std_msgs/Int64MultiArray or Int32MultiArray), stamped by arrival."""
        return self._convert('wheel_ticks', self._ticks, msg, arrival_ns)

    def imu(self, msg: Any) -> Estimates:
        """Gyro and accelerometer (sensor_msgs/Imu), stamped ``imu.late`` after the measurement."""
        return self._convert('imu', self._inertial, msg)

    def wheel_commands(self, msg: Any, arrival_ns: int) -> None:
        """Commanded wheel rates (sensor_msgs/JointState); stamp 0 means ``arrival_ns``."""
        try:
            found = messages.command_sample(msg, self.joints)
        except MalformedMessage as error:
            self.estimator.reject('wheel_commands', str(error))
            return
        if found is not None:
            self._command(found.stamp_ns or arrival_ns, found.rate)

    def wheel_rates(self, msg: Any, arrival_ns: int) -> None:
        """Commanded wheel rates (std_msgs/Float64MultiArray) in the order of the controller."""
        try:
            rate = messages.rates_of_array(
                msg, self.robot.drive.command_joints or self.joints, self.joints)
        except MalformedMessage as error:
            self.estimator.reject('wheel_commands', str(error))
            return
        self._command(arrival_ns, rate)

    def commanded(self, stamp_ns: IntArray, rate: FloatArray) -> None:
        """Commanded wheel rates (N, W) rad/s of messages, with stamps (N,)."""
        for _ in range(self.command_watch.commands(stamp_ns, rate)):
            self.estimator.reject('wheel_commands', 'not one number a wheel')

    @property
    def health(self) -> Health:
        """That of the estimator, and what the commands tell."""
        health, watch = self.estimator.health, self.command_watch
        if not watch.used:
            return health
        received = health.received.get('wheel_commands', 0) + watch.used
        return dataclasses.replace(
            health, received={**health.received, 'wheel_commands': received},
            used={**health.used, 'wheel_commands': watch.used},
            notes=(*health.notes, *watch.notes))

    def set_pose(self, msg: Any) -> Estimates:
        """A pose given from outside, in ``odom_frame_id`` (PoseWithCovarianceStamped)."""
        return self._convert('set_pose', messages.pose_sample, msg)

    def odometry_reset(self, header: Any) -> Estimates:
        """Start again at pose 0, 0, 0 (std_msgs/Header)."""
        return self._convert('odometry_reset', messages.reset_sample, header)

    def static_transform(self, parent: str, child: str, xyz: Sequence[float],
                         quaternion: Sequence[float]) -> Estimates:
        """A link of /tf_static; it matters only with ``imu.from_tf``."""
        if not self._frames.add(parent, child, xyz, quaternion) or self.mount_known:
            return ()
        frames = self.robot.frames
        mount = self._frames.between(frames.tf_frame_prefix + frames.base_frame_id,
                                     frames.tf_frame_prefix + frames.imu_frame_id)
        if mount is None:
            return ()
        self.robot = self.robot.replace(imu=dataclasses.replace(
            self.robot.imu, xyz=mount[0], rpy=mount[1]))
        self.mount_known = True
        self._past += self.estimator.past(last=True)
        self.estimator = self._estimator()
        if self._last is not None:
            self.estimator.handle(PoseSample(self._last.stamp_ns, self._last.pose,
                                             self._last.pose_covariance))
        return self._release()

    def handle(self, sample: Sample) -> Estimates:
        """Take one sample; the estimates that are now settled."""
        with np.errstate(all='ignore'):  # absurd values are judged, not warned of
            return self._take(sample)

    def _take(self, sample: Sample) -> Estimates:
        if self._holding:
            self._held.append(sample)
            waited = sample.stamp_ns - self._held[0].stamp_ns
            return self._release() if waited > MOUNT_WAIT * _NANOSECONDS else ()
        if isinstance(sample, (PoseSample, ResetSample)):
            return self._place(sample)
        due: Estimates = ()
        if self._ahead:
            reached = [item for item in self._ahead if item.stamp_ns <= sample.stamp_ns]
            self._ahead = [item for item in self._ahead if item.stamp_ns > sample.stamp_ns]
            for item in reached:
                due += self.estimator.handle(_at(item, item.stamp_ns or sample.stamp_ns))
        if isinstance(sample, ImuSample) and not self.mount_known:
            self.estimator.reject('imu', 'mount unknown: not on tf_static')
            return self._remember(due)
        return self._remember(due + self.estimator.handle(sample))

    def flush(self) -> Estimates:
        """The end of the data: everything that still waits."""
        self.command_watch.flush()
        return self._remember(self._release() + self.estimator.flush())

    def past(self, last: bool = False) -> tuple[Piece, ...]:
        """What later readings say of frames that none can change any more; see the estimator."""
        found, self._past = (*self._past, *self.estimator.past(last)), []
        return found

    def _place(self, sample: PoseSample | ResetSample) -> Estimates:
        """Apply a pose or reset at its stamp, or let it wait for the data."""
        frames = self.robot.frames
        if isinstance(sample, PoseSample) and sample.frame not in (
                '', frames.odom_frame_id, frames.tf_frame_prefix + frames.odom_frame_id):
            self.estimator.reject('set_pose', f'in frame {sample.frame!r} instead of '
                                  f'{frames.odom_frame_id!r}')
            return ()
        if isinstance(sample, PoseSample) and not (
                np.all(np.abs(sample.pose) < _FARTHEST)
                and np.all(np.abs(sample.covariance) < _FARTHEST)):
            self.estimator.reject('set_pose', 'not a number or out of range')
            return ()
        newest = self.estimator.newest_ns
        if newest is None or sample.stamp_ns > newest:
            self._ahead = [*self._ahead, sample][-_MOST_AHEAD:]
            return ()
        return self._remember(self.estimator.handle(_at(sample, sample.stamp_ns or newest)))

    def _convert(self, stream: str, convert: Callable[..., Sample | None], msg: Any,
                 *more: Any) -> Estimates:
        try:
            sample = convert(msg, *more)
        except MalformedMessage as error:
            self.estimator.reject(stream, str(error))
            return ()
        return () if sample is None else self.handle(sample)

    def _wheels(self, msg: Any) -> Sample | None:
        sample = messages.wheel_sample(msg, self.joints)
        if sample is not None:
            self.command_watch.reading(sample.stamp_ns, sample.position)
        return sample

    def _inertial(self, msg: Any) -> Sample:
        sample = messages.imu_sample(msg)
        late_ns = self.robot.imu.late_ns
        return _at(sample, sample.stamp_ns - late_ns) if late_ns else sample

    def _ticks(self, msg: Any, arrival_ns: int) -> Sample:
        sample = messages.tick_sample(msg, len(self.joints), arrival_ns)
        self.command_watch.reading(sample.stamp_ns, sample.counts)
        return sample

    def _command(self, stamp_ns: int, rate: FloatArray) -> None:
        self.commanded(np.array([stamp_ns], dtype=np.int64), rate[None])

    def _release(self) -> Estimates:
        """End the wait for the mount."""
        self._holding = False
        held, self._held = self._held, []
        return tuple(estimate for sample in held for estimate in self.handle(sample))

    def _remember(self, estimates: Estimates) -> Estimates:
        if estimates:
            self._last = estimates[-1]
        return estimates

    def _estimator(self) -> Estimator:
        robot = self.robot
        return Estimator(robot.base, robot.encoder, robot.imu, robot.estimator, self._smoothed)


def _at(sample: Timed, stamp_ns: int) -> Timed:
    return dataclasses.replace(sample, stamp_ns=stamp_ns)
