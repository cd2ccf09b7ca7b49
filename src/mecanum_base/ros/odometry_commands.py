"""The wheel commands that the odometry node listens to, as a witness that may be missing.

A wheel that does not follow its command is named in the diagnostics; the odometry is the same
with commands and without. Silence, or a message type that nobody knows, is no fault here.
"""

from __future__ import annotations

from typing import Any

from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from mecanum_base.intake import Intake
from mecanum_base.ros.arrivals import Arrivals
from mecanum_base.ros.followed_topic import FollowedTopic, look_often
from mecanum_base.ros.qos import RELIABLE

TOPIC = 'wheel_commands'
NAMED, ORDERED = 'sensor_msgs/msg/JointState', 'std_msgs/msg/Float64MultiArray'


class OdometryCommands:
    """Hands wheel_commands of either type to the intake, in their order among the sensors."""

    def __init__(self, node: Any, intake: Intake, arrivals: Arrivals) -> None:
        self._intake = intake
        sent = ORDERED if intake.robot.drive.command_type == 'float64_multi_array' else NAMED
        self.topic = FollowedTopic(node, TOPIC, {NAMED: JointState, ORDERED: Float64MultiArray},
                                   self._take, lambda _: RELIABLE, default=sent,
                                   arrivals=arrivals)
        look_often(node, self.topic.look)

    def _take(self, msg: Any, arrival: int) -> None:
        if isinstance(msg, JointState):
            self._intake.wheel_commands(msg, arrival)
        else:
            self._intake.wheel_rates(msg, arrival)
