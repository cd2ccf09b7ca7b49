"""The estimator's own track over a recording, kept as columns for findings and plots."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.findings import Finding
from mecanum_base.bag.replay import replay_into
from mecanum_base.bag.summary import episode_of
from mecanum_base.bag.topics import Topics
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.records import Estimate
from mecanum_base.robot import Robot

_ALWAYS = 0.7  # of the time: no episode any more
_LOST = 0.05  # m of slip in one episode worth a warning


@dataclass(slots=True)
class Columns:
    """A sink that keeps pose, covariance and slip of every estimate, by rows where they come so.

    A row is (x y yaw, rms position, sigma of yaw, slip rate and probability of each wheel in turn,
    probability of the body).
    """

    stamps: list[IntArray] = field(default_factory=list)
    rows: list[FloatArray] = field(default_factory=list)

    def write(self, estimate: Estimate) -> None:
        """Keep one estimate."""
        cov, slip = estimate.pose_covariance, estimate.slip
        pairs = np.column_stack([slip.rate, slip.probability]).reshape(-1)
        self.stamps.append(np.array([estimate.stamp_ns], dtype=np.int64))
        self.rows.append(np.concatenate([
            estimate.pose, _spread(cov[0, 0] + cov[1, 1], cov[2, 2]), pairs,
            [slip.body_probability]])[None])

    def write_rows(self, stamp_ns: IntArray, track: FloatArray, slip: FloatArray,
                   predicted: IntArray) -> None:
        """Keep many at once, in the columns of TrackWriter."""
        self.stamps.append(stamp_ns.copy())
        self.rows.append(np.column_stack([
            track[:, :3], _spread(track[:, 6] + track[:, 8], track[:, 11]).T, slip]))

    def close(self) -> None:
        """Nothing to do."""


def _spread(position: Any, yaw: Any) -> FloatArray:
    """Standard deviations (2, ...) of variances."""
    found: FloatArray = np.sqrt(np.maximum(np.array([position, yaw]), 0.0))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class EstimatedTrack:
    """Columns of the estimator's output: track, spread (N, 2), slip (N, W), probabilities."""

    track: Track
    sigma: FloatArray
    slip: FloatArray
    probability: FloatArray
    body: FloatArray
    episodes: tuple[dict[str, Any], ...]
    health: Any
    path: float
    strayed: tuple[tuple[str, int, float], ...] = ()  # as of CommandWatch

    @property
    def stamp_ns(self) -> IntArray:
        """Stamps (N,)."""
        return self.track.stamp_ns

    @property
    def seconds(self) -> float:
        """Time from the first to the last estimate."""
        return float(self.stamp_ns[-1] - self.stamp_ns[0]) / 1e9


def estimated(paths: list[str], robot: Robot, topics: Topics,
              step: Callable[[float, float], None] | None = None) -> EstimatedTrack | None:
    """Run the estimator of the odometry node; None where it gives no estimate."""
    columns = Columns()
    done = replay_into(paths, robot, lambda: columns, topics, step)
    if not sum(map(len, columns.rows)):
        return None
    table = np.concatenate(columns.rows)
    return EstimatedTrack(
        Track(np.concatenate(columns.stamps), table[:, :3]), table[:, 3:5], table[:, 5:-1:2],
        table[:, 6:-1:2], table[:, -1],
        tuple(episode_of(e, robot.base.joint) for e in done.intake.estimator.episodes),
        dataclasses.replace(done.intake.health, notes=done.intake.estimator.health.notes),
        done.course.path, done.intake.command_watch.strayed)


