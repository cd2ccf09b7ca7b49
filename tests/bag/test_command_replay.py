"""Recorded wheel commands: a jammed wheel is named, and nothing else of a replay changes."""

import dataclasses
import json
import pathlib

import numpy as np
import pytest

import mecanum_base.bag.portion as portion
from mecanum_base.bag.analysis.analyze import Options, analyze
from mecanum_base.bag.replay import replay
from mecanum_base.bag.topics import Topics
from mecanum_base.cli.main import main
from mecanum_base.robot_file import load_robot, shipped

ROBOT = shipped() / 'mecanum4.yaml'
SCENARIO = '''
title: A wheel is blocked for a while
robot: mecanum4.yaml
duration: 3.5
seed: 20
driver:
  figure8: {length: 3.0, width: 1.5, speed: 0.5, spin: 0.2}
events:
  - {kind: jam, at: 1.5, for: 2.0, wheels: [1]}
'''


@pytest.fixture(scope='module')
def jammed(tmp_path_factory):
    """The scenario wheel_jam, shortened: front right is blocked from 1.5 to 3.5 s."""
    scenario = tmp_path_factory.mktemp('jam') / 'jam.yaml'
    scenario.write_text(SCENARIO, encoding='utf-8')
    folder = scenario.parent / 'run'
    assert main(['sim', '--robot', str(ROBOT), '--scenario', str(scenario), '--out',
                 str(folder)]) == 0
    return folder / 'bag'


def test_replay_and_analyze_name_the_jammed_wheel(jammed, tmp_path, capsys):
    assert main(['replay', str(jammed), '--robot', str(ROBOT), '--out', str(tmp_path)]) == 0
    begin = 'note: wheel front_right_wheel_joint does not follow its command: '
    line, = [ln for ln in capsys.readouterr().out.splitlines() if ln.startswith(begin)]
    summary = json.loads((tmp_path / 'summary.json').read_text())
    note, = [n for n in summary['notes'] if 'does not follow' in n]
    assert line == f'note: {note}'
    words = note.removeprefix(begin[6:]).split()
    # blocked for 2 s, but just after the start little is asked of the wheel; windows of 0.25 s
    assert 0.8 <= float(words[0]) <= 2.0
    assert 1.5 <= float(words[5]) <= 2.5
    assert summary['messages']['wheel_commands'] == {'read': 175, 'used': 175, 'rejected': {}}
    found = [f for f in analyze(str(jammed), Options(robot_file=str(ROBOT)))['findings']
             if f['code'] == 'wheel_not_following']
    assert len(found) == 1 and found[0]['severity'] == 'warning'
    assert found[0]['evidence'].startswith('front_right_wheel_joint ')


def test_commands_change_no_byte_of_the_track_and_no_row_taken_by_columns(
        jammed, tmp_path, monkeypatch):
    taken = {}

    def counted(*arguments):
        rows = original(*arguments)
        taken[name] = taken.get(name, 0) + (0 if rows is None else len(rows.stamp_ns))
        return rows

    original = portion.take
    monkeypatch.setattr(portion, 'take', counted)
    robot = load_robot(ROBOT)
    heard = Topics.of(robot)
    for name, topics in (('with', heard),
                         ('without', dataclasses.replace(heard, wheel_commands=None))):
        done = replay([str(jammed)], robot, tmp_path / name, topics)
        assert done.intake.command_watch.used == (175 if name == 'with' else 0)
    for file in ('track.csv', 'slip.csv', 'odometry.tum'):
        assert (tmp_path / 'with' / file).read_bytes() == (
            tmp_path / 'without' / file).read_bytes()
    assert taken['with'] == taken['without'] > 250


def rates_message(make, data):
    dim = make.T['std_msgs/msg/MultiArrayDimension'](label='wheel', size=len(data),
                                                     stride=len(data))
    return make.T['std_msgs/msg/Float64MultiArray'](
        layout=make.T['std_msgs/msg/MultiArrayLayout'](dim=[dim], data_offset=0),
        data=np.array(data, float))


def driven(make, command, seconds=2.0):
    """Recorded wheels that turn at 4 rad/s but for the rear left one, and ``command(stamp)``."""
    entries, end = [], make.T0 + round(seconds * 1e9)
    for stamp in range(make.T0, end, 20 * make.MS):
        angle = 4.0 * (stamp - make.T0) * 1e-9
        entries.append(('/joint_states', stamp, make.joint_state(
            stamp, [angle, angle, 0.0, angle])))
        entries.append(('/wheel_commands', stamp + make.MS, command(stamp)))
    return entries


@pytest.mark.parametrize('kind', ['named', 'unstamped', 'array', 'order', 'short', 'foreign'])
def test_every_form_of_command_is_read_as_the_live_node_reads_it(tmp_path, make, kind):
    wanted = [4.0, 4.0, 4.0, 4.0]

    def command(stamp):
        if kind in ('array', 'order'):
            return rates_message(make, wanted)
        if kind == 'short':
            return rates_message(make, wanted[:3])
        names = make.WHEELS if kind != 'foreign' else ('a', 'b', 'c', 'd')
        return make.joint_state(0 if kind == 'unstamped' else stamp, [], names, wanted)

    robot = load_robot(ROBOT)
    if kind == 'order':  # the first entry is for the rear left wheel, which need not turn
        wanted[0] = 0.0
        order = (robot.base.joint[2], *robot.base.joint[:2], robot.base.joint[3])
        robot = robot.replace(drive=dataclasses.replace(robot.drive, command_joints=order))
    path = make.write_mcap(tmp_path / 'a.mcap', driven(make, command))
    done = replay([str(path)], robot, tmp_path / 'out', Topics.of(robot))
    strayed = [joint for joint, _, _ in done.intake.command_watch.strayed]
    health = done.intake.health
    if kind == 'short':
        reason = 'wheel_commands has 3 entries instead of 4'
        assert health.rejected[('wheel_commands', reason)] == 100
        assert health.received['wheel_commands'] == 100
    else:
        assert not [key for key in health.rejected if key[0] == 'wheel_commands']
    assert done.reader.foreign == 0  # a count of encoder messages
    expected = ['rear_left_wheel_joint'] if kind in ('named', 'unstamped', 'array') else []
    assert strayed == expected
    assert bool([n for n in health.notes if 'does not follow' in n]) == bool(expected)
    assert health.used.get('wheel_commands', 0) == (0 if kind in ('short', 'foreign') else 100)


def test_commands_of_an_unknown_type_are_left_out_and_silent_ones_said_nothing_of(
        tmp_path, make):
    entries = [(topic, stamp, make.imu(stamp)) if topic == '/wheel_commands'
               else (topic, stamp, msg) for topic, stamp, msg in driven(make, lambda _: None, 1.0)]
    robot = load_robot(ROBOT)
    done = replay([str(make.write_mcap(tmp_path / 'a.mcap', entries))], robot, tmp_path / 'out',
                  Topics.of(robot))
    assert done.course.rows > 40 and done.reader.read['wheel_commands'] == 0
    assert not [note for note in done.intake.health.notes if 'command' in note]
    assert pathlib.Path(tmp_path / 'out' / 'track.csv').exists()
