"""Quality of service of every topic, in one place (interface contract, section 3).

Publishers are reliable and volatile, so that any subscriber fits them. A command must arrive even
if it is sent only once, so commands are subscribed reliably; sensors are subscribed best effort,
so that both reliable and best-effort drivers fit, with a queue deep enough for a burst.
"""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

RELIABILITIES = ('reliable', 'best_effort')

RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE,
                      durability=DurabilityPolicy.VOLATILE)
"""Every publisher that is no sensor; subscriptions to commands, poses and goals."""

SENSOR_PUBLISHER = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE,
                              durability=DurabilityPolicy.VOLATILE)
"""Publishers of encoder, IMU and ground truth messages."""

SENSOR = QoSProfile(depth=200, reliability=ReliabilityPolicy.BEST_EFFORT,
                    durability=DurabilityPolicy.VOLATILE)
"""Subscriptions to sensors: fits reliable and best-effort publishers."""

BEST_EFFORT_COMMAND = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT,
                                 durability=DurabilityPolicy.VOLATILE)
"""Subscription to commands of a best-effort publisher (micro-ROS)."""


def command_profile(reliability: str) -> QoSProfile:
    """The profile of a command subscription, by its name in the robot file."""
    return {'reliable': RELIABLE, 'best_effort': BEST_EFFORT_COMMAND}[reliability]
