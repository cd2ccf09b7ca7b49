"""What a viewer shows: the base, its path, and every wheel coloured by its slip.

Topic ``slip/markers`` (visualization_msgs/MarkerArray) for RViz and Foxglove; sent ten times a
second of data time and only while somebody looks. Green = rolls, yellow to red = slips, opaque as
the probability says. Pictures only: nothing else of the package reads these messages.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any

from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from mecanum_base import messages
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.records import Estimate
from mecanum_base.robot import Robot
from mecanum_base.ros.qos import RELIABLE

PERIOD_NS = 100_000_000
FULL_COLOUR = 0.3  # m/s of slip at which a wheel is red
PATH_STEP, PATH_POINTS = 0.03, 3000  # m between points of the path, how many are kept
_HEIGHT = 0.06  # m, of the box that stands for the body


class SlipMarkers:
    """Publishes markers for estimates of ``robot``."""

    def __init__(self, node: Any, robot: Robot) -> None:
        frames, prefix, base = robot.frames, robot.frames.tf_frame_prefix, robot.base
        self._odom, self._base = prefix + frames.odom_frame_id, prefix + frames.base_frame_id
        if isinstance(base, Wheels):
            self._places = [(float(x), float(y), float(a))
                            for x, y, a in zip(base.x, base.y, base.axle)]
            self._radii = [float(r) for r in base.radius]
        else:  # two wheels beside each hinge; they are drawn as if the carriers looked ahead
            self._places = [(float(x), float(y) + side * float(b), math.pi / 2.0)
                            for x, y, b in zip(base.x, base.y, base.half_track)
                            for side in (1.0, -1.0)]
            self._radii = [float(r) for r in base.wheel_radius for _ in range(2)]
        self._path: deque[tuple[float, float]] = deque(maxlen=PATH_POINTS)
        self._due_ns = -(1 << 62)
        self._publisher = node.create_publisher(MarkerArray, 'slip/markers', RELIABLE)

    def publish(self, estimate: Estimate) -> None:
        """Take in one estimate; send markers when they are due and somebody subscribes."""
        here = float(estimate.pose[0]), float(estimate.pose[1])
        if not self._path or math.dist(here, self._path[-1]) > PATH_STEP:
            self._path.append(here)
        if 0 <= self._due_ns - estimate.stamp_ns <= PERIOD_NS:
            return
        self._due_ns = estimate.stamp_ns + PERIOD_NS
        if self._publisher.get_subscription_count():
            self._publisher.publish(self.markers(estimate))

    def markers(self, estimate: Estimate) -> Any:
        """The MarkerArray of one estimate: a body, W wheels and the path so far."""
        reach = [max(abs(place[axis]) for place in self._places) for axis in (0, 1)]
        radius = max(self._radii)
        body = self._marker(estimate, 'body', 0, Marker.CUBE, self._base)
        body.pose.position.z = float(radius + _HEIGHT)
        body.scale.x, body.scale.y = float(2 * reach[0] + radius), float(2 * reach[1])
        body.scale.z, body.color = _HEIGHT, _colour(0.55, 0.6, 0.66, 0.5)
        path = self._marker(estimate, 'path', 0, Marker.LINE_STRIP, self._odom)
        path.scale.x, path.color = 0.02, _colour(0.38, 0.66, 0.96, 1.0)
        path.points = [Point(x=x, y=y, z=0.0) for x, y in self._path]
        wheels = [self._wheel(estimate, index) for index in range(len(self._places))]
        return MarkerArray(markers=[body, path, *wheels])

    def _wheel(self, estimate: Estimate, index: int) -> Any:
        x, y, axle = self._places[index]
        radius = self._radii[index]
        marker = self._marker(estimate, 'wheels', index, Marker.CYLINDER, self._base)
        marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = x, y, radius
        turn = marker.pose.orientation  # cylinder axis from z to the axle: about (-sin, cos, 0)
        half = math.sqrt(0.5)
        turn.x, turn.y, turn.w = -half * math.sin(axle), half * math.cos(axle), half
        marker.scale.x = marker.scale.y = 2.0 * radius
        marker.scale.z = 0.8 * radius
        share = min(abs(float(estimate.slip.rate[index])) * radius / FULL_COLOUR, 1.0)
        sure = 0.45 + 0.55 * min(max(float(estimate.slip.probability[index]), 0.0), 1.0)
        marker.color = _colour(min(2.0 * share, 1.0) if share > 0.1 else 0.2,
                               min(2.0 - 2.0 * share, 0.8), 0.15, sure)
        return marker

    def _marker(self, estimate: Estimate, name: str, number: int, kind: int, frame: str) -> Any:
        marker = Marker(ns=name, id=number, type=kind, action=Marker.ADD)
        messages.write_stamp(estimate.stamp_ns, marker.header.stamp)
        marker.header.frame_id = frame
        marker.pose.orientation.w = 1.0
        return marker


def _colour(red: float, green: float, blue: float, alpha: float) -> Any:
    return ColorRGBA(r=float(red), g=float(green), b=float(blue), a=float(alpha))
