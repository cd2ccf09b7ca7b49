"""The columns that doctor and calibration work on, from one recording and a robot file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mecanum_base.bag.analysis.arrival import Arrivals, arrivals
from mecanum_base.bag.analysis.doctor import Verdict, examine
from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.motion import (
    Gyro,
    WheelMotion,
    encoder_series,
    gyro_motion,
    imu_series,
    wheel_motion,
)
from mecanum_base.bag.analysis.recording import TWIST, TWIST_STAMPED, Recording, load
from mecanum_base.bag.analysis.truth import track_of, truth_series
from mecanum_base.bag.topics import Topics, advice
from mecanum_base.core.errors import BagError, ConfigError
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.robot import Robot


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """``motion`` as the robot file reads it, ``gyro`` in sensor axes, poses of the truth, twists
    of the commands, the order of arrival."""

    robot: Robot
    motion: WheelMotion
    gyro: Gyro | None
    truth: Track | None
    command: Track | None
    arrived: Arrivals | None = None

    def examined(self) -> Verdict:
        """The doctor's verdict."""
        return examine(self.robot, self.motion, self.gyro, self.truth, self.command)


def evidence_of(paths: str | list[str], robot: Robot, encoder_topic: str | None = None,
                imu_topic: str | None = None, use_imu: bool = True,
                truth_topic: str | None = None,
                step: Callable[[float], None] | None = None,
                truth_frame: str | None = None) -> Evidence:
    """Read a recording; ``truth_frame``: parent of the base where /tf is the truth.

    BagError without usable encoder messages, ConfigError for carriers.
    """
    if not isinstance(robot.base, Wheels):
        raise ConfigError('carriers', '...', 'doctor and calibrate know roller wheels only')
    recording = load(paths, robot.base.joint, step)
    topics = Topics.of(robot, encoder_topic, imu_topic, use_imu)
    encoder = encoder_series(recording, topics)
    motion = wheel_motion(encoder, robot.encoder) if encoder is not None else None
    if encoder is None or motion is None:
        known = [series.channel for series in recording.series.values()]
        raise BagError(f'{", ".join(recording.paths)}: '
                       f'{advice("encoder", str(topics.encoder), known)}')
    imu = imu_series(recording, topics)
    truth = truth_series(recording, truth_topic)
    return Evidence(robot, motion,
                    gyro_motion(imu, robot, turned=False) if imu is not None else None,
                    track_of(truth, truth_frame) if truth is not None else None,
                    _commands(recording), arrivals(encoder, imu, robot.imu.late_ns))


def _commands(recording: Recording) -> Track | None:
    for name in ('cmd_vel_limited', 'cmd_vel'):
        series = recording.find(name, (TWIST, TWIST_STAMPED))
        if series is not None and len(series) >= 5:
            return Track(series.log_ns, series.values['twist'])
    return None
