"""Drive, odometry and simulation in one process: moves, answers, ends cleanly."""

import signal

from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState


def test_the_composed_base_drives_and_ends_with_wheels_at_zero(outside, start, robot_path):
    process = start('-m', 'mecanum_base', 'base', '--robot', robot_path, '--sim')
    odom = outside.listen(Odometry, 'odom')
    wheels = outside.listen(JointState, 'wheel_commands')
    publisher = outside.node.create_publisher(Twist, 'cmd_vel', 10)
    outside.steer = lambda: publisher.publish(Twist(linear=Vector3(x=0.3)))
    outside.until(lambda: odom and odom[-1][1].pose.pose.position.x > 0.2, 'odometry to move')
    names = {name for name, _ in outside.node.get_node_names_and_namespaces()}
    assert {'drive_node', 'odometry_node', 'sim_node'} <= names
    process.send(signal.SIGINT)
    outside.until(lambda: process.ended, 'end of the process')
    outside.wait(0.1)
    assert list(wheels[-1][1].velocity) == [0.0] * 4
    assert process.finish() == 0 and 'Traceback' not in process.output
