"""Doctor against injected faults; the whole table: python tests/bag/doctor_table.py 20.

Drives last 30 s here, 50 s in the table.
"""

import re
import subprocess
import sys

import doctor_table as table
import driving
import numpy as np
import pytest
import yaml

from mecanum_base.bag.analysis import wiring_prices
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.robot import Robot
from mecanum_base.robot_file import load_robot, shipped


def judged(fault, seed, seconds=30.0, **more):
    """Result and verdict for a fault, or for one of the table's by name."""
    fault = table.FAULTS[fault] if isinstance(fault, str) else fault
    return table.judged_fault(fault, seed, seconds=seconds, **more)


@pytest.mark.parametrize('name', [name for name in table.FAULTS if name != 'reverse all'])
def test_each_fault_is_named_with_the_line_that_cures_it(name):
    result, verdict = judged(name, seed=11)
    assert result == 'found', verdict


@pytest.mark.parametrize('faults', [table.ORDERS, table.MOUNTS], ids=['orders', 'mountings'])
def test_orders_and_mountings_beside_those_of_the_table_are_found_too(faults):
    assert len(faults) == 23
    for index in (8, 18):
        result, verdict = judged(faults[index], seed=14)
        assert result == 'found', verdict


def base_like(name, seed):
    """(robot file, wheel angles (N, W), drive) of a shipped robot; wheels by G16, no slip along
    the roller on the ground: r sin(d) rate = -b . v of the wheel centre."""
    robot = load_robot(shipped() / f'{name}.yaml')
    made = driving.drive(seed=seed, seconds=30.0, creep=0.0)
    arm, radius = driving.LX + driving.LY, driving.RADIUS
    front_left, front_right, rear_left, _ = made.angle.T * radius
    way = np.array([(front_right + front_left) / 2.0, (rear_left - front_left) / 2.0,
                    (front_right - rear_left) / (2.0 * arm)])  # forward, left, ccw
    wheels = robot.base
    rates = [-(np.cos(a + d) * (way[0] - y * way[2]) + np.sin(a + d) * (way[1] + x * way[2]))
             / (r * np.sin(d)) for a, d, x, y, r in zip(wheels.axle, wheels.roller, wheels.x,
                                                        wheels.y, wheels.radius)]
    return robot, np.array(rates).T, made


@pytest.mark.parametrize('name, order', [('mecanum6', (5, 4, 2, 1, 3, 0)),
                                         ('swedish3', (1, 2, 0)), ('mixed', (2, 1, 0))])
def test_orders_of_three_and_six_wheels_are_found_too(name, order):
    robot, angle, made = base_like(name, seed=19)
    motion = table.WheelMotion(robot.base.joint, made.wheel_ns, angle[:, list(order)])
    gyro = table.Gyro(made.imu_ns, made.gyro, made.accel)
    found = table.examine(robot, motion, gyro).diagnoses
    names = ', '.join(robot.base.joint[i] for i in np.argsort(order))
    assert found[0].lines == (f'joint: [{names}]',) and found[0].certainty >= 0.9


def read_by(robot, raw):
    """Wheel angles as the robot file reads ``raw``: {joint: angle} or counts in columns [rad]."""
    _, sign = robot.encoder.for_wheels(4)
    columns = raw if robot.encoder.source == 'wheel_ticks' else np.column_stack(
        [raw[name] for name in robot.base.joint])
    return columns * sign


@pytest.mark.parametrize('source, order, signs', [
    ('joint_states', (1, 0, 2, 3), 'stay'), ('joint_states', (3, 0, 1, 2), 'move'),
    ('wheel_ticks', (1, 0, 2, 3), 'move'), ('wheel_ticks', (3, 0, 1, 2), 'stay')])
