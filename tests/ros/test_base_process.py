"""Drive and odometry in one process: moves, survives kill -9, ends cleanly."""

import signal

from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState

from mecanum_base.ros.qos import SENSOR


def test_the_composed_base_drives_is_killed_comes_back_and_ends_with_wheels_at_zero(
        outside, start, robot_path):
    def begin():
        return start('-m', 'mecanum_base', 'base', '--robot', robot_path)

    process = begin()
    start('-m', 'mecanum_base', 'sim', '--robot', robot_path)
    odom = outside.listen(Odometry, 'odom')
    wheels = outside.listen(JointState, 'wheel_commands')
    truth = outside.listen(Odometry, 'ground_truth/odom', SENSOR)
    publisher = outside.node.create_publisher(Twist, 'cmd_vel', 10)
    outside.steer = lambda: publisher.publish(Twist(linear=Vector3(x=0.3)))
    outside.until(lambda: odom and odom[-1][1].pose.pose.position.x > 0.2, 'odometry to move')
    names = {name for name, _ in outside.node.get_node_names_and_namespaces()}
    assert {'drive_node', 'odometry_node', 'sim_node'} <= names
    # killed: nobody sends zeros, the hardware stops; then both nodes are back
    process.send(signal.SIGKILL)
    assert process.finish() == -signal.SIGKILL
    outside.until(lambda: all(abs(m.twist.twist.linear.x) < 0.01 for _, m in truth[-30:]),
                  'the simulated hardware to stop')
    assert any(wheels[-1][1].velocity)
    # no command until its odometry is heard: it might have moved by then
    steer, outside.steer, count = outside.steer, None, len(odom)
    process = begin()
    outside.until(lambda: len(odom) > count + 20, 'odometry again')
    assert abs(odom[-1][1].pose.pose.position.x) < 0.05  # it starts anew
    outside.steer = steer
    outside.until(lambda: truth[-1][1].twist.twist.linear.x > 0.2, 'the base to move again')
    process.send(signal.SIGINT)
    outside.until(lambda: process.ended, 'end of the process')
    outside.wait(0.1)
    assert list(wheels[-1][1].velocity) == [0.0] * 4
    assert process.finish() == 0 and 'Traceback' not in process.output
