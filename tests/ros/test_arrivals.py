"""Behind a backlog messages are still handled in the order in which they came."""

import pytest

pytest.importorskip('rclpy')

from std_msgs.msg import Header, String

from mecanum_base.ros.arrivals import Arrivals
from mecanum_base.ros.qos import SENSOR, SENSOR_PUBLISHER
from mecanum_base.ros.scripted import Script


@pytest.fixture
def script():
    with Script() as made:
        yield made


def backlog(script, subscribe):
    """Handled numbers after 30 messages on two topics (1 : 2) that came before any was handled."""
    handled = []
    subscribe(Header, 'few', lambda msg, *_: handled.append(int(msg.frame_id)), SENSOR)
    subscribe(String, 'many', lambda msg, *_: handled.append(int(msg.data)), SENSOR)
    few = script.publisher(Header, 'few', SENSOR_PUBLISHER)
    many = script.publisher(String, 'many', SENSOR_PUBLISHER)
    script.connect()
    for number in range(30):
        if number % 3:
            many.publish(String(data=str(number)))
        else:
            few.publish(Header(frame_id=str(number)))
    script.settle()
    return handled


def test_plain_subscriptions_mix_up_a_backlog(script):
    """Why the group is needed: the executor takes one message of each topic in turn."""
    assert backlog(script, script._bench.create_subscription) != list(range(30))


def test_a_group_handles_a_backlog_in_the_order_of_arrival(script):
    assert backlog(script, Arrivals(script._bench).create_subscription) == list(range(30))


def test_the_time_of_arrival_is_the_simulated_clock_where_there_is_one(script):
    times = []
    Arrivals(script._bench).create_subscription(
        Header, 'few', lambda _, arrival: times.append(arrival), SENSOR)
    publisher = script.publisher(Header, 'few', SENSOR_PUBLISHER)
    script.connect()
    script.publish(publisher, Header())
    script.advance(0.5)
    script.publish(publisher, Header())
    assert times == [script.now_ns - 500_000_000, script.now_ns]


def test_the_time_of_arrival_is_that_of_the_middleware_on_a_real_clock(script):
    from rclpy.node import Node
    node = script.add(Node, name='real', stepped=False)
    times = []
    Arrivals(node).create_subscription(
        Header, 'few', lambda _, arrival: times.append(arrival), SENSOR)
    publisher = script.publisher(Header, 'few', SENSOR_PUBLISHER)
    script.connect()
    before = node.get_clock().now().nanoseconds
    publisher.publish(Header())
    after = node.get_clock().now().nanoseconds
    script.wait_for(lambda: times, 'the message')
    assert before <= times[0] <= after  # not when it was handled


def test_a_destroyed_subscription_is_asked_no_more(script):
    group = Arrivals(script._bench)
    first = group.create_subscription(Header, 'few', lambda *_: None, SENSOR)
    heard = []
    group.create_subscription(String, 'many', lambda msg, _: heard.append(msg.data), SENSOR)
    group.destroy_subscription(first)
    publisher = script.publisher(String, 'many', SENSOR_PUBLISHER)
    script.connect()
    script.publish(publisher, String(data='x'))
    assert heard == ['x']
