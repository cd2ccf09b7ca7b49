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


def test_a_stream_that_never_pauses_is_handled_all_the_same(monkeypatch):
    """A computer that cannot keep up must not collect messages for ever."""
    from contextlib import nullcontext
    from types import SimpleNamespace

    from mecanum_base.ros import arrivals
    monkeypatch.setattr(arrivals, 'MOST', 10**9)
    made = iter(range(10**9))

    class Endless(nullcontext):
        def __init__(self):
            super().__init__()
            self.left = 0

        def take_message(self, *_):
            self.left = (self.left + 1) % 4  # three messages every time it is asked
            number = next(made)
            return (number, {'received_timestamp': number + 1}) if self.left else None

    node = SimpleNamespace(get_clock=lambda: SimpleNamespace(ros_time_is_active=False))
    group, handled = arrivals.Arrivals(node), []
    group._taps = [(SimpleNamespace(handle=Endless(), msg_type=None, raw=False),
                    lambda message, _: handled.append(message))]
    group._serve(-1, 1, lambda message, _: handled.append(message))
    assert len(handled) > 10 and handled == sorted(handled)
