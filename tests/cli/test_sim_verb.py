"""`mecanum sim`: headless runs into bags, listing, mistakes; the picture book."""

from __future__ import annotations

import gc
import pathlib

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from mecanum_base.cli.main import main
from mecanum_base.robot_file import load_robot


def simulate(folder: pathlib.Path, *more: str) -> int:
    return main(['sim', '--scenario', 'oil', '--out', str(folder), '--duration', '2.5', *more])


@pytest.fixture(scope='module')
def run_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp('sim') / 'run'
    assert simulate(folder) == 0
    return folder


def test_a_headless_run_writes_a_bag_with_every_topic_and_the_truth(run_folder):
    with AnyReader([run_folder / 'bag']) as reader:
        found = {c.topic: (c.msgtype, c.msgcount) for c in reader.connections}
        assert found == {
            '/joint_states': ('sensor_msgs/msg/JointState', 250),
            '/wheel_ticks': ('std_msgs/msg/Int64MultiArray', 250),
            '/imu/data_raw': ('sensor_msgs/msg/Imu', 500),
            '/wheel_commands': ('sensor_msgs/msg/JointState', 125),
            '/cmd_vel': ('geometry_msgs/msg/Twist', 125),
            '/ground_truth/odom': ('nav_msgs/msg/Odometry', 251),
            '/ground_truth/slip': ('sensor_msgs/msg/JointState', 251)}
        stamps = [t for _, t, _ in reader.messages()]
        assert stamps == sorted(stamps)
        odom = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages()
                if c.topic == '/ground_truth/odom']
    table = np.genfromtxt(run_folder / 'truth.csv', delimiter=',', names=True)
    assert odom[-1].pose.pose.position.x == table['x'][-1]
    assert odom[-1].header.frame_id == 'map' and odom[-1].child_frame_id == 'base_link'
    assert table['x'][-1] > 0.2  # it really drives
    tum = np.loadtxt(run_folder / 'truth.tum')
    assert tum.shape == (251, 8)
    assert load_robot(run_folder / 'robot.yaml').base.count == 4
    assert (run_folder / 'scenario.yaml').read_text(encoding='utf-8').startswith('title:')


def test_the_same_seed_gives_the_same_bytes(run_folder, tmp_path):
    assert simulate(tmp_path / 'run') == 0
    for name in ('bag/bag_0.mcap', 'bag/metadata.yaml', 'truth.csv', 'truth.tum'):
        assert (tmp_path / 'run' / name).read_bytes() == (run_folder / name).read_bytes(), name
    assert simulate(tmp_path / 'other', '--seed', '99') == 0
    assert ((tmp_path / 'other' / 'bag/bag_0.mcap').read_bytes()
            != (run_folder / 'bag/bag_0.mcap').read_bytes())


def test_a_run_is_written_as_it_goes_and_no_more_than_two_sections_are_kept(tmp_path):
    """A section is 2 s: 200 WheelSamples and 400 ImuSamples. Two hours in memory were 3 GB."""
    from mecanum_base.bag.simulated import write_run
    from mecanum_base.core.records import ImuSample, WheelSample
    from mecanum_base.robot_file import shipped
    from mecanum_base.sim.headless import Headless
    from mecanum_base.sim.scenario_file import load_scenario
    robot = load_robot(shipped() / 'mecanum4.yaml')
    headless = Headless(load_scenario('oil'), robot.base, robot.encoder, robot.imu, robot.sim,
                        duration=8.0)
    kept, size = [], []

    def alive():
        gc.collect()
        return sum(type(o) in (ImuSample, WheelSample) for o in gc.get_objects())

    before = alive()  # samples that other tests hold

    def look(share):
        if abs(share * 4.0 - round(share * 4.0)) < 1e-9:  # every 2 s
            kept.append(alive() - before)
            size.append((tmp_path / 'truth.csv').stat().st_size)

    count, last = write_run(headless, robot, tmp_path, look)
    assert count == 4001 and last.stamp_ns == headless.end_ns
    assert len(kept) == 4 and max(kept) <= 1300 < 3000
    assert 0.3 < size[1] / (tmp_path / 'truth.csv').stat().st_size < 0.6