def test_the_lines_for_wheels_in_another_order_cure_a_file_with_mixed_signs(source, order, signs):
    """Motors of the right side count backwards; the signs of a file belong to places or to
    encoders, and counts come in the order of the columns, not by name."""
    sign = np.array([1, -1, 1, -1])
    block = yaml.safe_load(driving.YAML)['/**']['ros__parameters']
    block['encoder'] |= {'source': source, 'sign': sign.tolist()}
    robot = Robot.from_mapping(block)
    made = driving.drive(seed=23, seconds=30.0)
    place = np.array(order)  # column i shows the wheel at place order[i]
    raw = made.angle[:, place] * (sign[place] if signs == 'stay' else sign)
    if source == 'joint_states':
        raw = dict(zip(robot.base.joint, raw.T))
    gyro = table.Gyro(made.imu_ns, made.gyro, made.accel)

    def examined():
        return table.examine(robot, table.WheelMotion(driving.JOINTS, made.wheel_ns,
                                                      read_by(robot, raw)), gyro)
    found, = examined().diagnoses
    assert found.fault == 'swapped_wheels' and found.certainty >= 0.8
    for line in found.lines:
        (key, value), = yaml.safe_load(line).items()
        block['encoder' if key == 'sign' else 'wheels'][key] = value
    robot = Robot.from_mapping(block)
    right = body_from_wheels(wheels_from_body(table.ROBOT.base)) @ made.angle.T
    cured = body_from_wheels(wheels_from_body(robot.base)) @ read_by(robot, raw).T
    np.testing.assert_allclose(cured, right, atol=1e-5)  # lines have six digits
    assert not examined().diagnoses


def test_a_line_that_would_spoil_the_commands_says_so():
    swap = table.ORDERS[5]
    for commands, told in (('right', 'change the plugs or names of the encoders'),
                           ('along', 'wired alike'), ('', 'moves the commands too')):
        found, = judged(swap, seed=24, commands=commands)[1].diagnoses
        assert told in found.evidence, commands


def test_commands_alone_find_orders_and_signs_and_say_what_they_cannot_see():
    for fault in (table.ORDERS[5], table.ORDERS[-1], table.FAULTS['reverse one'],
                  table.FAULTS['mirrored rollers']):
        result, verdict = judged(fault, seed=25, imu=False, commands='right')
        assert result == 'found', verdict
        assert 'commands alone do not show' in verdict.missing[0]
    _, verdict = judged('counts of all x 4', seed=25, imu=False, commands='right')
    told = re.search('do ([0-9.]+) times what was asked', verdict.missing[1])
    assert not verdict.diagnoses and 3.5 < float(told[1]) < 4.1  # the drive lags, 0.25 s


@pytest.mark.parametrize('name', ['counts of all x 4', 'counts of all / 4', 'wheelbase wrong'])
def test_a_true_pose_alone_finds_wrong_scales(name):
    result, verdict = judged(name, seed=26, imu=False)
    assert result == 'found', verdict


def test_two_mistakes_at_once_are_both_named():
    result, verdict = judged((table.FAULTS['reverse one'], table.MOUNTS[3]), seed=15)
    assert result == 'found', verdict


def mistakes(order, sign, turn):
    """How many things are wrong: the order, encoders (or all but some), the mounting."""
    flips = sum(v < 0 for v in sign)
    return (order != (0, 1, 2, 3)) + min(flips, 1 + 4 - flips) + (turn != 0)


def test_no_wiring_of_two_mistakes_is_called_another_with_certainty():
    """All wirings of four wheels and an IMU turned by any right angle about z. The signals are
    the same where the IMU, seen from the wheels, is: (vx, vy) = R' F P rates, by hand."""
    forward = np.array([[1.0, 1, 1, 1], [-1, 1, 1, -1], [-1, 1, -1, 1]])
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    behind = wiring_prices.seen_from_behind(table.ROBOT.base)
    assert behind == (3, 2, 1, 0)
    alike = {}
    for order, sign, price, turned in wiring_prices.wheel_wirings(4, np.ones(4), behind):
        for quarters in range(4):
            turn = np.linalg.matrix_power(quarter, quarters)
            own, rest = wiring_prices.imu_prices(turn)
            place = np.zeros((4, 4))
            place[range(4), order] = sign
            signals = turn.T @ forward @ place
            cost = min(price + own, turned + rest)
            alike.setdefault(signals.astype(int).tobytes(), []).append(
                (cost, mistakes(order, sign, quarters)))
    assert len(alike) == 384 and {len(twins) for twins in alike.values()} == {4}
    doubtful = 0
    for twins in alike.values():
        weight = np.exp([-cost for cost, _ in twins])
        count = [wrong for _, wrong in twins]
        best = int(np.argmax(weight))
        sure = weight[best] / weight.sum() >= table.CERTAIN
        assert not sure or all(c > 2 for i, c in enumerate(count) if i != best)
        doubtful += min(count) == 1 and not sure
    assert doubtful == 3  # order, signs or IMU the wrong way round: nothing else that is single


