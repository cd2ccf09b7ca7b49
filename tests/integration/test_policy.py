from xml.etree import ElementTree as Xml

import pytest

from mecanum_base.integration.policy import NODES, policy
from mecanum_base.robot_file import read_parameters, shipped


def names(profile, group, permission):
    return {element.text for block in profile.iter(group)
            for key, value in block.attrib.items() if (key, value) == (permission, 'ALLOW')
            for element in block}


def test_every_node_gets_exactly_its_own_topics():
    root = Xml.fromstring(policy('/robot1', '/fleet'))
    profiles = {profile.get('node'): profile for profile in root.iter('profile')}
    assert set(profiles) == set(NODES)
    drive = profiles['drive_node']
    assert drive.get('ns') == '/robot1'
    assert 'cmd_vel' in names(drive, 'topics', 'subscribe')
    assert 'cmd_vel' not in names(drive, 'topics', 'publish')
    assert '~/enable' in names(drive, 'services', 'reply')
    assert 'wheel_commands' not in names(profiles['goal_node'], 'topics', 'publish')
    assert {e.get('path') for e in root.iter('enclave')} == {f'/fleet/{node}' for node in NODES}


OPEN = {'/rosout', '/parameter_events', '/diagnostics'}  # the policy allows them to every node


def ends_of(node):
    """(subscribed, published, served) absolute names of a running node, without the open ones."""
    name = node.get_name()
    found = [dict(ask(name, '/')) for ask in (node.get_subscriber_names_and_types_by_node,
                                              node.get_publisher_names_and_types_by_node,
                                              node.get_service_names_and_types_by_node)]
    served = {n for n in found[2] if 'parameter' not in n and 'type_description' not in n}
    return set(found[0]) - OPEN, set(found[1]) - OPEN, served


def allowed(node, names):
    return {('/' + name.lstrip('/')).replace('/~/', f'/{node}/') for name in names} - OPEN


def test_running_nodes_have_what_the_policy_allows_and_nothing_else(tmp_path):
    """Robots that use every way in: ticks and angles, hinges, mount from tf, own clock."""
    pytest.importorskip('rclpy')
    from mecanum_base.ros.base_node import node_class
    from mecanum_base.ros.scripted import Script
    seen = {name: (set(), set(), set()) for name in NODES}
    for robot, source in (('mecanum4', 'joint_states'), ('mecanum4', 'wheel_ticks'),
                          ('dual_differential', 'joint_states')):
        mapping = dict(read_parameters(shipped() / f'{robot}.yaml'))
        mapping['encoder'] = {**mapping['encoder'], 'source': source}
        mapping['imu'] = {'from_tf': True}
        mapping['sim'] = {'publish_clock': True}
        mapping['record'] = {'output': str(tmp_path / f'{robot}_{source}')}
        if robot == 'dual_differential':
            mapping['carriers'] = {**mapping['carriers'], 'hinge_joint': ['front', 'rear']}
        for name in NODES:
            with Script() as script:
                node = script.add(node_class(name.removesuffix('_node')), robot=mapping,
                                  stepped=False)
                for before, found in zip(seen[name], ends_of(node)):
                    before |= found
    for name, (subscribed, published, served) in seen.items():
        rule = NODES[name]
        assert published == allowed(name, rule.publishes), name
        assert served == allowed(name, rule.services), name
        if name == 'record_node':  # subscribes what somebody publishes
            assert subscribed <= allowed(name, rule.subscribes)
        else:
            assert subscribed == allowed(name, rule.subscribes), name


def test_the_policy_and_the_nodes_agree_on_every_topic():
    """The recorder's list of contract topics is the second, independent source."""
    pytest.importorskip('rclpy')
    from mecanum_base.ros.contract_topics import contract_topics
    from mecanum_base.ros.transforms import Transforms
    recorded = {topic.lstrip('/') for topic in contract_topics(Transforms())}
    asked = {topic.lstrip('/') for topic in NODES['record_node'].subscribes}
    assert recorded <= asked
    published = {topic.lstrip('/') for node in NODES.values() for topic in node.publishes}
    assert published - {'slip/markers'} <= asked  # pictures are not worth recording
