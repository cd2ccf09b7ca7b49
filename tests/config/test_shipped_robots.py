"""Every robot file in config/ is tested by existing."""

import math

import numpy as np
import pytest

from mecanum_base.cli.main import main
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.mobility import POOR, assess
from mecanum_base.core.kinematics.mounting import judge_mounting
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.platform import differential
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.robot_file import load_robot, shipped

FILES = sorted(path for path in shipped().glob('*.yaml')
               if 'ros__parameters' in path.read_text(encoding='utf-8')
               and ('wheels:' in path.read_text(encoding='utf-8')
                    or 'carriers:' in path.read_text(encoding='utf-8')))
REDUNDANCY = {'mecanum4': 1, 'mecanum6': 3, 'swedish3': 0, 'swedish4': 1, 'asymmetric': 1,
              'mixed': 0}


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
class TestShippedRobot:
    def test_it_loads_strictly_and_has_no_findings(self, path, capsys):
        assert main(['check', str(path), '--strict']) == 0
        assert 'findings: none' in capsys.readouterr().out

    def test_its_kinematics_are_sound_and_forward_undoes_inverse(self, path):
        base = load_robot(path).base
        twist = np.array([0.3, -0.2, 0.5])
        if isinstance(base, Carriers):
            for angle in ((0.0, 0.0), (1.2, -2.0)):
                rates = differential.wheels_from_body(base, np.array(angle)) @ twist
                np.testing.assert_allclose(
                    differential.body_from_wheels(base, np.array(angle)) @ rates, twist)
            return
        verdict = assess(base)
        assert verdict.rank == 3 and verdict.condition > 4 * POOR
        assert verdict.redundancy == REDUNDANCY.get(path.stem, base.count - 3)
        matrix = wheels_from_body(base)
        np.testing.assert_allclose(body_from_wheels(matrix) @ (matrix @ twist), twist)
        assert not judge_mounting(base).suspicious

    def test_its_limits_allow_at_least_walking_pace(self, path):
        base = load_robot(path).base
        if isinstance(base, Wheels):
            for direction in np.eye(3):
                rates = np.abs(wheels_from_body(base) @ direction)
                assert np.min(base.max_speed[rates > 0] / rates[rates > 0]) > 0.3

    def test_every_value_has_a_unit_or_a_word_beside_it(self, path):
        text = path.read_text(encoding='utf-8')
        assert text.startswith('#') and '[m]' in text and '[rad]' in text


def test_the_six_kinds_of_base_are_all_shipped():
    assert {path.stem for path in FILES} >= {*REDUNDANCY, 'dual_differential'}


def test_the_swedish_robots_have_swedish_wheels_and_the_asymmetric_one_is_not_symmetric():
    for name in ('swedish3', 'swedish4'):
        wheels = load_robot(shipped() / f'{name}.yaml').base
        np.testing.assert_allclose(np.abs(wheels.roller), math.pi / 2)
    wheels = load_robot(shipped() / 'asymmetric.yaml').base
    assert abs(np.sum(wheels.x)) > 0.01 and np.ptp(wheels.radius) > 0.001
    mixed = load_robot(shipped() / 'mixed.yaml').base
    assert np.ptp(np.abs(mixed.roller)) > 0.5 and np.ptp(mixed.axle) > 0.5
