"""A URDF of the robot from its robot file: wheels, IMU and a body, for RViz and Foxglove.

Frames: ``base_footprint`` on the floor, ``base_link`` at the height of the wheel axes. Wheel
joints are continuous and turn about the axle in the sense of the joint's own sign, so that the
raw joint_states of the hardware turn the picture the right way.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from xml.etree import ElementTree as Xml

import numpy as np

from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.robot import Robot

WHEEL_WIDTH = 0.8  # of the radius: for the picture only
BODY_HEIGHT = 1.2  # of the radius


def urdf(robot: Robot, name: str = 'mecanum_base') -> str:
    """URDF text (XML) of the robot; ``name`` becomes the model's name."""
    root = Xml.Element('robot', name=name)
    for material, colour in (('body', '0.25 0.45 0.7 1'), ('tyre', '0.15 0.15 0.17 1')):
        element = Xml.SubElement(root, 'material', name=material)
        Xml.SubElement(element, 'color', rgba=colour)
    base = robot.base
    radius = base.radius if isinstance(base, Wheels) else base.wheel_radius
    height = float(np.mean(radius))
    prefix = robot.frames.tf_frame_prefix
    body = prefix + robot.frames.base_frame_id
    if body != prefix + 'base_footprint':
        _link(root, prefix + 'base_footprint')
        _joint(root, 'base_footprint_joint', 'fixed', prefix + 'base_footprint', body,
               (0.0, 0.0, height))
    size = _body_size(base)
    link = _link(root, body)
    _visual(link, 'body', (0.0, 0.0, 0.5 * BODY_HEIGHT * height), (0.0, 0.0, 0.0),
            'box', size=_numbers((*size, BODY_HEIGHT * height)))
    _, signs = robot.encoder.for_wheels(base.count)
    if isinstance(base, Wheels):
        for index, joint in enumerate(base.joint):
            place = (float(base.x[index]), float(base.y[index]),
                     float(base.radius[index]) - height)
            _wheel(root, joint, body, place, float(base.axle[index]),
                   float(base.radius[index]), float(signs[index]))
    else:
        _carriers(root, base, body, height, signs)
    imu = prefix + robot.frames.imu_frame_id
    _link(root, imu)
    _joint(root, f'{imu}_joint', 'fixed', body, imu, tuple(float(v) for v in robot.imu.xyz),
           tuple(float(v) for v in robot.imu.rpy))
    Xml.indent(root)
    return '<?xml version="1.0"?>\n' + Xml.tostring(root, encoding='unicode') + '\n'


def _body_size(base: Wheels | Carriers) -> tuple[float, float]:
    reach_x, reach_y = (float(np.max(np.abs(v))) for v in (base.x, base.y))
    radius = float(np.mean(base.radius if isinstance(base, Wheels) else base.wheel_radius))
    return max(2.0 * reach_x, radius), max(2.0 * reach_y - radius, radius)


def _carriers(root: Xml.Element, base: Carriers, body: str, height: float,
              signs: np.ndarray) -> None:
    for index, name in enumerate(base.name):
        carrier = f'{name}_carrier_link'
        radius, half = float(base.wheel_radius[index]), float(base.half_track[index])
        offset = float(base.axle_offset[index])
        hinge = base.hinge_joint[index] or f'{name}_hinge_joint'
        link = _link(root, carrier)
        _visual(link, 'body', (offset / 2.0, 0.0, 0.0), (0.0, 0.0, 0.0), 'box',
                size=_numbers((abs(offset) + radius, half, radius / 2.0)))
        _joint(root, hinge, 'continuous', body, carrier,
               (float(base.x[index]), float(base.y[index]), radius - height),
               axis=(0.0, 0.0, 1.0))
        for side, joints in enumerate((base.left_joint, base.right_joint)):
            place = (offset, half if side == 0 else -half, 0.0)
            _wheel(root, joints[index], carrier, place, math.pi / 2, radius,
                   float(signs[2 * index + side]))


def _wheel(root: Xml.Element, joint: str, parent: str, place: Sequence[float], axle: float,
           radius: float, sign: float) -> None:
    link_name = re.sub(r'_joint$', '', joint) + '_link'
    link = _link(root, link_name)
    _visual(link, 'tyre', (0.0, 0.0, 0.0), (0.0, math.pi / 2, axle), 'cylinder',
            radius=_numbers((radius,)), length=_numbers((WHEEL_WIDTH * radius,)))
    _joint(root, joint, 'continuous', parent, link_name, place,
           axis=(sign * math.cos(axle), sign * math.sin(axle), 0.0))


def _link(root: Xml.Element, name: str) -> Xml.Element:
    return Xml.SubElement(root, 'link', name=name)


def _visual(link: Xml.Element, material: str, xyz: Sequence[float], rpy: Sequence[float],
            shape: str, **attributes: str) -> None:
    visual = Xml.SubElement(link, 'visual')
    Xml.SubElement(visual, 'origin', xyz=_numbers(xyz), rpy=_numbers(rpy))
    Xml.SubElement(Xml.SubElement(visual, 'geometry'), shape, attributes)
    Xml.SubElement(visual, 'material', name=material)


def _joint(root: Xml.Element, name: str, kind: str, parent: str, child: str,
           xyz: Sequence[float], rpy: Sequence[float] = (0.0, 0.0, 0.0),
           axis: Sequence[float] | None = None) -> None:
    joint = Xml.SubElement(root, 'joint', name=name, type=kind)
    Xml.SubElement(joint, 'origin', xyz=_numbers(xyz), rpy=_numbers(rpy))
    Xml.SubElement(joint, 'parent', link=parent)
    Xml.SubElement(joint, 'child', link=child)
    if axis is not None:
        Xml.SubElement(joint, 'axis', xyz=_numbers(axis))


def _numbers(values: Sequence[float]) -> str:
    return ' '.join(f'{round(v, 9) + 0.0:.9g}' for v in values)
