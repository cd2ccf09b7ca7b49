import math
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from mecanum_base.integration.urdf import urdf
from mecanum_base.robot_file import load_robot, shipped


def joints_of(text):
    return {j.get('name'): j for j in Xml.fromstring(text).iter('joint')}


def numbers(element, tag, key='xyz'):
    return [float(v) for v in element.find(tag).get(key).split()]


@pytest.mark.parametrize('path', sorted(shipped().glob('*.yaml')), ids=lambda p: p.stem)
def test_every_shipped_robot_becomes_one_tree_of_links(path):
    root = Xml.fromstring(urdf(load_robot(path)))
    links = [link.get('name') for link in root.iter('link')]
    children = [j.find('child').get('link') for j in root.iter('joint')]
    parents = {j.find('parent').get('link') for j in root.iter('joint')}
    assert len(set(links)) == len(links)
    assert len(set(children)) == len(children)
    assert parents <= set(links)
    assert set(links) - set(children) == {'base_footprint'}


def test_wheels_stand_where_the_robot_file_says_and_turn_about_their_axles():
    robot = load_robot(shipped() / 'mecanum4.yaml')
    joints = joints_of(urdf(robot))
    wheel = joints['rear_right_wheel_joint']
    assert wheel.get('type') == 'continuous'
    assert numbers(wheel, 'origin')[:2] == [-0.20, -0.15]
    assert numbers(wheel, 'axis') == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)
    imu = joints['imu_link_joint']
    assert numbers(imu, 'origin') == robot.imu.xyz.tolist()


def test_a_reversed_encoder_turns_about_the_opposite_axis():
    robot = load_robot(shipped() / 'mecanum4.yaml')
    encoder = type(robot.encoder)(counts_per_revolution=4096.0, sign=np.array([1, -1, 1, 1]))
    joints = joints_of(urdf(robot.replace(encoder=encoder)))
    wheel = joints['front_right_wheel_joint']
    assert numbers(wheel, 'axis') == pytest.approx([0.0, -1.0, 0.0], abs=1e-9)


def test_the_cylinder_of_a_wheel_lies_along_its_axle():
    robot = load_robot(shipped() / 'mecanum4.yaml')
    root = Xml.fromstring(urdf(robot))
    link = next(x for x in root.iter('link') if x.get('name') == 'front_left_wheel_link')
    roll, pitch, yaw = numbers(link.find('visual'), 'origin', 'rpy')
    assert roll == 0.0
    along = np.array([math.cos(yaw) * math.sin(pitch), math.sin(yaw) * math.sin(pitch),
                      math.cos(pitch)])  # third column of Rz(yaw) Ry(pitch)
    assert along == pytest.approx([0.0, 1.0, 0.0], abs=1e-8)
