"""The demo's stage: real rclpy nodes, stepped; a short drive instead of the lap."""

import hashlib
import re

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('rosbags')

from mecanum_base.cli.main import main
from mecanum_base.demo import experiment
from mecanum_base.demo.recording import read_result
from mecanum_base.demo.stage import perform, phases
from mecanum_base.demo.table import table
from mecanum_base.robot import Robot
from mecanum_base.robot_file import read_parameters, shipped
from mecanum_base.sim.scenario_file import load_scenario

SHORT = """
title: a short drive
duration: 2.0
seed: 5
driver:
  accel: [0.0, 0.0, 0.0]
  script:
    - {seconds: 0.3, twist: [0.0, 0.0, 0.0]}
    - {name: square, seconds: 0.7, twist: [0.3, 0.0, 0.0]}
    - {name: strafe, seconds: 0.7, twist: [0.0, 0.3, 0.0]}
    - {seconds: 0.3, twist: [0.0, 0.0, 0.0]}
"""


@pytest.fixture(autouse=True)
def _checked_fields(monkeypatch):
    monkeypatch.setenv('ROS_PYTHON_CHECK_FIELDS', '1')


def played(folder):
    path = folder / 'short.yaml'
    path.write_text(SHORT, encoding='utf-8')
    scenario = load_scenario(path)
    parameters = read_parameters(shipped() / scenario.robot)
    shares = []
    perform(scenario, path, parameters, folder / 'bag', shares.append)
    robot = Robot.from_mapping(parameters)
    return read_result(folder / 'bag', robot, scenario.name, phases(scenario)), shares


def digest(result):
    parts = [result.fused.stamp_ns, result.fused.pose, result.truth.pose, result.slip.probability]
    return hashlib.sha256(b''.join(np.ascontiguousarray(p).tobytes() for p in parts)).hexdigest()


def test_a_drive_over_topics_ends_where_the_truth_says_and_repeats_to_the_bit(tmp_path):
    for name in ('a', 'b'):
        (tmp_path / name).mkdir()
    result, shares = played(tmp_path / 'a')
    # 0.7 s at 0.3 m/s forward, then to the left: a tenth is left for ramps and latency
    assert result.truth.pose[-1, :2] == pytest.approx([0.21, 0.21], abs=0.021)
    assert result.fused_error.final_distance < 0.02
    assert result.wheel_only_error.final_distance < 0.02
    assert len(result.fused.stamp_ns) == pytest.approx(200, abs=3)  # 100 Hz encoders, 2 s
    assert [phase.name for phase in result.phases] == ['square', 'strafe']
    assert result.score.true == []
    assert shares[-1] == 1.0
    text = table(result)
    assert 'position error after strafe [m]' in text
    assert 'largest yaw in the translation-only square' in text
    again, _ = played(tmp_path / 'b')
    assert digest(again) == digest(result)


def test_the_command_writes_table_picture_and_page(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    pytest.importorskip('plotly')
    path = tmp_path / 'short.yaml'
    path.write_text('robot: mine.yaml\n' + SHORT.replace('duration: 2.0', 'duration: 1.2'),
                    encoding='utf-8')
    beside = tmp_path / 'mine.yaml'  # a robot file beside the scenario is found
    beside.write_text((shipped() / 'mecanum4.yaml').read_text(encoding='utf-8'), encoding='utf-8')
    out = tmp_path / 'out'
    assert main(['demo', '--scenario', str(path), '--out', str(out)]) == 0
    shown = capsys.readouterr()
    assert re.search(r'position error, RMS \[m\] +0\.0', shown.out)
    assert str(beside) in shown.out
    assert shown.err == ''  # no progress, no log in a pipe
    assert (out / 'demo.png').read_bytes().startswith(b'\x89PNG')
    page = (out / 'demo.html').read_text(encoding='utf-8')
    assert 'src="http' not in page and "src='http" not in page
    assert (out / 'bag_1' / 'metadata.yaml').is_file()


def test_the_scenarios_are_listed(capsys):
    assert main(['demo', '--list']) == 0
    names = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert {'lap', 'oil'} <= set(names)


CIRCLE = """
title: the experiment, shorter
duration: 3.1
seed: 5
"""


@pytest.mark.parametrize('robot', ['mecanum4.yaml', 'dual_differential.yaml'])
def test_circle_and_spin_is_followed_through_the_goal_node(tmp_path, capsys, monkeypatch, robot):
    monkeypatch.setattr(experiment, 'SETTLED', 2.5)  # the start from rest takes no longer
    path = tmp_path / 'circle_spin.yaml'
    path.write_text(CIRCLE, encoding='utf-8')
    words = ['demo', '--scenario', str(path), '--out', str(tmp_path / 'out'), '--headless',
             '--robot', str(shipped() / robot)]
    assert main(words) == 0
    shown = capsys.readouterr().out
    figures = {name: float(mean) for name, mean in
               re.findall(r'^    (\S.*?) {2,}mean +([0-9.]+)', shown, flags=re.M)}
    assert figures['through the nodes, our odometry'] < 40.0  # mm, the paper's error
    assert figures['bare law, true pose'] < 1.0
    assert figures['bare law, camera, no feed-forward'] > 40.0  # pure attraction lags
