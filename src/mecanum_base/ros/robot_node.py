"""What all nodes share: the robot of their parameters and its live changes."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from mecanum_base.robot import Robot
from mecanum_base.ros.parameters import LiveParameters, declare


class RobotNode(Node):
    """A node that knows the whole robot file as parameters; :attr:`robot` is the current one.

    A subclass overrides :meth:`configure` to take over live changes. Raises ConfigError where the
    parameters break a rule. Keyword arguments are those of rclpy's Node (``context``,
    ``parameter_overrides``, ``namespace`` ...).
    """

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        self._live = LiveParameters(self, declare(self), self.configure, self.refuse)

    @property
    def robot(self) -> Robot:
        """The robot as the parameters describe it now."""
        return self._live.robot

    def configure(self, robot: Robot) -> None:
        """Take over an accepted change of live parameters; called between two callbacks."""

    def refuse(self, reason: str) -> None:
        """Note that a change was refused; the sender has the reason in the service's answer."""
        self.get_logger().warning(f'parameter change refused: {reason}')
