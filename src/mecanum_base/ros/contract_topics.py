"""Every topic of the interface contract with the message types it may have."""

from __future__ import annotations

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import (
    PoseArray,
    PoseStamped,
    PoseWithCovarianceStamped,
    Twist,
    TwistStamped,
    TwistWithCovarianceStamped,
)
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState, LaserScan
from std_msgs.msg import Float64MultiArray, Header, Int32MultiArray, Int64MultiArray

from mecanum_base.ros.transforms import Transforms

MESSAGES: dict[str, tuple[Any, ...]] = {
    'cmd_vel': (Twist, TwistStamped),
    'cmd_vel_limited': (TwistStamped,),
    'wheel_commands': (JointState, Float64MultiArray),
    'joint_states': (JointState,),
    'wheel_ticks': (Int64MultiArray, Int32MultiArray),
    'imu/data_raw': (Imu,),
    'set_pose': (PoseWithCovarianceStamped,),
    'odometry_reset': (Header,),
    'odom': (Odometry,),
    'slip/twist': (TwistWithCovarianceStamped,),
    'slip/wheels': (JointState,),
    'slip/probability': (Float64MultiArray,),
    'slip/ratio': (Float64MultiArray,),
    'ground_truth/odom': (Odometry,),
    'ground_truth/slip': (JointState,),
    'goal_pose': (PoseStamped,),
    'obstacles': (PoseArray,),
    'scan': (LaserScan,),
    '/clock': (Clock,),
    '/diagnostics': (DiagnosticArray,),
}
TRANSFORM_TOPICS = ('tf', 'tf_static')


def type_name(message: Any) -> str:
    """``pkg/msg/Type`` of a message class."""
    return f'{message.__module__.split(".")[0]}/msg/{message.__name__}'


def contract_topics(transforms: Transforms) -> dict[str, dict[str, Any]]:
    """Message classes by type name, for each topic; transforms only where they are available."""
    topics = {topic: {type_name(m): m for m in found} for topic, found in MESSAGES.items()}
    if transforms.available:
        topics |= {topic: {'tf2_msgs/msg/TFMessage': transforms.message}
                   for topic in TRANSFORM_TOPICS}
    return topics
