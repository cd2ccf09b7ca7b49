"""A subscription that takes the type its publishers have.

One participant can use one type per topic name, so the type is looked up in the graph five times a
second. If it changes, the old subscription is destroyed and a new one made; if two types are
published at once, the first stays and :attr:`FollowedTopic.conflict` names the other.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType

LOOK_PERIOD = 0.2  # s


class FollowedTopic:
    """Follows ``topic``; ``types`` are the message classes by name that can be taken.

    ``profile(infos)`` gives the QoS from what the publishers offer. ``default`` is subscribed
    while nobody publishes ('' = nothing is). ``callback(message)``; raw bytes with ``raw``.
    """

    def __init__(self, node: Any, topic: str, types: Mapping[str, Any],
                 callback: Callable[..., None], profile: Callable[[list[Any]], Any], *,
                 default: str = '', raw: bool = False) -> None:
        self._node, self._types, self._profile = node, types, profile
        self._callback, self._raw = callback, raw
        self.topic = topic
        self.type = ''
        self.conflict = ''
        self.unknown = ''
        self.offered: tuple[Any, ...] = ()
        self._subscription: Any = None
        if not self.look() and default:
            self._subscribe(default, [])

    def look(self) -> bool:
        """Look at the graph; True if the type of the subscription changed."""
        offers: dict[str, list[Any]] = {}
        for info in self._node.get_publishers_info_by_topic(self.topic):
            offers.setdefault(info.topic_type, []).append(info)
        known = [name for name in offers if name in self._types]
        self.unknown = next((name for name in offers if name not in self._types), '')
        self.conflict = next((name for name in known if name != self.type), '') if (
            self.type in known) else ''
        if not known or self.type in known:
            return False
        self._subscribe(known[0], offers[known[0]])
        return True

    def _subscribe(self, name: str, infos: list[Any]) -> None:
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
        self.type, self.offered = name, tuple(info.qos_profile for info in infos)
        self._subscription = self._node.create_subscription(
            self._types[name], self.topic, self._callback, self._profile(infos), raw=self._raw)


def look_often(node: Any, look: Callable[[], Any]) -> Any:
    """A timer that looks at the graph on a clock that does not stop with simulated time."""
    return node.create_timer(LOOK_PERIOD, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
