"""Subscribes cmd_vel in the type that its publishers send, and says what cannot be heard.

Twist while nobody publishes. When the publishers change over to the other type, the wheels are
stopped and the topic is subscribed anew; with both types at once the present one stays.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy

from mecanum_base.core.command.drive import DriveConfig
from mecanum_base.ros.followed_topic import FollowedTopic
from mecanum_base.ros.qos import command_profile

TOPIC = 'cmd_vel'
_TWIST, _STAMPED = 'geometry_msgs/msg/Twist', 'geometry_msgs/msg/TwistStamped'
_ALLOWED: dict[str, dict[str, type[Any]]] = {
    'auto': {_TWIST: Twist, _STAMPED: TwistStamped},
    'twist': {_TWIST: Twist},
    'twist_stamped': {_STAMPED: TwistStamped},
}


class CommandTopic:
    """The subscription of cmd_vel; :meth:`look` keeps its type right.

    ``receive`` is called with every message, ``changed`` with the reason when the type changed.
    """

    def __init__(self, node: Node, drive: DriveConfig, receive: Callable[[Any], None],
                 changed: Callable[[str], object]) -> None:
        self._node, self._changed = node, changed
        self._profile = command_profile(drive.cmd_vel_reliability)
        types = _ALLOWED[drive.cmd_vel_type]
        self._topic = FollowedTopic(node, node.resolve_topic_name(TOPIC), types, receive,
                                    lambda infos: self._profile, default=next(iter(types)))
        self._topic.look()
        self.problem = ''  # for diagnostics; '' = none

    @property
    def name(self) -> str:
        """Name of the topic after remapping."""
        return self._topic.topic

    @property
    def type(self) -> str:
        """The message type that is subscribed."""
        return self._topic.type

    def take_waiting(self) -> None:
        """Receive what has arrived by now, before anybody judges that commands have ceased."""
        if self._topic.type:
            self._topic.take_waiting()

    def look(self) -> None:
        """Look at the graph; called at least every 0.2 s."""
        before = self._topic.type
        if self._topic.look():
            self._changed(f'{self.name} is now published as {self._topic.type}, not {before}')
        problem = self._find_problem()
        if problem and problem != self.problem:
            self._node.get_logger().error(problem)
        self.problem = problem

    def _find_problem(self) -> str:
        ignored = self._topic.conflict or self._topic.unknown
        if ignored:
            return (f'{ignored} on {self.name} is ignored: it is subscribed as '
                    f'{self._topic.type}')
        if self._profile.reliability == ReliabilityPolicy.RELIABLE and any(
                info.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
                for info in self._node.get_publishers_info_by_topic(self.name)):
            return (f'a publisher of {self.name} is best effort and is not heard: set '
                    'drive.cmd_vel_reliability to best_effort')
        return ''
