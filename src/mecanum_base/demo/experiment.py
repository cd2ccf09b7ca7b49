"""The circle-and-spin experiment of source D through topics, beside the paper's 0.04 m.

The reference (D24) is published as a moving goal_pose; goal_node follows it with what odometry
says, drive_node and sim_node do the rest. The error is that of the true pose to the reference. The
same law without floor, motors and odometry, with the true pose or the paper's camera, stands
beside it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.command.circle_spin import PAPER_ERROR, Camera
from mecanum_base.core.command.circle_spin import run as run_exactly
from mecanum_base.core.command.potential_field import GoalField
from mecanum_base.core.command.trajectory import CircleSpin
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.demo.result import DemoResult
from mecanum_base.robot import Base, Robot

NAME = 'circle_spin'
SETTLED = 5.0  # s left out of the error figures: the start from rest


@dataclass(frozen=True)
class Experiment:
    """The path and the clock time (ns) of its start."""

    path: CircleSpin
    start_ns: int

    def reference(self, stamp_ns: IntArray) -> FloatArray:
        """Reference poses (N, 3) in odom, whose origin is where the path starts."""
        origin = self.path.pose(0.0)
        return np.array([self.path.pose((stamp - self.start_ns) * 1e-9) - origin
                         for stamp in stamp_ns.tolist()])

    def lines(self, result: DemoResult, robot: Robot) -> list[str]:
        """The figures as text: through the nodes, and by the bare law."""
        truth = result.truth
        late = truth.stamp_ns >= self.start_ns + round(SETTLED * 1e9)
        stamps = truth.stamp_ns[late]
        gap = truth.pose[late] - self.reference(stamps)
        distance = np.hypot(gap[:, 0], gap[:, 1])
        duration = float(stamps[-1] - self.start_ns) * 1e-9
        path = self.path
        return [
            f'  circle and spin: R {path.radius:g} m, {path.angular_rate:.4g} rad/s, '
            f'spin {path.spin:.4g} rad/s; distance of the base to its reference [mm]',
            _row('through the nodes, our odometry', distance),
            *(_row(name, self._bare(robot.base, robot, lead, camera, duration))
              for name, lead, camera in (
                  ('bare law, true pose', True, None),
                  ('bare law, camera of 30 frames/s', True, Camera()),
                  ('bare law, camera, no feed-forward', False, Camera()))),
            f'    {"the paper":<36} about {1000 * PAPER_ERROR:.0f}']

    def _bare(self, base: Base, robot: Robot, lead: bool, camera: Camera | None,
              duration: float) -> FloatArray:
        run = run_exactly(base, GoalField(robot.goal), self.path, duration=duration,
                          feed_forward=lead, camera=camera, settled=SETTLED)
        return run.distance()[run.time >= SETTLED]


def _row(name: str, distance: FloatArray) -> str:
    return (f'    {name:<36} mean {1000 * float(np.mean(distance)):6.1f}   '
            f'max {1000 * float(np.max(distance)):6.1f}')
