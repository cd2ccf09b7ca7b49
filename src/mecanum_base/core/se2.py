"""Rigid motions of the plane: functions on (3,) arrays (x [m], y [m], yaw [rad]).

The exponential integrates a constant body twist exactly:

    exp(v) = (V(w) (vx, vy), w),   V(w) = [[sin w / w, -(1 - cos w)/w], [(1 - cos w)/w, sin w / w]]

with ``v`` the increment twist * dt. Near w = 0 the series is used, so that no precision is lost.
Yaw is never wrapped by :func:`compose` and :func:`exp`; use :func:`wrap_angle` for display.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.parameter import FloatArray

_SERIES = 1e-4  # below this angle the third-order series is exact to rounding


def wrap_angle(angle: float) -> float:
    """``angle`` [rad] moved into [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def _sinc_pair(angle: float) -> tuple[float, float]:
    """(sin a / a, (1 - cos a) / a) without loss of precision at a = 0."""
    if abs(angle) < _SERIES:
        square = angle * angle
        return 1.0 - square / 6.0, angle * (0.5 - square / 24.0)
    half = math.sin(0.5 * angle)
    return math.sin(angle) / angle, 2.0 * half * half / angle


def exp(increment: FloatArray) -> FloatArray:
    """Pose (3,) reached from the origin by the body increment (3,) = twist * dt."""
    dx, dy, dyaw = (float(v) for v in increment)
    s, c = _sinc_pair(dyaw)
    return np.array([s * dx - c * dy, c * dx + s * dy, dyaw])


def log(pose: FloatArray) -> FloatArray:
    """Body increment (3,) that leads from the origin to ``pose``; yaw is first wrapped."""
    yaw = wrap_angle(float(pose[2]))
    s, c = _sinc_pair(yaw)
    square = s * s + c * c
    x, y = float(pose[0]), float(pose[1])
    return np.array([(s * x + c * y) / square, (s * y - c * x) / square, yaw])


def compose(first: FloatArray, second: FloatArray) -> FloatArray:
    """Pose ``first`` followed by ``second``, which is given in the frame of ``first``."""
    c, s = math.cos(first[2]), math.sin(first[2])
    return np.array([
        first[0] + c * second[0] - s * second[1],
        first[1] + s * second[0] + c * second[1],
        first[2] + second[2],
    ])


def inverse(pose: FloatArray) -> FloatArray:
    """The pose that undoes ``pose``."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.array([-c * pose[0] - s * pose[1], s * pose[0] - c * pose[1], -pose[2]])


def rotation(yaw: float) -> FloatArray:
    """Matrix (2, 2) that turns body axes into the axes the yaw [rad] is measured in."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s], [s, c]])
