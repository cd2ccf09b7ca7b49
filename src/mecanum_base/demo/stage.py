"""The stage of a demo: all nodes on one scripted executor, driven through cmd_vel.

The scenario's driver is asked at 20 Hz and its twist is published on cmd_vel; from there on
nothing but topics connects the nodes. A record node writes the bag that the comparison reads.
"""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from geometry_msgs.msg import Twist, Vector3
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.logging import set_logger_level

from mecanum_base.demo.result import Phase
from mecanum_base.ros.drive_node import DriveNode
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
            bag: pathlib.Path, progress: Callable[[float], None]) -> None:
    """Run the scenario through the nodes and record it into the new folder ``bag``.

    ``parameters`` are those of the robot file; ``progress`` is called with the share done.
    """
    robot = {**parameters, 'sim': {**parameters.get('sim', {}), **dict(scenario.sim),
                                   'scenario': str(scenario_path), 'seed': scenario.seed}}
    driver = scenario.driver()
    with _quiet(), Script(start_ns=START_NS) as script:
        steer = script.publisher(Twist, 'cmd_vel')
        sim = script.add(SimNode, robot=robot, stepped=False, start_ns=START_NS)
        script.add(DriveNode, robot=robot)
        script.add(OdometryNode, robot=robot)
        script.add(RecordNode, parameters={'record.output': str(bag)})
        script.connect()
        script.before_step(lambda now, later: sim.step_to(later))
        count = round(scenario.duration / STEP)
        for index in range(count):
            if index % COMMAND_EVERY == 0:
                twist = driver.twist(index * STEP, sim.simulation.truth().pose.tolist())
                script.publish(steer, _command(twist))
            script.advance(STEP)
            progress((index + 1) / count)


@contextmanager
def _quiet() -> Iterator[None]:
    """Only warnings of the nodes are shown: the table is what a reader wants to see."""
    names = ('sim_node', 'drive_node', 'odometry_node', 'record_node')
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


