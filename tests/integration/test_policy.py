from xml.etree import ElementTree as Xml

from mecanum_base.integration.policy import NODES, policy


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


def test_the_policy_and_the_nodes_agree_on_every_topic():
    """The recorder's list of contract topics is the second, independent source."""
    import pytest
    pytest.importorskip('rclpy')
    from mecanum_base.ros.contract_topics import contract_topics
    from mecanum_base.ros.transforms import Transforms
    recorded = {topic.lstrip('/') for topic in contract_topics(Transforms())}
    asked = {topic.lstrip('/') for topic in NODES['record_node'].subscribes}
    assert recorded <= asked
    published = {topic.lstrip('/') for node in NODES.values() for topic in node.publishes}
    assert published <= asked
