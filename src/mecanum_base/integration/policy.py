"""An SROS2 access policy for exactly the topics and services of our nodes.

    mecanum check robot.yaml --policy policy.xml
    ros2 security create_keystore keystore
    ros2 security create_enclave keystore /mecanum_base/drive_node      (once a node)
    ros2 security create_permission keystore /mecanum_base/drive_node policy.xml

The names are those of the interface; a node that is remapped or put into a namespace needs the
same change here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as Xml


@dataclass(frozen=True)
class NodeInterface:
    """Relative names a node subscribes to, publishes and serves."""

    subscribes: tuple[str, ...] = ()
    publishes: tuple[str, ...] = ()
    services: tuple[str, ...] = ()


_SLIP = ('slip/twist', 'slip/wheels', 'slip/probability', 'slip/ratio')
_SENSORS = ('joint_states', 'wheel_ticks', 'imu/data_raw')
_ODOMETRY = ('odom', '/tf', *_SLIP, 'odometry_reset')
_TRUTH = ('ground_truth/odom', 'ground_truth/slip')
_TRANSFORMS = ('/tf', '/tf_static')

NODES = {
    'drive_node': NodeInterface(('cmd_vel', 'joint_states'),  # hinge angles of carriers
                                ('wheel_commands', 'cmd_vel_limited'), ('~/enable',)),
    'odometry_node': NodeInterface((*_SENSORS, 'set_pose', 'wheel_commands', '/tf_static'),
                                   (*_ODOMETRY, 'slip/markers'), ('~/reset',)),
    'sim_node': NodeInterface(('wheel_commands',), (*_SENSORS, *_TRUTH, '/clock'),
                              ('~/reset', '~/fault')),
    'goal_node': NodeInterface(('goal_pose', 'odom', 'obstacles', 'scan', *_TRANSFORMS),
                               ('cmd_vel',), ('~/cancel',)),
    'record_node': NodeInterface(
        ('cmd_vel', 'cmd_vel_limited', 'wheel_commands', *_SENSORS, 'set_pose', *_ODOMETRY,
         '/tf_static', *_TRUTH, 'goal_pose', 'obstacles', 'scan', '/diagnostics', '/clock')),
}
PARAMETER_SERVICES = ('describe_parameters', 'get_parameter_types', 'get_parameters',
                      'get_type_description', 'list_parameters', 'set_parameters',
                      'set_parameters_atomically')


def policy(namespace: str = '/', enclave: str = '/mecanum_base') -> str:
    """Policy file (XML) with one enclave a node below ``enclave``, for nodes in ``namespace``."""
    root = Xml.Element('policy', version='0.2.0')
    enclaves = Xml.SubElement(root, 'enclaves')
    for name, interface in NODES.items():
        element = Xml.SubElement(enclaves, 'enclave', path=f'{enclave}/{name}')
        profiles = Xml.SubElement(element, 'profiles')
        profile = Xml.SubElement(profiles, 'profile', ns=namespace, node=name)
        _names(profile, 'topics', 'topic', {'subscribe': 'ALLOW'},
               (*interface.subscribes, '/clock', '/parameter_events'))
        _names(profile, 'topics', 'topic', {'publish': 'ALLOW'},
               (*interface.publishes, '/diagnostics', '/rosout', '/parameter_events'))
        _names(profile, 'services', 'service', {'reply': 'ALLOW'},
               (*interface.services, *(f'~/{service}' for service in PARAMETER_SERVICES)))
    Xml.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, 'unicode') + '\n'


def _names(profile: Xml.Element, group: str, tag: str, permission: dict[str, str],
           names: Sequence[str]) -> None:
    block = Xml.SubElement(profile, group, permission)
    for name in dict.fromkeys(names):
        Xml.SubElement(block, tag).text = name
