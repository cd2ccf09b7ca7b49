"""Call what is ready on a node without a wait set: the fast lane of scripts and processes.

Timers, subscriptions and services are simply asked in a fixed order. This is several times faster
than rclpy's executor, which builds a wait set of all entities for each call. Within one process a
message is in the subscription's queue before publish() returns, so a script has to wait for
nothing. Clients, guard conditions and waitables (actions, QoS events) are left to that executor.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Coroutine
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer

InvalidHandle = rclpy_implementation.InvalidHandle
Later = Callable[[Coroutine[Any, Any, Any]], object]


def poll(node: Node, later: Later) -> bool:
    """Call every ready timer once and take one message of every subscription, in this order.

    Both in order of creation. Coroutines of asynchronous callbacks go to ``later``. True if
    anything was called; exceptions of callbacks come out.
    """
    worked = False
    for timer in list(node.timers):
        worked |= _call_timer(timer, later)
    for subscription in list(node.subscriptions):
        worked |= _take_message(subscription, later)
    return worked


def serve(node: Node) -> bool:
    """Answer one request of every service; True if there was any."""
    return any([_answer(service) for service in list(node.services)])


def needs_executor(node: Node) -> bool:
    """Whether the node has anything that only rclpy's executor can serve."""
    return bool(next(iter(node.clients), None) or next(iter(node.guards), None))


def _call_timer(timer: Timer, later: Later) -> bool:
    if not timer.is_ready():
        return False
    with timer.handle:
        timer.handle.call_timer()
    _run(timer.callback(), later)
    return True


def _take_message(subscription: Subscription, later: Later) -> bool:
    try:
        with subscription.handle:
            taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
    except InvalidHandle:  # destroyed by the callback before
        return False
    if taken is None:
        return False
    wants_information = subscription._callback_type is not Subscription.CallbackType.MessageOnly
    _run(subscription.callback(*taken) if wants_information else subscription.callback(taken[0]),
         later)
    return True


def _answer(service: Service) -> bool:
    kind: Any = service.srv_type
    with service.handle:
        request, header = service.handle.service_take_request(kind.Request)
    if header is None:
        return False
    service.send_response(service.callback(request, kind.Response()), header)
    return True


def _run(result: Any, later: Later) -> None:
    if inspect.iscoroutine(result):
        later(result)
