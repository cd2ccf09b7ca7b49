"""The scripted executor: deterministic, isolated, in simulated time, honest about errors."""

import pytest
from rclpy.node import Node
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from mecanum_base.ros.robot_node import RobotNode
from mecanum_base.ros.scripted import Script, parameter

SECOND = 1_000_000_000


class Clockwork(Node):
    """Publishes the time on a timer, echoes texts, serves, fails on demand."""

    def __init__(self, period=0.02, **options):
        super().__init__('clockwork', **options)
        self.ticks = self.create_publisher(Float64, 'ticks', 10)
        self.echo = self.create_publisher(String, 'echo', 10)
        self.create_subscription(String, 'say', self.repeat, 10)
        self.create_service(Trigger, '~/poke', self.poke)
        self.create_timer(period, self.tick)
        self.stopped_at = None

    def tick(self):
        self.ticks.publish(Float64(data=self.get_clock().now().nanoseconds * 1e-9))

    def repeat(self, message):
        if message.data == 'fail':
            raise ValueError('asked to fail')
        self.echo.publish(message)

    def poke(self, request, response):
        response.success, response.message = True, 'poked'
        return response


@pytest.fixture
def script():
    with Script() as made:
        yield made


def test_timers_run_on_the_time_of_the_script_only(script):
    script.add(Clockwork)
    ticks = script.listen(Float64, 'ticks')
    script.settle()
    ticks.clear()
    script.run(1.0, 0.005)
    assert [m.data for m in ticks] == pytest.approx([1.0 + 0.02 * i for i in range(1, 51)])
    assert script.now_ns == 2 * SECOND


def test_a_message_and_what_follows_from_it_arrive_before_publish_returns(script):
    script.add(Clockwork)
    echo, say = script.listen(String, 'echo'), script.publisher(String, 'say')
    script.connect()
    for text in ('a', 'b', 'c'):
        script.publish(say, String(data=text))
        assert echo[-1].data == text
    assert len(echo) == 3


def story():
    """Everything that is heard, in order, while two nodes and a script talk."""
    heard = []
    with Script() as script:
        script.add(Clockwork)
        script.add(Clockwork, 0.03, namespace='second')
        for topic in ('ticks', 'second/ticks'):
            script.listen(Float64, topic, call=lambda m, t=topic: heard.append((t, m.data)))
        script.listen(String, 'echo', call=lambda m: heard.append(('echo', m.data)))
        say = script.publisher(String, 'say')
        script.connect()
        for i in range(100):
            script.advance(0.01)
            script.publish(say, String(data=str(i)))
    return heard


def test_the_same_script_gives_the_same_messages_in_the_same_order():
    first = story()
    assert len(first) > 180
    assert story() == first


def test_scripts_do_not_hear_each_other(script):
    heard = script.listen(String, 'say')
    with Script() as other:
        say = other.publisher(String, 'say')
        own = other.listen(String, 'say')
        other.connect()
        other.publish(say, String(data='secret'))
        script.settle()
        assert len(own) == 1 and heard == []


def test_an_exception_in_a_callback_comes_out_of_the_script(script):
    script.add(Clockwork)
    say = script.publisher(String, 'say')
    script.connect()
    with pytest.raises(ValueError, match='asked to fail'):
        script.publish(say, String(data='fail'))


def test_services_are_called_while_time_stands_still(script):
    script.add(Clockwork)
    answer = script.call(Trigger, 'clockwork/poke', Trigger.Request())
    assert answer.success and script.now_ns == SECOND


def test_waiting_in_vain_names_what_was_waited_for(script):
    with pytest.raises(TimeoutError, match='not within 0.05 s: the moon'):
        script.wait_for(lambda: False, 'the moon', 0.05)
    script.publisher(String, 'nobody')
    with pytest.raises(TimeoutError, match='a subscriber of /nobody'):
        script.connect(0.05)


def test_hooks_see_each_step_before_the_clock_moves(script):
    steps = []
    node = script.add(Clockwork)
    script.before_step(lambda now, following: steps.append(
        (now, following, node.get_clock().now().nanoseconds)))
    script.run(0.04, 0.02)
    assert steps == [(SECOND, SECOND + 20_000_000, SECOND),
                     (SECOND + 20_000_000, SECOND + 40_000_000, SECOND + 20_000_000)]


def test_a_removed_node_is_silent_and_others_go_on(script):
    node = script.add(Clockwork)
    script.add(Clockwork, namespace='second')
    gone, left = script.listen(Float64, 'ticks'), script.listen(Float64, 'second/ticks')
    script.run(0.1, 0.02)
    script.remove(node)
    count = len(gone)
    script.run(0.1, 0.02)
    assert len(gone) == count and len(left) >= 10


def test_a_node_may_keep_its_own_clock(script):
    node = script.add(Clockwork, stepped=False)
    assert node.get_clock().now().nanoseconds > 10**18  # now, not one second
    assert script.add(Node, name='other').get_clock().now().nanoseconds == SECOND


class Asynchronous(Node):
    """Asks another node's service from an asynchronous callback."""

    def __init__(self, **options):
        super().__init__('asynchronous', **options)
        self.client = self.create_client(Trigger, 'clockwork/poke')
        self.answers = []
        self.create_subscription(String, 'ask', self.ask, 10)

    async def ask(self, message):
        answer = await self.client.call_async(Trigger.Request())
        self.answers.append(f'{message.data} {answer.message}')


def test_asynchronous_callbacks_and_clients_of_nodes_are_served(script):
    script.add(Clockwork)
    node = script.add(Asynchronous)
    ask = script.publisher(String, 'ask')
    script.connect()
    script.wait_for(node.client.service_is_ready, 'the service')
    script.publish(ask, String(data='hello'))
    assert node.answers == ['hello poked']
    script.publish(ask, String(data='again'))
    assert node.answers == ['hello poked', 'again poked']


def test_time_can_be_moved_back(script):
    node = script.add(Clockwork)
    script.run(1.0, 0.02)
    script.move_to(SECOND)
    assert node.get_clock().now().nanoseconds == SECOND
    ticks = script.listen(Float64, 'ticks')
    script.run(0.2, 0.02)
    assert len(ticks) >= 9 and ticks[-1].data == pytest.approx(1.2)


def test_robot_and_parameters_reach_the_node(script, robot_path):
    node = script.add(RobotNode, 'named', robot=robot_path, parameters={'drive.rate': 25.0})
    assert node.robot.drive.rate == 25.0 and node.get_name() == 'named'
    assert node.set_parameters([parameter('drive.rate', 30.0)])[0].successful


def test_the_example_of_the_documentation_runs(robot_path, monkeypatch):
    from mecanum_base.ros import scripted

    lines = scripted.__doc__.split('::\n\n')[1].split('\n\nOrder')[0]
    code = '\n'.join(line[4:] for line in lines.splitlines())
    monkeypatch.chdir(robot_path.parents[1])
    names = {}
    exec('from geometry_msgs.msg import Twist, Vector3\n'
         'from sensor_msgs.msg import JointState\n'
         'from mecanum_base.ros.drive_node import DriveNode\n'
         'from mecanum_base.ros.scripted import Script\n', names)
    exec(code, names)
    assert len(names['wheels']) > 15
