"""Health check of a container: exit 0 when /diagnostics of this machine holds no ERROR or STALE.

A container that runs no node (a demo, an analysis) sends no diagnostics and is healthy as well:
only what a node reports can make it unhealthy. Set HEALTH_NEEDS_NODE=1 where silence is a fault.
"""

import os
import sys
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.executors import SingleThreadedExecutor

SECONDS = 4.0


def main():
    """Listen for a few seconds; returns the exit code."""
    rclpy.init()
    node = rclpy.create_node('healthy')
    worst = {}

    def note(message):
        for status in message.status:
            worst[status.name] = (status.level, status.message)

    node.create_subscription(DiagnosticArray, '/diagnostics', note, 10)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    end = time.monotonic() + SECONDS
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=0.2)
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()
    if not worst and os.environ.get('HEALTH_NEEDS_NODE') == '1':
        print('no diagnostics')
        return 1
    bad = {name: text for name, (level, text) in worst.items()
           if level in (DiagnosticStatus.ERROR, DiagnosticStatus.STALE)}
    for name, text in bad.items():
        print(f'{name}: {text}')
    return 1 if bad else 0


sys.exit(main())
