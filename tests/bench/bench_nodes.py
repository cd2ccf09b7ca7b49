"""CPU and memory of every node at 100 Hz encoders, 200 Hz IMU and 20 Hz commands, in one run.

All nodes run at the same time in processes of their own, fed by the same messages over DDS, beside
a bare rclpy node that does nothing but publish the same encoder and IMU messages again. The last
column is the ratio to that relay. Then the composed process (drive + odometry) beside the relay,
then the simulated hardware, which itself sends the sensor messages that the relay repeats.

    python tests/bench/bench_nodes.py [--seconds 10]
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import psutil

DOMAIN = 101  # the tests use 1 to 100
READY_WITHIN = 60.0  # s, on a busy computer
ROOT = pathlib.Path(__file__).parents[2]
ROBOT = ROOT / 'config' / 'mecanum4.yaml'
JOINTS = ['front_left_wheel_joint', 'front_right_wheel_joint', 'rear_left_wheel_joint',
          'rear_right_wheel_joint']
RELAY = """
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Imu, JointState
rclpy.init()
node = Node('relay')
sensor = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
for kind, topic in ((JointState, 'joint_states'), (Imu, 'imu/data_raw')):
    out = node.create_publisher(kind, 'relay/' + topic, 100)
    node.create_subscription(kind, topic, out.publish, sensor)
rclpy.spin(node)
"""
SOURCE = """
import sys, time
import rclpy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Imu, JointState
rclpy.init()
node = rclpy.create_node('source')
joints, imu, steer = (node.create_publisher(kind, topic, 100) for kind, topic in (
    (JointState, 'joint_states'), (Imu, 'imu/data_raw'), (Twist, 'cmd_vel')))
wheels = JointState(name=sys.argv[1:])
motion, command = Imu(), Twist()
motion.orientation_covariance[0] = -1.0
motion.linear_acceleration.z = 9.81
command.linear.x = 0.3
start, tick = time.monotonic(), 0
while True:
    now = node.get_clock().now().to_msg()
    motion.header.stamp = now
    imu.publish(motion)
    if tick % 2 == 0:
        wheels.header.stamp = now
        wheels.position = [6.0 * (time.monotonic() - start)] * len(wheels.name)
        joints.publish(wheels)
    if tick % 10 == 0:
        steer.publish(command)
    tick += 1
    time.sleep(max(0.0, start + tick / 200.0 - time.monotonic()))
"""
READY = """
import sys, time
import rclpy
rclpy.init()
node = rclpy.create_node('ready')
while any(node.count_publishers(topic) == 0 for topic in sys.argv[1:]):
    time.sleep(0.1)
"""


def begin(*words):
    """Start ``python WORDS`` in the DDS domain of the bench."""
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(DOMAIN),
                   'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    environment.pop('ROS_PYTHON_CHECK_FIELDS', None)  # as on a robot
    return subprocess.Popen([sys.executable, *map(str, words)], env=environment,
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def measure(named_words, topics, seconds, fed=True):
    """{name: (CPU in percent of a core, resident MB)} of processes running at the same time.

    Measuring begins when somebody publishes each of ``topics``.
    """
    processes = {name: begin(*words) for name, words in named_words.items()}
    source = [begin('-c', SOURCE, *JOINTS)] if fed else []
    try:
        source.append(begin('-c', READY, *topics))
        source[-1].wait(READY_WITHIN)
        time.sleep(2.0)  # first messages, caches
        seen = {name: psutil.Process(one.pid) for name, one in processes.items()}
        before = {name: one.cpu_times() for name, one in seen.items()}
        start = time.monotonic()
        time.sleep(seconds)
        passed = time.monotonic() - start
        found = {}
        for name, one in seen.items():
            used = sum(one.cpu_times()[:2]) - sum(before[name][:2])
            found[name] = (100.0 * used / passed, one.memory_info().rss / 1e6)
        return found
    finally:
        for one in (*source, *processes.values()):
            one.kill()
            one.wait()


def show(title, found):
    """Print one table."""
    print(f'{title}\n{"":12} {"CPU %":>7} {"MB":>6} {"x relay":>8}')
    for name, (cpu, memory) in found.items():
        print(f'{name:12} {cpu:7.1f} {memory:6.0f} {cpu / found["relay"][0]:8.2f}')


def main():
    """Run both measurements."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=10.0, help='of each measurement')
    options = parser.parse_args()

    def verb(name, *more):
        return ('-m', 'mecanum_base', name, '--robot', ROBOT, *more)

    with tempfile.TemporaryDirectory() as folder:
        show('each node in its own process', measure({
            'relay': ('-c', RELAY), 'drive': verb('drive'), 'odometry': verb('odometry'),
            'goal': verb('goal'),
            'record': verb('record', '--ros-args', '-p', f'record.output:={folder}/bag'),
        }, ('relay/joint_states', 'wheel_commands', 'odom', 'imu/data_raw'), options.seconds))
    show('drive and odometry in one process', measure({
        'relay': ('-c', RELAY), 'base': verb('base')},
        ('relay/joint_states', 'odom', 'imu/data_raw'), options.seconds))
    show('simulated hardware', measure({
        'relay': ('-c', RELAY), 'sim': verb('sim')},
        ('relay/joint_states', 'imu/data_raw'), options.seconds, fed=False))


if __name__ == '__main__':
    main()
