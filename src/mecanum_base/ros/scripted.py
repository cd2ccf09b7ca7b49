"""Step nodes and simulated time deterministically: test your own stack, or run the demo.

A :class:`Script` has its own ROS context with discovery off, so nothing outside this process sees
it and nothing outside disturbs it. Nodes added to it run on simulated time that only
:meth:`Script.advance` moves. The same script gives the same messages in the same order, on a slow
machine as on a fast one::

    with Script() as script:
        drive = script.add(DriveNode, robot='config/mecanum4.yaml')
        wheels = script.listen(JointState, 'wheel_commands')
        steer = script.publisher(Twist, 'cmd_vel')
        script.connect()                                  # discovery inside the process
        script.publish(steer, Twist(linear=Vector3(x=0.3)))
        script.run(0.4, step=0.02)                        # 0.4 s of simulated time
        assert wheels[-1].velocity[0] > 0.0

Order within a step: the hooks of :meth:`before_step`, then the clocks move, then timers and
messages are worked off until nothing is left. Between two topics ROS 2 delivers in the order in
which subscriptions were made, not in the order of publishing; :meth:`publish` therefore delivers
one message to everybody before it returns. All nodes share one participant, which can use one
type per topic: make a publisher of TwistStamped before a node subscribes Twist. A step must not
be longer than the shortest timer period: a timer that was missed twice is called once.

Only rclpy, numpy and PyYAML are needed. Nodes of your own need nothing but a constructor that
passes its keyword arguments on to rclpy's Node.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Coroutine, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

import rclpy
from rclpy.clock import ROSClock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.time import Time
from rclpy.utilities import try_shutdown

from mecanum_base.ros.parameters import RobotSource, overrides
from mecanum_base.ros.polling import needs_executor, poll, serve
from mecanum_base.ros.qos import RELIABLE

AnyNode = TypeVar('AnyNode', bound=Node)
_NANOSECONDS = 1_000_000_000


class Script:
    """Nodes and a clock that are stepped by hand; close it, or use it in a ``with`` block.

    ``start_ns`` is the first time of the simulated clock; 0 means 'no time yet' to ROS 2, so the
    default is one second.
    """

    def __init__(self, *, start_ns: int = _NANOSECONDS) -> None:
        self.context = Context()
        with _discovery_off():
            rclpy.init(args=[], context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.now_ns = start_ns
        self._nodes: list[Node] = []
        self._stepped: list[Node] = []
        self._hooks: list[Callable[[int, int], None]] = []
        self._has_tasks = False  # an asynchronous callback has been called
        self._bench = self.add(Node, name='script', start_parameter_services=False)

    def __enter__(self) -> Script:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def add(self, make: Callable[..., AnyNode], *arguments: Any, robot: RobotSource | None = None,
            parameters: Mapping[str, Any] | None = None, stepped: bool = True,
            name: str | None = None, words: Sequence[str] | None = None,
            **options: Any) -> AnyNode:
        """Make a node in this script's context and take it over.

        ``robot`` is a robot file or a mapping for nodes that read one, ``parameters`` are further
        overrides by full name. A ``stepped`` node runs on this script's clock; pass False for a
        node that is the clock itself. ``name`` and ``options`` go to the node's constructor.
        With ``words`` (as on a command line: ``['--ros-args', '--params-file', ...]``) these say
        everything, use_sim_time included, and this script's clock is not imposed.
        """
        if words is not None:
            if robot is not None or parameters is not None:
                raise ValueError('words say everything: give neither robot nor parameters')
            return self._take_over(make(context=self.context, cli_args=list(words), **options))
        given = {item.name: item for item in ([] if robot is None else overrides(robot))}
        more: dict[str, Any] = {'use_sim_time': stepped}
        if robot is not None and stepped:  # a script may stand still for as long as it likes
            more['drive.clock_timeout'] = 0.0
        more.update(parameters or {})
        given.update({item.name: item for item in overrides(more)})
        if name is not None:
            arguments = (name, *arguments)
        node = self._take_over(make(*arguments, context=self.context,
                                    parameter_overrides=list(given.values()), **options))
        if stepped:
            self._stepped.append(node)
            self._set_clock(node)
        return node

    def _take_over(self, node: AnyNode) -> AnyNode:
        self._nodes.append(node)
        self.executor.add_node(node)
        return node

    def remove(self, node: Node) -> None:
        """Take a node out and destroy it, as if its process had ended."""
        self.executor.remove_node(node)
        self._nodes.remove(node)
        if node in self._stepped:
            self._stepped.remove(node)
        node.destroy_node()

    def publisher(self, message: type[Any], topic: str, qos: QoSProfile = RELIABLE) -> Publisher:
        """A publisher of the script's own node."""
        return self._bench.create_publisher(message, topic, qos)

    def listen(self, message: type[Any], topic: str, qos: QoSProfile = RELIABLE,
               call: Callable[[Any], None] | None = None) -> list[Any]:
        """The list that every message of the topic is appended to (``call`` sees it as well)."""
        heard: list[Any] = []

        def receive(msg: Any) -> None:
            heard.append(msg)
            if call is not None:
                call(msg)

        self._bench.create_subscription(message, topic, receive, qos)
        return heard

    def before_step(self, hook: Callable[[int, int], None]) -> None:
        """Call ``hook(now_ns, next_ns)`` at the start of every step, before the clocks move."""
        self._hooks.append(hook)

    def publish(self, publisher: Publisher, message: Any) -> None:
        """Publish one message and deliver it, and all that follows from it, to everybody."""
        publisher.publish(message)
        self.settle()

    def call(self, service: type[Any], name: str, request: Any, limit: float = 5.0) -> Any:
        """Call a service and return its answer; TimeoutError after ``limit`` s of wall time."""
        client = self._bench.create_client(service, name)
        try:
            self.wait_for(client.service_is_ready, f'service {name}', limit)
            future = client.call_async(request)
            self.wait_for(future.done, f'answer of {name}', limit)
            return future.result()
        finally:
            self._bench.destroy_client(client)

    def connect(self, limit: float = 5.0) -> None:
        """Wait until every publisher of the script has a subscriber and the graph is still."""
        for publisher in list(self._bench.publishers):
            if publisher.topic_name not in ('/rosout', '/parameter_events'):
                self._wait_for_subscriber(publisher, limit)
        self.settle()

    def _wait_for_subscriber(self, publisher: Publisher, limit: float) -> None:
        self.wait_for(lambda: publisher.get_subscription_count() > 0,
                      f'a subscriber of {publisher.topic_name}', limit)

    def wait_for(self, condition: Callable[[], bool], what: str, limit: float = 5.0) -> None:
        """Work off callbacks, with time standing still, until the condition holds.

        Raises TimeoutError naming ``what`` after ``limit`` s of wall time.
        """
        end = time.monotonic() + limit
        while not condition():
            self.executor.spin_once(timeout_sec=0.01)
            if time.monotonic() > end:
                raise TimeoutError(f'not within {limit} s: {what}')

    def settle(self) -> None:
        """Work off everything that is ready; an exception of a callback comes out here."""
        while True:
            while any([poll(node, self._later) for node in list(self._nodes)]):
                pass
            if not any([serve(node) for node in list(self._nodes)]) and not self._serve_rest():
                return

    def _later(self, work: Coroutine[Any, Any, Any]) -> None:
        self._has_tasks = True
        self.executor.create_task(work)

    def _serve_rest(self) -> bool:
        """One round of rclpy's executor for what is not polled; whether it called anything."""
        if not self._has_tasks and not any(needs_executor(node) for node in self._nodes):
            return False
        for _ in range(2):  # the first may end the last round, without a new look
            try:
                handler, _, _ = self.executor.wait_for_ready_callbacks(timeout_sec=0.0)
            except TimeoutException:
                continue
            handler()
            handler.result()
            return True
        return False

    def advance(self, dt: float) -> None:
        """One step of simulated time of ``dt`` s (rounded to nanoseconds); then settle."""
        self.move_to(self.now_ns + round(dt * _NANOSECONDS))

    def move_to(self, stamp_ns: int) -> None:
        """One step to a given time, also backwards; then settle."""
        for hook in self._hooks:
            hook(self.now_ns, stamp_ns)
        self.now_ns = stamp_ns
        for node in self._stepped:
            self._set_clock(node)
        self.settle()

    def run(self, duration: float, step: float, each: Callable[[], None] | None = None) -> None:
        """Steps of ``step`` s for ``duration`` s; ``each`` is called before every step."""
        for _ in range(round(duration / step)):
            if each is not None:
                each()
            self.advance(step)

    def close(self) -> None:
        """Destroy all nodes and the context."""
        for node in list(self._nodes):
            self.remove(node)
        self.executor.shutdown()
        try_shutdown(context=self.context)

    def _set_clock(self, node: Node) -> None:
        clock = node.get_clock()
        assert isinstance(clock, ROSClock)
        clock.set_ros_time_override(
            Time(nanoseconds=self.now_ns, clock_type=ClockType.ROS_TIME))


@contextmanager
def _discovery_off() -> Iterator[None]:
    """ROS reads these variables when the context is made; they are put back afterwards."""
    before = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE')
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'OFF'
    try:
        yield
    finally:
        if before is None:
            del os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE']
        else:
            os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = before


def parameter(name: str, value: Any) -> Parameter:
    """A parameter for ``node.set_parameters([...])`` in a test."""
    return overrides({name: value})[0]
