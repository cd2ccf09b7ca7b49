"""Frozen records that flow through the estimator: samples in, estimates out.

Stamps are integer nanoseconds. Arrays are float64; W is the number of wheels in the order of
``wheels.joint`` of the robot file. Frames follow REP-103 and REP-105: pose of ``base_link`` in
``odom`` as (x [m], y [m], yaw [rad]), twist in ``base_link`` as (vx [m/s], vy [m/s], wz [rad/s]).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Union

from mecanum_base.core.parameter import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class WheelSample:
    """Wheel angles of one joint_states message, in the joints' own sign and zero.

    ``position`` (W,) rad and ``velocity`` (W,) rad/s; NaN marks a wheel the message did not name
    or a field it left empty. The robot file's sign and wrap are applied by the estimator.
    ``hinge`` (C,) rad are measured hinge angles of a carrier base, None where there are none.
    """

    stamp_ns: int
    position: FloatArray
    velocity: FloatArray
    hinge: FloatArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class TickSample:
    """Cumulative encoder counts (W,) of one wheel_ticks message, before wrap and sign."""

    stamp_ns: int
    counts: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class ImuSample:
    """One IMU reading in the sensor's own frame (REP-145).

    ``gyro`` (3,) rad/s; ``accel`` (3,) specific force in m/s^2 (+9.81 on z at rest), NaN where the
    message says that it has none (covariance[0] = -1).
    """

    stamp_ns: int
    gyro: FloatArray
    accel: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class CommandSample:
    """Commanded wheel rates (W,) rad/s; an optional input of the slip estimate."""

    stamp_ns: int
    rate: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PoseSample:
    """A pose given from outside (set_pose): pose (3,) and covariance (3, 3) in ``frame``.

    ``frame`` is empty or names the odometry frame; others are refused at the border.
    """

    stamp_ns: int
    pose: FloatArray
    covariance: FloatArray
    frame: str = ''


@dataclass(frozen=True, slots=True, eq=False)
class ResetSample:
    """A request to start again at pose 0, 0, 0 (service ~/reset)."""

    stamp_ns: int


Sample = Union[WheelSample, TickSample, ImuSample, CommandSample, PoseSample, ResetSample]


class SlipEstimate(NamedTuple):
    """Slip of every wheel and of the body at one stamp.

    ``rate`` (W,) rad/s: wheel rate minus rolling-consistent rate; ``angle`` (W,) rad: its
    integral; ``probability`` (W,): that the wheel slips now; ``body_probability``: that any
    wheel does; ``ratio`` (W + 1,): Tlale's s (T eq. 4) per wheel, then of the body, NaN where
    undefined; ``twist`` (3,): wheel twist minus body twist in base_link, and its
    ``twist_covariance`` (3, 3).
    """

    rate: FloatArray
    angle: FloatArray
    probability: FloatArray
    body_probability: float
    ratio: FloatArray
    twist: FloatArray
    twist_covariance: FloatArray


class Estimate(NamedTuple):
    """Odometry at one stamp: pose (3,) in odom, twist (3,) in base_link, covariances (3, 3).

    ``source`` is ``encoder`` where the stamp is that of an encoder sample, else ``predicted``.
    """

    stamp_ns: int
    source: str
    pose: FloatArray
    pose_covariance: FloatArray
    twist: FloatArray
    twist_covariance: FloatArray
    slip: SlipEstimate


@dataclass(frozen=True, slots=True, eq=False)
class SlipEpisode:
    """One connected time during which the base slipped.

    ``wheels`` indices in wheel order; ``kind`` one of single, diagonal, axle, side, all, several,
    pushed, wheel jammed, encoder dead; ``probability`` highest of the body in the episode;
    ``distance`` m that the wheels lost, along the roller axes, of the worst wheel;
    ``peak`` m/s highest slip speed. ``end_ns`` is the last stamp so far while it lasts.
    """

    start_ns: int
    end_ns: int
    wheels: tuple[int, ...]
    kind: str
    probability: float
    distance: float
    peak: float