@pytest.mark.parametrize('index, line', [(0, 'rpy: [0.0, 0.0, 3.14159]'),
                                         (1, 'rpy: [0.0, 0.0, 3.14159]'),
                                         (2, 'sign: [-1, -1, -1, -1]')])
def test_the_odd_one_of_three_that_tell_the_front_comes_first_and_is_not_certain(index, line):
    """Order, signs, IMU: one of them the wrong way round, or the two others by one mistake."""
    result, verdict = judged(table.FRONT[index], seed=14)
    assert result == 'likely', verdict
    assert 0.7 < verdict.diagnoses[0].certainty < 0.85
    assert verdict.unclear[0].startswith('20 %: ') and line in verdict.unclear[0]
    assert 'Turn by hand the wheel that sits 0.2 m ahead and 0.15 m to the left' in (
        verdict.missing[0])
    columns = [driving.JOINTS[i] for i in ((3, 0) if index == 1 else (0, 3))]
    assert (f'if {columns[0]} moves, what is named first is right, if {columns[1]} does, what '
            'comes next') in verdict.missing[0]


@pytest.mark.parametrize('pair', table.BEHIND)
def test_two_of_the_three_are_named_beside_what_looks_the_same(pair):
    result, verdict = judged(pair, seed=15)
    assert result == 'beside', verdict


def test_a_fault_that_is_certain_does_not_hide_what_another_looks_like():
    pair = (table.FRONT[0], table.FAULTS['accelerometer in g'])
    result, verdict = judged(pair, seed=15)
    assert result == 'likely' and verdict.diagnoses[0].fault == 'accel_in_g', verdict
    assert verdict.unclear[0].startswith('20 %: joint: [rear_right_wheel_joint')


@pytest.mark.parametrize('fault, witness', [
    (table.FRONT[0], dict(imu=False)), (table.FRONT[1], dict(commands='right')),
    (table.FRONT[2], dict(pose=True)), (table.BEHIND[1], dict(pose=True)),
    (table.BEHIND[2], dict(commands='right'))],
    ids=['pose alone', 'commands', 'pose', 'two, pose', 'two, commands'])
def test_who_knows_the_front_decides_it(fault, witness):
    """A true pose, or commands that the base follows."""
    result, verdict = judged(fault, seed=14, **witness)
    assert result == 'found', verdict


def test_commands_tell_nothing_where_the_motors_are_wired_like_the_encoders():
    for order, expected in ((table.ORDERS[-1], 'likely'), (table.ORDERS[5], 'found')):
        assert judged(order, seed=16, commands='along')[0] == expected
    assert not judged('none', seed=16, commands='right')[1].diagnoses


@pytest.mark.parametrize('index', [0, 12, 15])
def test_a_gyro_alone_makes_nothing_certain_that_another_order_explains_as_well(index):
    result, verdict = judged(table.ORDERS[index], seed=17, accelerometer=False)
    assert result in ('likely', 'beside')
    assert 'an accelerometer or a true pose' in verdict.missing[0]


def test_a_gyro_alone_says_what_it_cannot_see_on_a_sound_robot():
    _, verdict = judged('none', seed=18, accelerometer=False)
    joints = driving.JOINTS
    exchanged = ', '.join(joints[i] for i in (2, 3, 0, 1))
    assert not verdict.diagnoses
    assert [text for text in verdict.missing if f'the same: joint: [{exchanged}]' in text]
    assert not judged('none', seed=18)[1].missing


