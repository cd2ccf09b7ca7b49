"""Static transforms between frames: where a sensor is mounted, found through any chain.

    base_from_sensor = inverse(root_from_base) root_from_sensor

Symbols: each link is a rigid motion parent_from_child as a matrix (4, 4) [m]; the root is the
frame without a parent. Source: REP-105 (frames form a tree). Not modelled: moving links.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mecanum_base.core.parameter import FloatArray

_UNIT = 1e-3  # how far from 1 the norm of a quaternion may be
_GIMBAL = 1e-9  # cosine of the pitch below which roll and yaw are one angle


class FrameTree:
    """Collects links and answers what lies between two frames."""

    def __init__(self) -> None:
        self._links: dict[str, tuple[str, FloatArray]] = {}

    def add(self, parent: str, child: str, xyz: Sequence[float],
            quaternion: Sequence[float]) -> bool:
        """Learn a link; False (and nothing is learnt) for numbers that are no rigid motion.

        ``xyz`` [m] and ``quaternion`` (x, y, z, w) give the child in the parent's axes.
        """
        numbers = np.array([*xyz, *quaternion], dtype=np.float64)
        norm = float(np.linalg.norm(numbers[3:]))
        if not np.all(np.isfinite(numbers)) or abs(norm - 1.0) > _UNIT or parent == child:
            return False
        link = np.eye(4)
        link[:3, :3], link[:3, 3] = _rotation(numbers[3:] / norm), numbers[:3]
        self._links[_plain(child)] = _plain(parent), link
        return True

    def between(self, base: str, sensor: str) -> tuple[FloatArray, FloatArray] | None:
        """Mount (xyz [m] (3,), rpy [rad] (3,)) of ``sensor`` in ``base``; None while unknown."""
        base_root, root_from_base = self._to_root(_plain(base))
        sensor_root, root_from_sensor = self._to_root(_plain(sensor))
        if base_root != sensor_root:
            return None
        mount = np.linalg.inv(root_from_base) @ root_from_sensor
        return mount[:3, 3].copy(), _rpy(mount[:3, :3])

    def _to_root(self, frame: str) -> tuple[str, FloatArray]:
        path: FloatArray = np.eye(4)
        seen = {frame}
        while frame in self._links:
            frame, link = self._links[frame]
            path = link @ path
            if frame in seen:  # a loop is no tree: such frames stay unknown
                return f'loop at {frame}', path
            seen.add(frame)
        return frame, path


def _plain(frame: str) -> str:
    return frame.lstrip('/')


def _rotation(quaternion: FloatArray) -> FloatArray:
    x, y, z, w = (float(v) for v in quaternion)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def _rpy(rotation: FloatArray) -> FloatArray:
    """Roll, pitch, yaw [rad] about fixed axes X Y Z, so that R = Rz(yaw) Ry(pitch) Rx(roll)."""
    flat = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], flat)
    if flat < _GIMBAL:
        return np.array([math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0])
    return np.array([math.atan2(rotation[2, 1], rotation[2, 2]), pitch,
                     math.atan2(rotation[1, 0], rotation[0, 0])])
