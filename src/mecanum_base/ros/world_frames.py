"""Brings poses and points of any known frame into the odometry frame.

odom and base_link are always known (from odom itself); other frames through tf and tf_static, with
the newest transform of each link, where they are connected to odom or base_link.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from mecanum_base.core import se2
from mecanum_base.core.frame_tree import FrameTree
from mecanum_base.core.parameter import FloatArray
from mecanum_base.messages import MalformedMessage
from mecanum_base.robot import FrameConfig
from mecanum_base.ros.qos import SENSOR_PUBLISHER
from mecanum_base.ros.transforms import Transform, Transforms

_LATCHED = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE,
                      durability=DurabilityPolicy.TRANSIENT_LOCAL)
_TILT = math.radians(10.0)  # a frame that leans more is not seen as planar


class WorldFrames:
    """Answers where a frame lies in odom; ``base`` is the pose (3,) of base_link in odom."""

    def __init__(self, node: Any, frames: FrameConfig) -> None:
        prefix = frames.tf_frame_prefix
        self._odom = {frames.odom_frame_id, prefix + frames.odom_frame_id}
        self._base = {frames.base_frame_id, prefix + frames.base_frame_id}
        self._names = prefix + frames.odom_frame_id, prefix + frames.base_frame_id
        self._tree = FrameTree()
        self.base: FloatArray | None = None
        transforms = Transforms()
        transforms.listen(node, 'tf', SENSOR_PUBLISHER, self._learn)
        transforms.listen(node, 'tf_static', _LATCHED, self._learn)

    def is_base(self, frame: str) -> bool:
        """Whether ``frame`` is the base itself."""
        return frame in self._base

    def origin(self, frame: str) -> FloatArray:
        """Pose (3,) of ``frame`` in odom; raises MalformedMessage naming an unknown frame."""
        if frame in self._odom:
            return np.zeros(3)
        if self.base is None:
            raise MalformedMessage(f'frame {frame!r} without odom')
        if frame in self._base:
            return self.base
        mount = self._tree.between(self._names[1], frame)
        if mount is not None:  # carried by the base, for instance a laser scanner
            return se2.compose(self.base, _planar(frame, *mount))
        mount = self._tree.between(self._names[0], frame)
        if mount is None:
            raise MalformedMessage(f'frame {frame!r} is not connected to {self._names[0]} on tf')
        return _planar(frame, *mount)

    def points(self, frame: str, points: FloatArray) -> FloatArray:
        """Points (N, 2) of ``frame`` in odom; raises as :meth:`origin`."""
        origin = self.origin(frame)
        return origin[:2] + points @ se2.rotation(float(origin[2])).T

    def _learn(self, transforms: list[Transform]) -> None:
        for item in transforms:
            self._tree.add(item.parent, item.child, item.xyz, item.quaternion)


def _planar(frame: str, xyz: FloatArray, rpy: FloatArray) -> FloatArray:
    if max(abs(float(rpy[0])), abs(float(rpy[1]))) > _TILT:
        raise MalformedMessage(f'frame {frame!r} is not level')
    return np.array([xyz[0], xyz[1], rpy[2]])
