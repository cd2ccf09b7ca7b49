"""Surroundings of tests with real rclpy: strict messages, fast discovery, nothing shared.

The variables are set when tests are collected, before the first participant of this process reads
them. Nodes talk by config/integration/fastdds_udp.xml, as robots should whose nodes may be killed:
in Fast DDS's shared memory the successor of a killed node now and then hears nothing, a stopped
one that holds a lock halts those who publish to it, and every killed one leaves its memory behind.
Discovery between processes takes up to 3 s by default; here it is told to take 0.2 s.
"""

import contextlib
import fcntl
import importlib.util
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time

import pytest

from mecanum_base import robot_file

# without rclpy the rest of the suite still runs
collect_ignore_glob = [] if importlib.util.find_spec('rclpy') else ['test_*.py']

_QUICK_DISCOVERY = """<discovery_config>
  <leaseAnnouncement><sec>0</sec><nanosec>100000000</nanosec></leaseAnnouncement>
  <initialAnnouncements><count>10</count><period><sec>0</sec><nanosec>50000000</nanosec></period>
  </initialAnnouncements>
 </discovery_config>"""
_SHIPPED_PROFILE = robot_file.shipped() / 'integration' / 'fastdds_udp.xml'
_SCRATCH = tempfile.TemporaryDirectory(prefix='mecanum_base_ros_')
_profile_file = pathlib.Path(_SCRATCH.name, 'discovery.xml')
_profile_file.write_text(_SHIPPED_PROFILE.read_text(encoding='utf-8').replace(
    '<builtin>', f'<builtin>{_QUICK_DISCOVERY}'))
os.environ['ROS_PYTHON_CHECK_FIELDS'] = '1'
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'SYSTEM_DEFAULT'  # what the profile says
os.environ['ROS_LOG_DIR'] = _SCRATCH.name
os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(_profile_file)

STEER_PERIOD = 0.05


class Outside:
    """A plain rclpy node in a context of its own: what another process sees of our nodes."""

    def __init__(self, domain):
        import rclpy
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node

        self.domain = domain
        self.context = Context()
        rclpy.init(args=[], context=self.context, domain_id=domain)
        self.node = Node('outside', context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.steer = None  # called every 0.05 s while waiting

    def listen(self, message, topic, qos=10):
        """The list of (time, message) that grows while waiting."""
        heard = []
        self.node.create_subscription(
            message, topic, lambda m: heard.append((time.monotonic(), m)), qos)
        return heard

    def until(self, condition, what, limit=60.0):
        """Spin until the condition holds; the limit is generous, for busy machines."""
        end, following = time.monotonic() + limit, 0.0
        while not condition():
            now = time.monotonic()
            if now > end:
                raise AssertionError(f'not within {limit} s: {what}')
            if self.steer is not None and now >= following:
                self.steer()
                following = now + STEER_PERIOD
            self.executor.spin_once(timeout_sec=0.02)

    def wait(self, seconds):
        """Spin for a while."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, 'time to pass', seconds + 10.0)

    def call(self, service, name, request, limit=60.0):
        """The answer of a service."""
        client = self.node.create_client(service, name)
        self.until(client.service_is_ready, f'service {name}', limit)
        future = client.call_async(request)
        self.until(future.done, f'answer of {name}', limit)
        self.node.destroy_client(client)
        return future.result()

    def close(self):
        """Destroy node and context."""
        import rclpy

        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


class Process:
    """One of our nodes in a process of its own; ``words`` as after ``python``."""

    def __init__(self, domain, *words):
        environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain), 'PYTHONUNBUFFERED': '1'}
        self.process = subprocess.Popen(
            [sys.executable, *map(str, words)], env=environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        self.output = ''

    def send(self, number):
        """Send a signal."""
        self.process.send_signal(number)

    def pause(self, seconds):
        """Stop it now and let it go on later, whatever the caller does in between.

        The caller may itself have to wait for it: for a lock that it holds, or a full buffer.
        """
        self.send(signal.SIGSTOP)
        threading.Timer(seconds, self.send, [signal.SIGCONT]).start()

    @property
    def ended(self):
        """Whether the process has ended."""
        return self.process.poll() is not None

    def finish(self, limit=60.0):
        """Exit code after the process has ended by itself."""
        self.output += self.process.communicate(timeout=limit)[0]
        return self.process.returncode

    def close(self):
        """Kill what is left."""
        if not self.ended:
            self.process.send_signal(signal.SIGKILL)
        self.process.communicate()


@pytest.fixture(scope='session')
def robot_path():
    """The reference robot file."""
    return robot_file.shipped() / 'mecanum4.yaml'


@contextlib.contextmanager
def free_domain():
    """A DDS domain that no other test of this machine uses at the same time.

    Held by a lock on a file, which ends with the process, however that ends. Up to 101 the ports
    of a domain stay below the ephemeral ones.
    """
    folder = pathlib.Path(tempfile.gettempdir(), f'mecanum_base_domains_{os.getuid()}')
    folder.mkdir(exist_ok=True)
    domains = random.SystemRandom().sample(range(1, 101), 100)
    for domain in domains:
        with (folder / str(domain)).open('w') as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain
            return
    raise RuntimeError('all 100 DDS domains are in use by tests')


@pytest.fixture
def outside():
    """A plain node in a DDS domain of its own, for one test."""
    with free_domain() as domain:
        watcher = Outside(domain)
        yield watcher
        watcher.close()


@pytest.fixture(scope='module')
def outside_of_module():
    """The same for all tests of a module."""
    with free_domain() as domain:
        watcher = Outside(domain)
        yield watcher
        watcher.close()


@pytest.fixture
def start(outside):
    """Start ``python WORDS`` in the domain of ``outside``; killed at the end of the test."""
    started = []

    def begin(*words):
        started.append(Process(outside.domain, *words))
        return started[-1]

    yield begin
    for process in started:
        process.close()
