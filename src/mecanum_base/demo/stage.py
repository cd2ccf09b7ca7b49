"""The stage of a demo: all nodes on one scripted executor, driven through cmd_vel.

The scenario's driver is asked at 20 Hz and its twist is published on cmd_vel; from there on
nothing but topics connects the nodes. A record node writes the bag that the comparison reads.
"""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, Twist, Vector3
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.logging import set_logger_level

from mecanum_base.demo.experiment import Experiment
from mecanum_base.demo.result import Phase
from mecanum_base.messages import quaternion_of_yaw
from mecanum_base.ros.drive_node import DriveNode
from mecanum_base.ros.goal_node import GoalNode
from mecanum_base.ros.odometry_node import OdometryNode
from mecanum_base.ros.record_node import RecordNode
from mecanum_base.ros.scripted import Script
from mecanum_base.ros.sim_node import SimNode
from mecanum_base.sim.scenario import Scenario

STEP = 0.01  # s of simulated time between two looks at the queues; below estimator.reorder_wait
COMMAND_EVERY = 5  # steps between two cmd_vel messages: 20 Hz
_NANOSECONDS = 1_000_000_000
START_NS = _NANOSECONDS


def perform(scenario: Scenario, scenario_path: pathlib.Path, parameters: Mapping[str, Any],
            bag: pathlib.Path, progress: Callable[[float], None],
            experiment: Experiment | None = None) -> None:
    """Run the scenario through the nodes and record it into the new folder ``bag``.

    ``parameters`` are those of the robot file; ``progress`` is called with the share done. With an
    ``experiment`` its reference is published as goal_pose and goal_node drives, not the scenario.
    """
    robot = {**parameters, 'sim': {**parameters.get('sim', {}), **dict(scenario.sim),
                                   'scenario': str(scenario_path), 'seed': scenario.seed}}
    driver = scenario.driver()
    with _quiet(), Script(start_ns=START_NS) as script:
        if experiment is None:
            steer = script.publisher(Twist, 'cmd_vel')
        else:
            steer = script.publisher(PoseStamped, 'goal_pose')
            script.add(GoalNode, robot=robot, parameters={'goal.feed_forward': True})
        sim = script.add(SimNode, robot=robot, stepped=False, start_ns=START_NS)
        script.add(DriveNode, robot=robot)
        script.add(OdometryNode, robot=robot)
        script.add(RecordNode, parameters={'record.output': str(bag)})
        script.connect()
        script.before_step(lambda now, later: sim.step_to(later))
        count = round(scenario.duration / STEP)
        for index in range(count):
            if index % COMMAND_EVERY == 0:
                script.publish(steer, _command(
                    driver.twist(index * STEP, sim.simulation.truth().pose.tolist()))
                    if experiment is None else _goal(experiment, script.now_ns))
            script.advance(STEP)
            progress((index + 1) / count)


@contextmanager
def _quiet() -> Iterator[None]:
    """Only warnings of the nodes are shown: the table is what a reader wants to see."""
    names = ('sim_node', 'drive_node', 'odometry_node', 'record_node', 'goal_node')
    for name in names:
        set_logger_level(name, LoggingSeverity.WARN)
    try:
        yield
    finally:
        for name in names:  # levels belong to the process, not to the nodes
            set_logger_level(name, LoggingSeverity.UNSET)


def _command(twist: Sequence[float]) -> Twist:
    vx, vy, wz = (float(v) for v in twist)
    return Twist(linear=Vector3(x=vx, y=vy), angular=Vector3(z=wz))


def _goal(experiment: Experiment, now_ns: int) -> PoseStamped:
    x, y, yaw = (float(v) for v in experiment.reference(np.array([now_ns]))[0])
    goal = PoseStamped()
    goal.header.stamp.sec, goal.header.stamp.nanosec = divmod(now_ns, _NANOSECONDS)
    goal.header.frame_id = 'odom'
    goal.pose.position.x, goal.pose.position.y = x, y
    turned = quaternion_of_yaw(yaw)
    goal.pose.orientation.z, goal.pose.orientation.w = turned[2], turned[3]
    return goal


def phases(scenario: Scenario) -> tuple[Phase, ...]:
    """Named parts of a scripted drive, in nanoseconds of the stage's clock."""
    found: list[tuple[str, int]] = []
    now = START_NS
    for segment in scenario.driving.script:
        if segment.name:
            found.append((segment.name, now))
        now += round(segment.seconds * _NANOSECONDS)
    ends = [start for _, start in found[1:]] + [
        min(now, START_NS + round(scenario.duration * _NANOSECONDS))]
    return tuple(Phase(name, start, end) for (name, start), end in zip(found, ends))


