"""Subscriptions that are served in the order of arrival, across topics.

rclpy's executor takes one message of each topic in turn. Behind a backlog a topic with many
messages would fall ever farther behind one with few, and samples that belong together would come
seconds apart: late for the estimator, disordered in a bag. :class:`Arrivals` takes everything that
waits on all its topics at once and handles it in the order in which it arrived.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.subscription import Subscription

Handle = Callable[[Any, int], None]
MOST = 2000  # messages taken before any is handled
LONGEST = 0.02  # s of taking; a computer that cannot keep up must not only collect


class Arrivals:
    """A group of subscriptions of one node; handlers get (message, time of arrival in ns).

    The time is the node's clock: that at which the message came in, or the present of a simulated
    clock, which has no history.
    """

    def __init__(self, node: Any) -> None:
        self._node = node
        self._taps: list[tuple[Subscription, Handle]] = []

    def create_subscription(self, message: Any, topic: str, handle: Handle, qos: Any, *,
                            raw: bool = False) -> Subscription:
        """Subscribe, as a node does; end it with :meth:`destroy_subscription` of this group."""
        def wake(msg: Any, info: Any) -> None:
            self._serve(msg, int(info['received_timestamp']), handle)
        subscription = self._node.create_subscription(message, topic, wake, qos, raw=raw)
        self._taps.append((subscription, handle))
        return subscription

    def destroy_subscription(self, subscription: Subscription) -> None:
        """Unsubscribe."""
        self._taps = [tap for tap in self._taps if tap[0] is not subscription]
        self._node.destroy_subscription(subscription)

    def _serve(self, first: Any, received: int, handle: Handle) -> None:
        """Handle the message that woke us and all that wait, in the order of arrival.

        The topics are asked until a whole round finds nothing: what came on the first of them
        while the last was asked must not be overtaken. That ends after LONGEST: what is left then
        is overtaken by a few milliseconds at most.
        """
        waiting, end = [(received, 0, handle, first)], time.monotonic() + LONGEST
        while self._take_all(waiting) and time.monotonic() < end:
            pass
        waiting.sort(key=lambda item: item[:2])
        for came, _, call, message in waiting:
            call(message, self._arrival(came))

    def _take_all(self, waiting: list[tuple[int, int, Handle, Any]]) -> bool:
        """Ask every topic once for all it has; True if there was anything."""
        before = len(waiting)
        for subscription, handle in self._taps:
            with subscription.handle:
                while len(waiting) < MOST and (taken := subscription.handle.take_message(
                        subscription.msg_type, subscription.raw)) is not None:
                    waiting.append((int(taken[1]['received_timestamp']), len(waiting), handle,
                                    taken[0]))
        return len(waiting) > before

    def _arrival(self, received: int) -> int:
        clock = self._node.get_clock()
        if clock.ros_time_is_active or received <= 0:
            return int(clock.now().nanoseconds)
        return received
