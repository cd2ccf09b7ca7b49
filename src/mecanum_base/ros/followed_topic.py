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
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from mecanum_base.ros.arrivals import Arrivals

LOOK_PERIOD = 0.2  # s


class FollowedTopic:
    """Follows ``topic``; ``types`` are the message classes by name that can be taken.

    ``profile(infos)`` gives the QoS from what the publishers offer; a subscription too strict for
    a publisher that appears later is made anew. ``default`` is subscribed while nobody publishes
    ('' = nothing is). ``callback`` gets the message (raw bytes with ``raw``); with ``arrivals``
    it is called through that group, with the time of arrival as well.
    """

    def __init__(self, node: Any, topic: str, types: Mapping[str, Any],
                 callback: Callable[..., None], profile: Callable[[list[Any]], QoSProfile], *,
                 default: str = '', raw: bool = False, arrivals: Arrivals | None = None) -> None:
        self._node, self._types, self._profile = node, types, profile
        self._callback, self._raw, self._arrivals = callback, raw, arrivals
        self.topic = topic
        self.type = ''
        self.conflict = ''
        self.unknown = ''
        self._subscription: Any = None
        self._qos: QoSProfile | None = None
        if not self.look() and default and not self.unknown:
            self._subscribe(default, profile([]))

    def look(self) -> bool:
        """Look at the graph; True if the subscription was made anew."""
        offers: dict[str, list[Any]] = {}
        for info in self._node.get_publishers_info_by_topic(self.topic):
            offers.setdefault(info.topic_type, []).append(info)
        known = [name for name in offers if name in self._types]
        self.unknown = next((name for name in offers if name not in self._types), '')
        self.conflict = next((name for name in known if name != self.type), '') if (
            self.type in known) else ''
        if not known:
            return False
        chosen = self.type if self.type in known else known[0]
        wanted = self._profile(offers[chosen])
        if chosen == self.type and not _too_strict(self._qos, wanted):
            return False
        self._subscribe(chosen, wanted)
        return True

    def take_waiting(self) -> None:
        """Hand on what has come but was not served yet (not for ``raw`` or ``arrivals``)."""
        handle, waiting = self._subscription.handle, []
        with handle:
            while (taken := handle.take_message(self._types[self.type], False)) is not None:
                waiting.append(taken[0])
        for message in waiting:
            self._callback(message)

    def _subscribe(self, name: str, qos: QoSProfile) -> None:
        owner = self._node if self._arrivals is None else self._arrivals
        if self._subscription is not None:
            owner.destroy_subscription(self._subscription)
        self.type, self._qos = name, qos
        self._subscription = owner.create_subscription(
            self._types[name], self.topic, self._callback, qos, raw=self._raw)


def _too_strict(have: QoSProfile | None, wanted: QoSProfile) -> bool:
    """Whether a subscription asks for more than some publisher offers."""
    if have is None:
        return True
    return (have.reliability == ReliabilityPolicy.RELIABLE != wanted.reliability
            or have.durability == DurabilityPolicy.TRANSIENT_LOCAL != wanted.durability)


def look_often(node: Any, look: Callable[[], Any]) -> Any:
    """A timer that looks at the graph on a clock that does not stop with simulated time."""
    return node.create_timer(LOOK_PERIOD, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
