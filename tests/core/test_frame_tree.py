"""Mounts are found through any chain of links."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mecanum_base.core.estimation.sensors import ImuConfig
from mecanum_base.core.frame_tree import FrameTree


def quaternion(roll, pitch, yaw):
    return Rotation.from_euler('xyz', [roll, pitch, yaw]).as_quat()


def test_a_single_link_is_its_own_mount():
    tree = FrameTree()
    assert tree.add('base_link', 'imu_link', (1.0, 2.0, 3.0), quaternion(0.1, -0.2, 0.3))
    xyz, rpy = tree.between('base_link', 'imu_link')
    assert xyz.tolist() == [1.0, 2.0, 3.0]
    assert rpy == pytest.approx([0.1, -0.2, 0.3], abs=1e-12)


def test_chains_agree_with_an_independent_composition():
    rng = np.random.default_rng(1)
    for _ in range(50):
        tree, rotation, position = FrameTree(), Rotation.identity(), np.zeros(3)
        for level in range(4):
            angles, offset = rng.uniform(-1.5, 1.5, 3), rng.uniform(-1, 1, 3)
            tree.add(f'f{level}', f'f{level + 1}', offset, quaternion(*angles))
            position = position + rotation.apply(offset)
            rotation = rotation * Rotation.from_euler('xyz', angles)
        xyz, rpy = tree.between('f0', 'f4')
        assert xyz == pytest.approx(position, abs=1e-12)
        assert Rotation.from_euler('xyz', rpy).as_matrix() == pytest.approx(
            rotation.as_matrix(), abs=1e-12)


def test_the_matrix_of_the_imu_block_is_the_rotation_that_was_found():
    tree = FrameTree()
    tree.add('base_link', 'imu_link', (0.0, 0.0, 0.0), quaternion(0.4, 0.5, -2.0))
    _, rpy = tree.between('base_link', 'imu_link')
    assert ImuConfig(rpy=rpy).base_from_sensor() == pytest.approx(
        Rotation.from_euler('xyz', [0.4, 0.5, -2.0]).as_matrix(), abs=1e-12)


def test_frames_beside_each_other_are_connected_through_their_parent():
    tree = FrameTree()
    tree.add('footprint', 'base_link', (0.0, 0.0, 0.1), quaternion(0.0, 0.0, math.pi / 2))
    tree.add('footprint', 'imu_link', (1.0, 0.0, 0.1), (0.0, 0.0, 0.0, 1.0))
    xyz, rpy = tree.between('base_link', 'imu_link')
    assert xyz == pytest.approx([0.0, -1.0, 0.0], abs=1e-12)
    assert rpy == pytest.approx([0.0, 0.0, -math.pi / 2], abs=1e-12)


@pytest.mark.parametrize('pitch', [math.pi / 2, -math.pi / 2])
def test_a_sensor_on_its_nose_still_gives_the_right_rotation(pitch):
    tree = FrameTree()
    tree.add('a', 'b', (0.0, 0.0, 0.0), quaternion(0.3, pitch, 0.2))
    _, rpy = tree.between('a', 'b')
    assert Rotation.from_euler('xyz', rpy).as_matrix() == pytest.approx(
        Rotation.from_euler('xyz', [0.3, pitch, 0.2]).as_matrix(), abs=1e-7)


def test_unknown_frames_loops_and_slashes():
    tree = FrameTree()
    tree.add('/a', 'b', (1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    assert tree.between('a', '/b')[0].tolist() == [1.0, 0.0, 0.0]
    assert tree.between('a', 'c') is None
    tree.add('y', 'x', (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    tree.add('x', 'y', (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    assert tree.between('a', 'x') is None  # and it ends


def test_what_is_no_rigid_motion_is_not_learnt():
    tree = FrameTree()
    for xyz, turn in (((math.nan, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
                      ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 2.0)),
                      ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))):
        assert not tree.add('a', 'b', xyz, turn)
    assert tree.between('a', 'b') is None