@pytest.mark.parametrize('name', ['only forward', 'standing still',
                                  'only forward, wheels swapped'])
def test_poor_motion_is_answered_with_the_manoeuvre_to_drive(name):
    _, verdict = judged(name, seed=12)
    assert not verdict.diagnoses
    assert 'drive' in verdict.missing[0]


@pytest.mark.parametrize('name', ['none', 'swap front left / front right', 'reverse one',
                                  'mirrored rollers'])
def test_a_true_pose_serves_where_there_is_no_imu(name):
    result, verdict = judged(name, seed=13, imu=False)
    assert result == 'found', verdict


def test_without_imu_commands_or_truth_it_says_that_it_cannot_tell():
    made = driving.drive(seed=1, seconds=30.0)
    motion = table.WheelMotion(driving.JOINTS, made.wheel_ns, made.angle)
    verdict = table.examine(table.ROBOT, motion, None)
    assert not verdict.diagnoses and 'neither an IMU' in verdict.missing[0]


@pytest.mark.parametrize('name', ['none', 'reverse one', 'imu quarter turn'])
def test_slip_and_noise_never_make_it_wrongly_certain(name):
    for seed in (21, 22):
        result, verdict = judged(name, seed=seed, slip=0.4, creep=0.05, gyro_noise=0.02,
                                       accel_noise=0.5)
        assert result != 'wrong', verdict


def drive_with(change, seed=5):
    """The verdict on a sound robot whose recording was changed."""
    made = driving.drive(seed=seed, seconds=30.0)
    change(made)
    motion = table.WheelMotion(driving.JOINTS, made.wheel_ns, made.angle)
    gyro = table.Gyro(made.imu_ns, made.gyro, made.accel)
    return table.examine(table.ROBOT, motion, gyro)


def test_a_sensor_that_hangs_for_a_while_is_no_evidence():
    def freeze(made):  # 12 s, most of it in motion
        made.gyro[2000:4400], made.accel[2000:4400] = made.gyro[2000], made.accel[2000]
    verdict = drive_with(freeze)
    assert not verdict.diagnoses and not verdict.missing


@pytest.mark.parametrize('name', ['noisy wheels', 'wheels in the air'])
def test_where_wheels_and_gyro_tell_nothing_of_each_other_no_fault_is_named(name):
    generator = np.random.default_rng(1)

    def change(made):
        if name == 'noisy wheels':
            made.angle += np.cumsum(generator.normal(size=made.angle.shape), axis=0)
        else:
            made.gyro = 0.003 * generator.normal(size=made.gyro.shape)
    verdict = drive_with(change)
    assert not verdict.diagnoses
    assert 'hardly tell the same motion' in verdict.missing[0]


def test_the_command_prints_the_corrected_line_and_exits_with_1(tmp_path, make):
    made = driving.drive(seed=3, seconds=18.0)
    made.angle = made.angle[:, [1, 0, 2, 3]]
    entries = [('/joint_states', int(s), make.joint_state(int(s), a))
               for s, a in zip(made.wheel_ns[::2], made.angle[::2])]
    entries += [('/imu/data_raw', int(s), make.imu(int(s), g, a))
                for s, g, a in zip(made.imu_ns[::2], made.gyro[::2], made.accel[::2])]
    path = make.write_mcap(tmp_path / 'a.mcap', sorted(entries, key=lambda e: e[1]))
    (tmp_path / 'robot.yaml').write_text(driving.YAML)
    done = subprocess.run([sys.executable, '-m', 'mecanum_base', 'doctor', path, '--robot',
                           str(tmp_path / 'robot.yaml')], capture_output=True, text=True,
                          timeout=60)
    assert done.returncode == 1, done.stderr
    assert 'joint: [front_right_wheel_joint, front_left_wheel_joint,' in done.stdout
    assert done.stderr == ''
