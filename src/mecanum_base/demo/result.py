"""What a demo run has measured: tracks, wheels, slip and the phases of the drive."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.demo.comparison import SlipScore, Track, TrackError, track_error

SIGMAS_95 = 2.448  # radius of the 95 % ellipse of two dimensions, in sigmas


@dataclass(frozen=True, slots=True)
class Phase:
    """A named part of the drive between two stamps."""

    name: str
    start_ns: int
    end_ns: int


@dataclass(frozen=True, slots=True, eq=False)
class WheelHistory:
    """Commanded and measured wheel rates (N, W) in rad/s over stamps (N,)."""

    command_stamp: IntArray
    command: FloatArray
    stamp: IntArray
    rate: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class SlipHistory:
    """Estimated and true slip: speeds (N, W) m/s along the roller axes, probabilities (N, W)."""

    stamp: IntArray
    speed: FloatArray
    probability: FloatArray
    body_probability: FloatArray
    true_stamp: IntArray
    true_speed: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class DemoResult:
    """All that the table, the picture and the page show."""

    name: str
    joint: tuple[str, ...]
    truth: Track
    fused: Track
    wheel_only: Track
    wheels: WheelHistory
    slip: SlipHistory
    score: SlipScore
    phases: tuple[Phase, ...]

    @property
    def fused_error(self) -> TrackError:
        """Error of the published odometry."""
        return track_error(self.fused, self.truth)

    @property
    def wheel_only_error(self) -> TrackError:
        """Error of wheel-only odometry."""
        return track_error(self.wheel_only, self.truth)

    @property
    def path_length(self) -> float:
        """True length of the way [m]."""
        steps = np.diff(self.truth.pose[:, :2], axis=0)
        return float(np.sum(np.hypot(steps[:, 0], steps[:, 1])))

    def largest_yaw(self, phase: Phase) -> tuple[float, float]:
        """Largest change of yaw [rad] within a phase: (of the truth, of the odometry)."""
        found = []
        for track in (self.truth, self.fused):
            yaw = np.unwrap(track.within(phase.start_ns, phase.end_ns).pose[:, 2])
            found.append(float(np.max(np.abs(yaw - yaw[0]))) if len(yaw) else math.nan)
        return found[0], found[1]

    def seconds(self, stamp_ns: IntArray) -> FloatArray:
        """Stamps as seconds since the truth begins, to 0.1 ms."""
        return np.round((stamp_ns - self.truth.stamp_ns[0]) * 1e-9, 4)

    def own_bound(self) -> tuple[FloatArray, FloatArray] | None:
        """(time [s], radius [m]) that the odometry itself claims for 95 % of its errors in x, y.

        The larger half axis of the ellipse of its covariance; None if it has none.
        """
        if self.fused.covariance is None:
            return None
        inside = self.fused.within(int(self.truth.stamp_ns[0]), int(self.truth.stamp_ns[-1]))
        assert inside.covariance is not None
        largest = np.linalg.eigvalsh(inside.covariance[:, :2, :2])[:, 1]
        return self.seconds(inside.stamp_ns), SIGMAS_95 * np.sqrt(largest)

    def consistency(self) -> float:
        """Median over time of e' P^-1 e for (x, y); 1.39 for a perfect covariance."""
        if self.fused.covariance is None:
            return math.nan
        inside = self.fused.within(int(self.truth.stamp_ns[0]), int(self.truth.stamp_ns[-1]))
        assert inside.covariance is not None
        step = (inside.pose - self.truth.at(inside.stamp_ns))[:, :2]
        weighted = np.linalg.solve(inside.covariance[:, :2, :2] + 1e-12 * np.eye(2),
                                   step[:, :, None])[:, :, 0]
        moved = np.hypot(inside.pose[:, 0], inside.pose[:, 1]) > 0.05
        squares = np.sum(step * weighted, axis=1)[moved]
        return float(np.median(squares)) if len(squares) else math.nan