def slip_findings(found: EstimatedTrack, origin_ns: int, redundant: bool) -> list[Finding]:
    """Slip episodes by wheel: how often, how long, how far.

    Without an IMU and without ``redundant`` wheels nothing contradicts a wheel, so none is given.
    """
    if not redundant and found.health.imu == 'none':
        return [Finding(
            'note', 'slip_unseen', 'slip cannot be seen in this recording',
            f'three wheels and no IMU: each wheel speed is a possible motion (the estimator '
            f'doubts {len(found.episodes)} sudden changes of speed)',
            'record an IMU; compare with a true pose')]
    if not found.episodes:
        return [Finding('note', 'no_slip', 'no slip was found',
                        f'over {found.path:.1f} m of way', 'nothing to do')]
    longest = max(float(e['end'] - e['start']) for e in found.episodes)
    if longest > _ALWAYS * found.seconds:
        return [Finding(
            'warning', 'wheels_doubted', 'wheels and IMU disagree nearly all the time',
            f'the estimator doubts the wheels for {longest:.1f} of {found.seconds:.1f} s in one '
            'go: a wrong constant, noisy wheel speeds or wheels that spin freely, rather than '
            'an episode of slip', 'look at the findings on noise, yaw and scales; `mecanum '
            'doctor` looks for wiring faults', numbers={'seconds': longest})]
    lost: dict[str, float] = {}
    for episode in found.episodes:
        for wheel in episode['wheels']:
            lost[wheel] = lost.get(wheel, 0.0) + float(episode['slip_distance'])
    total = sum(float(e['end'] - e['start']) for e in found.episodes)
    worst = max(found.episodes, key=lambda e: float(e['slip_distance']))
    shares = ', '.join(f'{wheel} {value:.3f} m'
                       for wheel, value in sorted(lost.items(), key=lambda i: -i[1]))
    kinds = sorted({str(e['kind']) for e in found.episodes})
    severe = max(lost.values()) > max(_LOST, 0.01 * found.path)
    return [Finding(
        'warning' if severe else 'note', 'slip', 'wheels slip',
        f'{len(found.episodes)} episodes, {total:.1f} s in all ({", ".join(kinds)}); lost by '
        f'wheel: {shares}; longest way {worst["slip_distance"]:.3f} m at '
        f'{worst["start"] - origin_ns / 1e9:.1f} s with probability {worst["probability"]:.2f}',
        'drive more gently (drive.max_acceleration), look at the floor there, load the wheels '
        'evenly', spans=tuple((float(e['start'] - origin_ns / 1e9),
                               float(e['end'] - origin_ns / 1e9)) for e in found.episodes[:100]),
        numbers={'episodes': float(len(found.episodes)), 'seconds': total,
                 'largest': float(worst['slip_distance'])})]


def following_findings(found: EstimatedTrack, origin_ns: int) -> list[Finding]:
    """Wheels that do not follow their recorded commands; none where no command was recorded."""
    if not found.strayed:
        return []
    shown = '; '.join(f'{joint} {seconds:.1f} s in all, first at {(first - origin_ns) / 1e9:.1f} s'
                      for joint, first, seconds in found.strayed)
    return [Finding(
        'warning', 'wheel_not_following', 'a wheel does not follow its command', shown,
        'is the wheel jammed, the motor too weak or without power, the encoder dead, or the '
        'order or sign of the wheels wrong?', 'wheel_commands',
        numbers={'seconds': max(seconds for _, _, seconds in found.strayed)})]


def health_findings(found: EstimatedTrack) -> list[Finding]:
    """What the estimator rejected, and what it says it cannot see."""
    result = []
    received = sum(found.health.received.values())
    for (stream, reason), count in sorted(found.health.rejected.items()):
        share = count / max(found.health.received.get(stream, received), 1)
        result.append(Finding(
            'warning' if share > 0.01 else 'note', 'rejected',
            f'the estimator rejects messages of {stream}',
            f'{count} for the reason "{reason}" ({100 * share:.2f} %)',
            'see the findings on stamps and gaps', stream, numbers={'share': share}))
    if found.health.notes:
        result.append(Finding('note', 'limits', 'what cannot be seen',
                              '; '.join(found.health.notes),
                              'keep it in mind when reading the figures'))
    return result
