"""All findings on one recording, as plain JSON values with columns for the plots.

The same function serves one bag, a pool of processes and a cluster, so results are equal.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mecanum_base import __version__
from mecanum_base.bag.analysis import plot_columns
from mecanum_base.bag.analysis.drift import Drift, Track, drift_of
from mecanum_base.bag.analysis.encoder_checks import encoder_findings
from mecanum_base.bag.analysis.estimate import (
    EstimatedTrack,
    estimated,
    following_findings,
    health_findings,
    slip_findings,
)
from mecanum_base.bag.analysis.findings import Finding, ordered
from mecanum_base.bag.analysis.geometry_checks import (
    command_findings,
    excitation,
    excitation_findings,
    parity_findings,
    yaw_findings,
)
from mecanum_base.bag.analysis.imu_checks import imu_findings
from mecanum_base.bag.analysis.motion import (
    Gyro,
    WheelMotion,
    dead_reckoned,
    encoder_series,
    gyro_motion,
    imu_series,
    wheel_matrix,
    wheel_motion,
)
from mecanum_base.bag.analysis.recording import ODOMETRY, Recording, Series, load
from mecanum_base.bag.analysis.timing import timing_findings, topic_table
from mecanum_base.bag.analysis.truth import (
    scale_findings,
    track_of,
    truth_findings,
    truth_series,
)
from mecanum_base.bag.summary import plain, sha256_of
from mecanum_base.bag.topics import Topics
from mecanum_base.core.errors import BagError, MecanumBaseError
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.robot import Robot
from mecanum_base.robot_file import load_robot

Step = Callable[[float], None]
_DRIFT = 0.05  # of the path: a warning


@dataclass(frozen=True, slots=True)
class Options:
    """What to analyse with; plain values, so that it can be sent to another process."""

    robot_file: str | None = None
    encoder_topic: str | None = None
    imu_topic: str | None = None
    use_imu: bool = True
    truth_topic: str | None = None
    truth_frame: str | None = None


def analyze(path: str, options: Options, step: Step | None = None) -> dict[str, Any]:
    """Findings, tables and plot columns of one recording.

    An unreadable recording gives a result with one blocker; nothing is raised for data.
    """
    try:
        return _analyze(path, options, step)
    except MecanumBaseError as error:
        finding = Finding('blocker', 'unreadable', 'the recording cannot be analysed', str(error),
                          'see the message')
        return result_of(path, options, None, [finding])


def _analyze(path: str, options: Options, step: Step | None) -> dict[str, Any]:
    robot = load_robot(options.robot_file) if options.robot_file else None
    topics = (Topics.of(robot, options.encoder_topic, options.imu_topic, options.use_imu)
              if robot else Topics(encoder=options.encoder_topic or 'joint_states',
                                   imu=options.imu_topic or 'imu/data_raw'))
    recording = load([path], robot.base.joint if robot else (), step)
    findings = _loss_findings(recording) + timing_findings(recording)
    encoder, imu = encoder_series(recording, topics), imu_series(recording, topics)
    motion = wheel_motion(encoder, robot.encoder if robot else None) if encoder else None
    gyro = gyro_motion(imu, robot) if imu else None
    findings += _sensor_findings(encoder, imu, motion, gyro, robot)
    matrix = wheel_matrix(robot) if robot else None
    moved: dict[str, float] = {}
    if encoder and motion is not None:
        row = body_from_wheels(matrix)[2] if matrix is not None else None
        if gyro is not None and imu is not None:
            findings += yaw_findings(imu.channel.topic, motion, gyro, row)[0]
        if robot is not None and matrix is not None and isinstance(robot.base, Wheels):
            moved = excitation(motion, matrix)
            findings += excitation_findings(moved)
            findings += parity_findings(encoder.channel.topic, motion, robot.base, matrix)
            findings += command_findings(recording, motion, matrix)
    truth_topic = truth_series(recording, options.truth_topic)
    truth = track_of(truth_topic, options.truth_frame) if truth_topic else None
    if truth_topic and truth is not None:
        findings += truth_findings(truth_topic.channel.topic, truth)
    tracks: dict[str, Track] = {}
    estimate = None
    if robot is not None and motion is not None and encoder is not None:
        named = dataclasses.replace(topics, encoder=encoder.channel.topic)
        if imu is not None:
            named = dataclasses.replace(named, imu=imu.channel.topic)
        estimate = estimated([path], robot, named)
        if estimate is not None:
            tracks['estimator'] = estimate.track
            findings += slip_findings(estimate, recording.origin_ns, robot.base.count > 3)
            findings += following_findings(estimate, recording.origin_ns)
            findings += health_findings(estimate)
        if matrix is not None:
            tracks['wheels only'] = Track(motion.stamp_ns, dead_reckoned(motion, matrix))
            if truth is not None:
                findings += scale_findings(motion, matrix, truth)
    tracks.update(_recorded(recording, truth_topic))
    drifts, aligned = _drifts(tracks, truth)
    findings += _drift_findings(drifts)
    columns = plot_columns.columns(recording, motion, gyro, matrix, estimate, tracks, aligned,
                                   truth, encoder)
    return result_of(path, options, recording, findings, drifts, moved, estimate, columns)


def _sensor_findings(encoder: Series | None, imu: Series | None, motion: WheelMotion | None,
                     gyro: Gyro | None, robot: Robot | None) -> list[Finding]:
    found: list[Finding] = []
    if encoder is None or motion is None:
        found.append(Finding(
            'blocker' if robot else 'note', 'no_encoders', 'there are no usable encoder messages',
            'no joint_states or wheel_ticks with at least three samples that name the wheels',
            'name the topic with --encoder-topic, and check the joint names of the robot file'))
    else:
        top = robot.base.max_speed if robot and isinstance(robot.base, Wheels) else None
        counts = robot.encoder.for_wheels(robot.base.count)[0] if robot else None
        found += encoder_findings(encoder.channel.topic, motion, top, counts)
    if imu is None or gyro is None:
        found.append(Finding('note', 'no_imu', 'there is no IMU', 'no sensor_msgs/Imu topic',
                             'yaw and slip come from the wheels alone'))
    else:
        found += imu_findings(imu.channel.topic, gyro, motion)
    return found


def _loss_findings(recording: Recording) -> list[Finding]:
    found = [Finding('note', 'folder', 'the bag folder is not complete', note,
                     '`ros2 bag reindex` writes a new metadata.yaml') for note in recording.notes]
    loss = recording.loss
    if loss:
        found.append(Finding(
            'warning' if loss.bytes else 'note', 'loss', 'the recording is cut or damaged',
            loss.text(), '`mecanum record --recover FILE` makes a whole bag of what is left',
            numbers={'bytes': float(loss.bytes), 'seconds': loss.seconds}))
    return found


def _recorded(recording: Recording, truth: Series | None) -> dict[str, Track]:
    """Odometry that the robot itself published."""
    found = {}
    for series in recording.of_type(ODOMETRY):
        if series is truth or 'truth' in series.channel.topic:
            continue
        track = track_of(series)
        if track is not None:
            found[f'recorded {series.channel.topic}'] = track
    return found


def _drifts(tracks: dict[str, Track],
            truth: Track | None) -> tuple[list[Drift], dict[str, Any]]:
    drifts, aligned = [], {}
    if truth is not None:
        for name, track in tracks.items():
            found = drift_of(name, track, truth)
            if found is not None:
                drifts.append(found[0])
                aligned[name] = found[1]
    return drifts, aligned


def _drift_findings(drifts: list[Drift]) -> list[Finding]:
    found = []
    for drift in drifts:
        shown = (f'{drift.name}: ATE {drift.ate:.3f} m, final error {drift.final:.3f} m '
                 f'({100 * drift.final_share:.1f} % of {drift.path:.1f} m)')
        if drift.yaw_final is not None:
            shown += f', final yaw error {np.degrees(drift.yaw_final):+.1f} deg'
        shown += f'; alignment: {drift.alignment}'
        found.append(Finding(
            'warning' if drift.final_share > _DRIFT else 'note', 'drift',
            f'drift of the {drift.name} against the truth' if drift.name == 'estimator'
            else f'drift of {drift.name} against the truth', shown,
            'calibrate (`mecanum calibrate`), then look at slip' if drift.final_share > _DRIFT
            else 'nothing to do',
            numbers={'ate': drift.ate, 'final': drift.final, 'share': drift.final_share}))
    return found


def result_of(path: str, options: Options, recording: Recording | None, findings: list[Finding],
            drifts: list[Drift] | None = None, moved: dict[str, float] | None = None,
            estimate: EstimatedTrack | None = None,
            columns: dict[str, Any] | None = None) -> dict[str, Any]:
    """The plain result of one recording; None or empty for what was not reached."""
    result = {
        'bag': path, 'name': name_of(path),
        'robot_file': options.robot_file,
        'robot_sha256': sha256_of(options.robot_file)
        if options.robot_file and os.path.isfile(options.robot_file) else None,
        'version': __version__,
        'duration': recording.seconds if recording else None,
        'topics': topic_table(recording) if recording else [],
        'findings': [f.plain() for f in ordered(findings)],
        'counts': {s: sum(f.severity == s for f in findings)
                   for s in ('blocker', 'warning', 'note')},
        'drift': [dataclasses.asdict(d) for d in drifts or []],
        'motion': moved or {},
        'slip_episodes': list(estimate.episodes) if estimate else [],
        'plots': columns or {},
    }
    found: dict[str, Any] = plain(result)
    return found


def name_of(path: str) -> str:
    """Short name of a recording: its last part, with the folder before it where that is 'bag'."""
    parts = os.path.normpath(os.path.abspath(path)).split(os.sep)
    plain_name = parts[-1].split('.')[0].rstrip('_0') in ('bag', 'rosbag2', '')
    return '/'.join(parts[-2:]) if plain_name else parts[-1]


def check_options(paths: list[str], options: Options) -> None:
    """Raise the errors of usage (robot file, paths) before any work is done."""
    if options.robot_file:
        load_robot(options.robot_file)
    for path in paths:
        if not os.path.exists(path):
            raise BagError(f'{path}: does not exist')
