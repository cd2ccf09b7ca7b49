"""Serve the nodes of a process by asking for messages, not by waiting for them.

rclpy's executor builds a wait set of every entity of every node for each message that it waits
for; with several nodes in a process that costs more than the nodes themselves. Here timers and
subscriptions are asked every 2 ms, every 5 ms after a pause, and all that is there is worked off.
Messages are late by 1 ms on average; services are answered within 15 ms. What remains (QoS events,
clients, coroutines) is left to the executor, five times a second.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from mecanum_base.ros.polling import poll, serve

PERIOD = 0.002  # s between two looks at timers and subscriptions
QUIET_PERIOD = 0.005  # s, the same after a pause
PAUSE = 0.05  # s without anything to do
SERVICE_PERIOD = 0.01  # s
REST_PERIOD = 0.2  # s


def spin(nodes: Sequence[Node], executor: SingleThreadedExecutor,
         goes_on: Callable[[], bool]) -> None:
    """Serve ``nodes``, which ``executor`` holds, as long as ``goes_on()``.

    An exception of a callback comes out. Nothing is served after ``goes_on()`` was False.
    """
    services_due = rest_due = busy_until = time.monotonic()
    while goes_on():
        worked = any([poll(node, executor.create_task) for node in nodes])
        now = time.monotonic()
        if now >= services_due:
            services_due = now + SERVICE_PERIOD
            worked |= any([serve(node) for node in nodes])
        if now >= rest_due:
            rest_due = now + REST_PERIOD
            executor.spin_once(timeout_sec=0.0)
        if worked:
            busy_until = now + PAUSE
        else:
            time.sleep(PERIOD if now < busy_until else QUIET_PERIOD)
