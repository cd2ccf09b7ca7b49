"""RViz and Foxglove files: known panels, and topics that running nodes have, in the right type.

Names of panels, their settings and displays are those of saved layouts of Foxglove Studio and of
RViz 2 (rviz_default_plugins); neither program can be installed here.
"""

import json
import re

import pytest
import yaml

from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.ros.base_node import node_class
from mecanum_base.ros.scripted import Script

PLOT = {'title', 'paths', 'showXAxisLabels', 'showYAxisLabels', 'showLegend', 'legendDisplay',
        'showPlotValuesInLegend', 'isSynced', 'xAxisVal', 'xAxisPath', 'sidebarDimension',
        'followingViewWidth', 'minYValue', 'maxYValue'}
PANELS = {
    '3D': {'cameraState', 'followMode', 'followTf', 'scene', 'transforms', 'topics', 'layers'},
    'Plot': PLOT,
    'DiagnosticSummary': {'minLevel', 'pinnedIds', 'hardwareIdFilter', 'topicToRender',
                          'sortByLevel'},
}
LINE = {'value', 'enabled', 'timestampMethod', 'label', 'color'}
DRAWN = {  # by the 3D panel of Foxglove
    'visualization_msgs/msg/MarkerArray', 'nav_msgs/msg/Odometry', 'sensor_msgs/msg/LaserScan',
    'geometry_msgs/msg/PoseStamped', 'geometry_msgs/msg/PoseArray'}
DISPLAYS = {  # display or tool of RViz: the message type it takes
    'rviz_default_plugins/Grid': None, 'rviz_default_plugins/TF': None,
    'rviz_default_plugins/MarkerArray': 'visualization_msgs/msg/MarkerArray',
    'rviz_default_plugins/Odometry': 'nav_msgs/msg/Odometry',
    'rviz_default_plugins/MoveCamera': None, 'rviz_default_plugins/Measure': None,
    'rviz_default_plugins/SetInitialPose': 'geometry_msgs/msg/PoseWithCovarianceStamped',
    'rviz_default_plugins/SetGoal': 'geometry_msgs/msg/PoseStamped',
}


@pytest.fixture(scope='module')
def layout():
    return json.loads((shipped() / 'mecanum_base.foxglove.json').read_text(encoding='utf-8'))


@pytest.fixture(scope='module')
def manager():
    text = (shipped() / 'mecanum_base.rviz').read_text(encoding='utf-8')
    return yaml.safe_load(text)['Visualization Manager']


@pytest.fixture(scope='module')
def graph():
    """(published, subscribed) of all running nodes: {topic: type name}."""
    found = {}, {}
    with Script() as script:
        for name in ('sim', 'drive', 'odometry', 'goal'):
            node = script.add(node_class(name), robot=shipped() / 'mecanum4.yaml', stepped=False)
            for seen, ask in zip(found, (node.get_publisher_names_and_types_by_node,
                                         node.get_subscriber_names_and_types_by_node)):
                seen.update({topic: types[0] for topic, types in ask(node.get_name(), '/')})
    return found


def message_class(name):
    package, kind = name.split('/msg/')
    return getattr(__import__(f'{package}.msg', fromlist=[kind]), kind)


def resolve(path, type_name):
    """The type at the end of `.field.field[0]` of a message; AssertionError for a wrong path."""
    for field, index in re.findall(r'\.(\w+)(\[\d+\])?', path):
        fields = message_class(type_name).get_fields_and_field_types()
        assert field in fields, f'{type_name} has no {field}'
        type_name = fields[field]
        if index:
            element = re.fullmatch(r'sequence<(.+)>', type_name)
            assert element, f'{field} is no list'
            type_name = element[1]
        type_name = type_name.replace('/', '/msg/')
    return type_name


def lines(panel):
    return [*panel.get('paths', []), *([panel['xAxisPath']] if 'xAxisPath' in panel else [])]


def test_the_layout_has_the_parts_of_one(layout):
    assert set(layout) == {'configById', 'globalVariables', 'userNodes', 'playbackConfig',
                           'layout'}

    def leaves(node):
        if isinstance(node, str):
            return [node]
        assert set(node) == {'direction', 'first', 'second', 'splitPercentage'}
        assert node['direction'] in ('row', 'column') and 0 < node['splitPercentage'] < 100
        return leaves(node['first']) + leaves(node['second'])

    assert sorted(leaves(layout['layout'])) == sorted(layout['configById'])


def test_panels_are_known_with_known_settings(layout):
    for name, panel in layout['configById'].items():
        kind, _, number = name.partition('!')
        assert number and set(panel) <= PANELS[kind], name
        if kind == 'Plot':
            assert panel['xAxisVal'] in ('timestamp', 'custom')
            assert (panel['xAxisVal'] == 'custom') == ('xAxisPath' in panel)
            for line in lines(panel):
                assert set(line) <= LINE and {'value', 'enabled'} <= set(line)
                assert line.get('timestampMethod', 'receiveTime') in ('receiveTime',
                                                                      'headerStamp')


def test_plots_show_numbers_of_messages_that_are_published(layout, graph):
    published, _ = graph
    wheels = load_robot(shipped() / 'mecanum4.yaml').base.count
    for panel in layout['configById'].values():
        for line in lines(panel):
            topic, _, rest = line['value'].partition('.')
            assert resolve('.' + rest, published[topic]) == 'double', line['value']
            if line.get('timestampMethod') == 'headerStamp':
                assert 'header' in message_class(published[topic]).get_fields_and_field_types()
            for index in re.findall(r'\[(\d+)\]', rest):
                # slip/probability has one more: the body
                assert int(index) < wheels + (topic == '/slip/probability')


def test_the_scene_shows_topics_that_exist_in_a_type_that_can_be_drawn(layout, graph):
    published, subscribed = graph
    scene = layout['configById']['3D!floor']
    for topic in scene['topics']:
        assert (published | subscribed)[topic] in DRAWN, topic
    assert {'/slip/markers', '/odom'} <= set(scene['topics'])
    assert scene['followMode'] in ('follow-pose', 'follow-position', 'follow-none')
    assert scene['followTf'] == 'base_link'
    assert all(layer['layerId'] == 'foxglove.Grid' for layer in scene['layers'].values())
    health = layout['configById']['DiagnosticSummary!health']['topicToRender']
    assert published[health] == 'diagnostic_msgs/msg/DiagnosticArray'


def test_rviz_displays_and_tools_have_topics_of_their_type(manager, graph):
    published, subscribed = graph
    for display in manager['Displays']:
        wanted = DISPLAYS[display['Class']]
        if wanted is None:
            assert 'Topic' not in display
            continue
        topic = display['Topic']
        assert published['/' + topic['Value']] == wanted
        # publishers are reliable: a best-effort or a reliable display can hear them
        assert topic['Reliability Policy'] in ('Best Effort', 'Reliable')
        assert topic['Durability Policy'] == 'Volatile'
    for tool in manager['Tools']:
        wanted = DISPLAYS[tool['Class']]
        if wanted is not None:
            assert subscribed['/' + tool['Topic']['Value']] == wanted
    assert manager['Global Options']['Fixed Frame'] == 'odom'
    assert manager['Views']['Current']['Class'] == 'rviz_default_plugins/TopDownOrtho'
