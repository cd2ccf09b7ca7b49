"""Odometry and slip beside the truth: errors of tracks, episodes found and missed.

Both tracks start at pose 0, 0, 0; nothing is aligned. Errors are taken at the stamps of the
odometry, with the truth interpolated between its own stamps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.parameter import FloatArray, IntArray

SLIP_ON = 0.05  # m/s of sliding along a roller axis: above, a wheel truly slips
SLIP_OFF = 0.02  # m/s: below, it truly rolls; between the two nothing is counted
SHORTEST = 0.05  # s: a true episode must last this long to be asked for
NEAR = 0.3  # s: a claim this close to true slip is not a false one


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Poses (N, 3) in odom over stamps (N,), with covariances (N, 3, 3) where known."""

    stamp_ns: IntArray
    pose: FloatArray
    covariance: FloatArray | None = None

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Poses (M, 3) interpolated at other stamps; yaw is unwrapped."""
        if not len(self.stamp_ns):
            return np.full((len(stamp_ns), 3), np.nan)
        seconds = (self.stamp_ns - self.stamp_ns[0]) * 1e-9
        wanted = (stamp_ns - self.stamp_ns[0]) * 1e-9
        columns = [self.pose[:, 0], self.pose[:, 1], np.unwrap(self.pose[:, 2])]
        return np.column_stack([np.interp(wanted, seconds, column) for column in columns])

    def within(self, start_ns: int, end_ns: int) -> Track:
        """The part of the track between two stamps, both included."""
        keep = (self.stamp_ns >= start_ns) & (self.stamp_ns <= end_ns)
        covariance = None if self.covariance is None else self.covariance[keep]
        return Track(self.stamp_ns[keep], self.pose[keep], covariance)


@dataclass(frozen=True, slots=True, eq=False)
class TrackError:
    """Difference of a track to the truth over its own stamps (N,): distance m and yaw rad."""

    stamp_ns: IntArray
    distance: FloatArray
    yaw: FloatArray

    @property
    def final_distance(self) -> float:
        """Position error at the end [m]."""
        return float(self.distance[-1])

    @property
    def final_yaw(self) -> float:
        """Yaw error at the end [rad], signed."""
        return float(self.yaw[-1])

    @property
    def rms_distance(self) -> float:
        """Root mean square of the position error [m] (the ATE without alignment)."""
        return float(np.sqrt(np.mean(self.distance**2)))


def track_error(track: Track, truth: Track) -> TrackError:
    """Error of ``track`` against ``truth`` where their stamps overlap."""
    inside = track.within(int(truth.stamp_ns[0]), int(truth.stamp_ns[-1]))
    want = truth.at(inside.stamp_ns)
    step = inside.pose - want
    yaw = np.unwrap(inside.pose[:, 2]) - want[:, 2]
    yaw = yaw - 2.0 * np.pi * np.round(yaw[:1] / (2.0 * np.pi))
    return TrackError(inside.stamp_ns, np.hypot(step[:, 0], step[:, 1]), yaw)


@dataclass(frozen=True, slots=True)
class Episode:
    """A span of slip: start and end in nanoseconds."""

    start_ns: int
    end_ns: int

    @property
    def seconds(self) -> float:
        """Duration [s]."""
        return (self.end_ns - self.start_ns) * 1e-9


def episodes(flags: np.ndarray, stamp_ns: IntArray) -> list[Episode]:
    """Spans in which ``flags`` (N,) is true."""
    edge = np.diff(np.concatenate(([0], flags.astype(np.int8), [0])))
    return [Episode(int(stamp_ns[a]), int(stamp_ns[b - 1]))
            for a, b in zip(np.where(edge == 1)[0], np.where(edge == -1)[0])]


@dataclass(frozen=True, slots=True, eq=False)
class SlipScore:
    """True episodes, those of them that were claimed, their delays [s] and the false claims."""

    true: list[Episode]
    claimed: list[Episode]
    delays: list[float]
    false: list[Episode]

    @property
    def found(self) -> int:
        """Number of true episodes that were claimed."""
        return len(self.delays)


def slip_score(true_speed: FloatArray, true_stamp: IntArray, probability: FloatArray,
               stamp: IntArray) -> SlipScore:
    """Score the claims ``probability`` (M,) >= 0.5 against true slip speeds (N, W) in m/s."""
    worst = np.max(np.abs(true_speed), axis=1) if true_speed.size else np.zeros(len(true_stamp))
    true = [e for e in episodes(worst > SLIP_ON, true_stamp) if e.seconds >= SHORTEST]
    claims = episodes(probability >= 0.5, stamp)
    delays = []
    for episode in true:
        hits = stamp[(probability >= 0.5) & (stamp >= episode.start_ns)
                     & (stamp <= episode.end_ns + 100_000_000)]
        if len(hits):
            delays.append((int(hits[0]) - episode.start_ns) * 1e-9)
    slipping = true_stamp[worst > SLIP_OFF]
    margin = int(NEAR * 1e9)
    false = [c for c in claims
             if not np.any((slipping >= c.start_ns - margin) & (slipping <= c.end_ns + margin))]
    return SlipScore(true, claims, delays, false)
