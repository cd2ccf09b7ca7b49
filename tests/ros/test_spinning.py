"""Nodes of a process are served without a wait set: messages, timers, services, coroutines."""

import time

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Empty, Int32
from std_srvs.srv import Trigger

from mecanum_base.ros.spinning import spin


@pytest.fixture
def process(monkeypatch):
    """(node, executor that holds it) in a context that nobody outside sees."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'OFF')
    context = Context()
    rclpy.init(args=[], context=context)
    node = Node('served', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    yield node, executor
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown(context=context)


def until(condition, limit=20.0):
    end = time.monotonic() + limit
    return lambda: not condition() and time.monotonic() < end


def test_every_message_is_served_in_order(process):
    node, executor = process
    heard = []
    node.create_subscription(Int32, 'number', lambda m: heard.append(m.data), 100)
    publisher = node.create_publisher(Int32, 'number', 100)
    for number in range(50):
        publisher.publish(Int32(data=number))
    spin([node], executor, until(lambda: len(heard) == 50))
    assert heard == list(range(50))


def test_timers_services_and_coroutines_are_served_too(process):
    node, executor = process
    ticks, awaited = [], []
    node.create_timer(0.01, lambda: ticks.append(1))

    def answer(_request, response):
        response.success = True
        return response

    async def later(message):
        awaited.append(message)

    node.create_service(Trigger, 'ask', answer)
    node.create_subscription(Empty, 'event', later, 10)
    node.create_publisher(Empty, 'event', 10).publish(Empty())
    future = node.create_client(Trigger, 'ask').call_async(Trigger.Request())
    spin([node], executor, until(lambda: future.done() and len(ticks) > 4 and awaited))
    assert future.result().success and awaited and len(ticks) > 4


def test_an_exception_of_a_callback_comes_out(process):
    node, executor = process

    def fail():
        raise RuntimeError('of the callback')

    node.create_timer(0.01, fail)
    with pytest.raises(RuntimeError, match='of the callback'):
        spin([node], executor, until(lambda: False))


def test_a_subscription_that_another_callback_destroys_is_left_out(process):
    node, executor = process
    heard = []
    first = node.create_subscription(
        Int32, 'number', lambda m: node.destroy_subscription(second), 10)
    second = node.create_subscription(Int32, 'number', heard.append, 10)
    node.create_publisher(Int32, 'number', 10).publish(Int32())
    spin([node], executor, until(lambda: second not in node.subscriptions))
    assert first in node.subscriptions and heard == []


def test_nothing_is_served_once_it_is_told_to_end(process):
    node, executor = process
    ticks = []
    node.create_timer(0.0001, lambda: ticks.append(1))
    time.sleep(0.01)
    spin([node], executor, lambda: False)
    assert ticks == []
