"""The publishers of the odometry node: one estimate in, one message on each topic out."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import TransformStamped, TwistWithCovarianceStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, MultiArrayDimension

from mecanum_base import messages
from mecanum_base.core.records import Estimate
from mecanum_base.robot import Robot
from mecanum_base.ros.qos import RELIABLE, SENSOR_PUBLISHER
from mecanum_base.ros.slip_markers import SlipMarkers
from mecanum_base.ros.transforms import Transforms


class OdometryTopics:
    """Publishes estimates of ``robot``; message objects are made once and filled anew."""

    def __init__(self, node: Any, robot: Robot, transforms: Transforms) -> None:
        frames = robot.frames
        self._joints = robot.base.joint
        self._odom_frame = frames.tf_frame_prefix + frames.odom_frame_id
        self._base_frame = frames.tf_frame_prefix + frames.base_frame_id
        self._odom = node.create_publisher(Odometry, 'odom', RELIABLE)
        self._twist = node.create_publisher(TwistWithCovarianceStamped, 'slip/twist', RELIABLE)
        self._wheels = node.create_publisher(JointState, 'slip/wheels', RELIABLE)
        self._probability = node.create_publisher(Float64MultiArray, 'slip/probability', RELIABLE)
        self._ratio = node.create_publisher(Float64MultiArray, 'slip/ratio', RELIABLE)
        self._markers = SlipMarkers(node, robot)
        self._send = (transforms.sender(node, 'tf', SENSOR_PUBLISHER)
                      if frames.enable_odom_tf else None)
        self.tf_way = (transforms.way if frames.enable_odom_tf
                       else 'no transform is sent: enable_odom_tf is false')
        self.tf_missing = frames.enable_odom_tf and not transforms.available
        self._odometry, self._transform = Odometry(), TransformStamped()
        self._slip_twist, self._slip_wheels = TwistWithCovarianceStamped(), JointState()
        self._arrays = Float64MultiArray(), Float64MultiArray()
        self.count = {'encoder': 0, 'predicted': 0}

    def publish(self, estimate: Estimate) -> None:
        """Publish one estimate on every topic; all stamps are those of the estimate."""
        odom, base, slip = self._odom_frame, self._base_frame, estimate.slip
        self._odom.publish(messages.write_odometry(estimate, self._odometry, odom, base))
        if self._send is not None:
            self._send(messages.write_transform(estimate, self._transform, odom, base))
        self._twist.publish(messages.write_slip_twist(estimate, self._slip_twist, base))
        self._wheels.publish(messages.write_slip_wheels(
            estimate.stamp_ns, slip.rate, slip.angle, self._slip_wheels, self._joints))
        probability = messages.write_slip_probability(estimate, self._arrays[0])
        ratio = messages.write_slip_ratio(estimate, self._arrays[1])
        for publisher, msg in ((self._probability, probability), (self._ratio, ratio)):
            if not msg.layout.dim:
                messages.write_layout(msg, MultiArrayDimension(), 'wheels, then the body')
            publisher.publish(msg)
        self._markers.publish(estimate)
        self.count[estimate.source] = self.count.get(estimate.source, 0) + 1
