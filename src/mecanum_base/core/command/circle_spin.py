"""The circle-and-spin experiment of source D in closed loop, on any base (D eq. 19-24).

The goal runs along :class:`CircleSpin`; :class:`GoalField` commands a twist from the measured
pose; the wheels are scaled to their limits and turn as told; the base moves as its wheels say. A
dual-differential platform also turns its hinges. No slip: what is left is the error of the
control law and of the pose source. The paper reports 0.04 m with a camera of 30 frames a second;
:class:`Camera` imitates it: sampled, quantised, optionally late.
"""

from __future__ import annotations

import collections
import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core import se2
from mecanum_base.core.command.potential_field import GoalField
from mecanum_base.core.command.trajectory import CircleSpin
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.saturation import scale_to_limits
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform import differential
from mecanum_base.core.platform.carriers import Carriers

PAPER_ERROR = 0.04  # m, as reported by source D


@dataclass(frozen=True, slots=True)
class Camera:
    """Camera of the paper: ``rate`` Hz, quanta ``pixel`` m and ``angle`` rad, ``delay`` frames."""

    rate: float = 30.0
    pixel: float = 0.0025
    angle: float = math.radians(1.0)
    delay: int = 1

    def quantise(self, pose: FloatArray) -> FloatArray:
        """The pose (3,) on the grid of the camera."""
        grid = np.array([self.pixel, self.pixel, self.angle])
        return np.where(grid > 0.0, np.round(pose / np.where(grid > 0.0, grid, 1.0)) * grid, pose)


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Poses over the run: ``time`` (N,) s, ``pose``, ``reference`` (N, 3), ``rates`` (N, W) rad/s.

    ``settled`` s is left out of the error figures: the time the start takes.
    """

    time: FloatArray
    pose: FloatArray
    reference: FloatArray
    rates: FloatArray
    settled: float

    def distance(self) -> FloatArray:
        """(N,) m between the base and its reference."""
        gap: FloatArray = np.hypot(*(self.pose - self.reference)[:, :2].T)
        return gap

    def figures(self) -> dict[str, float]:
        """Position error mean, rms, max [m] and heading error max [rad] after settling."""
        late = self.time >= self.settled
        gap = self.distance()[late]
        turn = (self.pose - self.reference)[late, 2]
        return {'mean': float(np.mean(gap)), 'rms': float(np.sqrt(np.mean(gap**2))),
                'max': float(np.max(gap)),
                'heading_max': float(np.max(np.abs(np.arctan2(np.sin(turn), np.cos(turn))))),
                'paper': PAPER_ERROR}


def run(base: Wheels | Carriers, field: GoalField, path: CircleSpin, *, duration: float,
        feed_forward: bool | None = None, camera: Camera | None = None, step: float = 0.01,
        start: FloatArray | None = None, settled: float = 0.0) -> Run:
    """Follow ``path`` for ``duration`` s in steps of ``step`` s, from ``start`` (3,) or the path.

    ``feed_forward`` None: as the field is set. Without ``camera`` the controller sees
    the true pose at every step. Between steps the wheel rates are constant.
    """
    leads = field.config.feed_forward if feed_forward is None else feed_forward
    pose = path.pose(0.0) if start is None else np.array(start, dtype=np.float64)
    hinges = np.array(base.initial_angle) if isinstance(base, Carriers) else np.zeros(0)
    frames = _Frames(camera, pose)
    count = int(round(duration / step))
    poses, references, turned = [pose], [path.pose(0.0)], [np.zeros(base.count)]
    for index in range(count):
        time = index * step
        seen = frames.look(time, pose)
        reference = path.pose(time)
        wanted = field.twist(seen, reference, float(reference[2]),
                             path.velocity(time) if leads else None)
        pose, hinges, rates = advance(base, pose, hinges, wanted, step)
        poses.append(pose)
        references.append(path.pose(time + step))
        turned.append(rates)
    time_grid = step * np.arange(count + 1, dtype=np.float64)
    return Run(time_grid, np.array(poses), np.array(references), np.array(turned), settled)


def advance(base: Wheels | Carriers, pose: FloatArray, hinges: FloatArray, twist: FloatArray,
            step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(pose (3,), hinge angles, wheel rates (W,)) after ``step`` s of the wanted ``twist`` (3,).

    The wheel rates hold still over the step; hinge angles (C,) rad are empty for roller wheels
    and integrated by the midpoint rule for carriers.
    """
    if isinstance(base, Wheels):
        matrix = wheels_from_body(base)
        rates = matrix @ twist
        rates = rates * scale_to_limits(rates, base.max_speed)
        return se2.compose(pose, se2.exp(body_from_wheels(matrix) @ rates * step)), hinges, rates
    rates = differential.wheels_from_body(base, hinges) @ twist
    rates = rates * scale_to_limits(rates, np.repeat(base.max_speed, 2))
    middle = hinges + 0.5 * step * (differential.hinges_from_wheels(base, hinges) @ rates)
    moved = differential.body_from_wheels(base, middle) @ rates * step
    turned = hinges + step * (differential.hinges_from_wheels(base, middle) @ rates)
    return se2.compose(pose, se2.exp(moved)), turned, rates


class _Frames:
    """The newest pose a camera has delivered, or the true one without a camera."""

    def __init__(self, camera: Camera | None, pose: FloatArray) -> None:
        self._camera = camera
        self._taken = -1
        depth = 1 if camera is None else 1 + camera.delay
        self._queue = collections.deque([] if camera is None else [camera.quantise(pose)], depth)

    def look(self, time: float, pose: FloatArray) -> FloatArray:
        if self._camera is None:
            return pose
        frame = math.floor(time * self._camera.rate + 1e-9)
        if frame > self._taken:
            self._taken = frame
            self._queue.append(self._camera.quantise(pose))
        return self._queue[0]  # the oldest frame kept is ``delay`` frames old