def test_messages_carry_the_sign_of_the_hardware(tmp_path):
    from mecanum_base.robot_file import shipped
    text = (shipped() / 'mecanum4.yaml').read_text(encoding='utf-8')
    robot = tmp_path / 'signed.yaml'
    robot.write_text(text.replace('sign: [1, 1, 1, 1]', 'sign: [-1, 1, -1, 1]'), encoding='utf-8')
    assert simulate(tmp_path / 'run', '--robot', str(robot)) == 0
    with AnyReader([tmp_path / 'run' / 'bag']) as reader:
        found = {'/joint_states': [], '/wheel_commands': []}
        for connection, _, raw in reader.messages():
            if connection.topic in found:
                found[connection.topic].append(reader.deserialize(raw, connection.msgtype))
    moved = found['/joint_states'][-1].position - found['/joint_states'][0].position
    assert moved[0] < -1.0 and moved[1] > 1.0
    sent = found['/wheel_commands'][-1].velocity
    assert sent[0] < 0.0 < sent[1]


@pytest.mark.parametrize('words, text', [
    (['--scenario', 'oill', '--out', 'x'], "did you mean 'oil'"),
    (['--scenario', 'oil'], '--out: is missing'),
    (['--scenario', 'oil', '--out', 'x', '--duration', '-1'], 'must be > 0 [s]'),
    (['--scenario', 'oil', '--out', 'x', '--seed', '-1'], 'must be >= 0'),
    (['--out', 'x'], 'needs --scenario'),
    (['--scenario', 'oil', '--out', 'x', '--robot', 'missing.yaml'], 'cannot be read'),
    (['--scenario', 'oil', '--out', 'x', '--speed', '2'], 'no option of a headless run'),
])
def test_wrong_usage_is_one_line_and_exit_code_2(words, text, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(['sim', *words]) == 2
    out, error = capsys.readouterr()
    assert out == '' and error.count('\n') == 1
    assert text in error
    assert not (tmp_path / 'x').exists()


def test_an_own_scenario_brings_its_own_robot(tmp_path, capsys):
    from mecanum_base.robot_file import shipped
    text = (shipped() / 'mecanum4.yaml').read_text(encoding='utf-8')
    (tmp_path / 'mine.yaml').write_text(text.replace('front_left', 'vorn_links'), encoding='utf-8')
    (tmp_path / 'test.yaml').write_text('robot: mine.yaml\nduration: 0.2\n', encoding='utf-8')
    assert main(['sim', '--scenario', str(tmp_path / 'test.yaml'), '--out',
                 str(tmp_path / 'run')]) == 0
    assert 'test, seed 1: 0.2 s' in capsys.readouterr().out
    head = (tmp_path / 'run' / 'truth.csv').read_text(encoding='utf-8').splitlines()[0]
    assert 'vorn_links_wheel_joint.slip_rate' in head


def test_a_folder_that_holds_something_is_not_overwritten(run_folder, capsys):
    assert simulate(run_folder) == 2
    assert 'not overwritten' in capsys.readouterr().err


def test_the_list_names_every_scenario_with_its_length(capsys):
    assert main(['sim', '--list']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith('warehouse') and '600 s' in line for line in lines)
    assert len(lines) >= 16


def test_keys_explains_every_key_and_kind_of_event(capsys):
    from mecanum_base.sim.faults import KINDS
    assert main(['sim', '--keys']) == 0
    text = capsys.readouterr().out
    for word in ('duration', 'patches', 'grade', 'seconds', 'turn_speed', 'creep_stiffness',
                 '[kg]', 'needed', *KINDS):
        assert word in text, word
    assert max(map(len, text.splitlines())) < 100


def test_the_gallery_draws_a_scenario_into_one_page(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    assert main(['sim', '--gallery', '--scenario', 'collision', '--duration', '6',
                 '--out', str(tmp_path / 'g')]) == 0
    page = (tmp_path / 'g' / 'gallery.html').read_text(encoding='utf-8')
    assert page.count('data:image/png;base64,') == 1
    assert 'collision' in page and 'http' not in page
    picture = (tmp_path / 'g' / 'collision.png').read_bytes()
    assert picture.startswith(b'\x89PNG') and len(picture) > 20_000
