"""The IMU's mounting from a drive; its coverage: python tests/bag/calibration_coverage.py 100."""

import math

import calibration_coverage as coverage
import driving
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mecanum_base.bag.analysis.calibrated_file import (
    calibrated_wheels,
    imu_keys,
    mounting,
    rewritten,
)
from mecanum_base.bag.analysis.calibration import Calibration
from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.evidence import Evidence
from mecanum_base.bag.analysis.fitted_value import Value
from mecanum_base.bag.analysis.imu_fit import mount_fit
from mecanum_base.bag.analysis.imu_mount import MountFit
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.robot import Robot
from mecanum_base.robot_file import parse_parameters


def robot(imu=''):
    return Robot.from_mapping(parse_parameters(driving.YAML + imu, 'test'))


def fit(file, true, wheel_factor=1.0, truth=False, seed=1, **options):
    """Mount fitted by a robot file with ``true`` (3, 3) base_from_sensor."""
    made = driving.drive(seed=seed, **{'seconds': 50.0, 'zero_g': (0.0, 0.0, 0.0), **options})
    driving.mount(made, true)
    evidence = Evidence(file, WheelMotion(driving.JOINTS, made.wheel_ns,
                                          made.angle * wheel_factor),
                        Gyro(made.imu_ns, made.gyro, made.accel),
                        Track(made.truth_ns, made.pose) if truth else None, None)
    return mount_fit([evidence], [0.0], coverage.MATRIX)


def apart(first, second):
    """Angle [rad] between two rotations."""
    return Rotation.from_matrix(first.T @ second).magnitude()


@pytest.mark.parametrize('slip', [0.0, 0.15])
def test_a_small_turn_is_found_on_top_of_the_mount_of_the_file(slip):
    file = robot('    imu: {rpy: [3.14159265, 0.0, 1.5707963], xyz: [0.1, -0.05, 0.0]}\n')
    turn = Rotation.from_euler('xyz', [1.5, -2.0, 6.0], degrees=True).as_matrix()
    true = turn @ file.imu.base_from_sensor()
    found = fit(file, true, slip=slip, place=(0.1, -0.05))
    assert all(found.turns[axis].given for axis in 'xyz')
    # no cross-axis error and no zero offset here: noise and creep leave less than 0.5 deg
    assert apart(found.applied(file.imu.base_from_sensor()), true) < math.radians(0.5)


@pytest.mark.parametrize('name', ['about x (roll)', 'about y (pitch)', 'about z (yaw)'])
def test_a_turn_that_the_motion_did_not_excite_is_refused_with_the_manoeuvre(name):
    found, _ = coverage.one(2, seconds=40.0, **coverage.UNEXCITED[name])
    value = next(v for v in found.mount.turns.values() if v.name == name)
    assert not value.given
    assert 'start and stop' in value.verdict or 'turn two times' in value.verdict


def test_a_quarter_turn_is_left_to_the_doctor():
    found = fit(robot(), Rotation.from_euler('z', 90, degrees=True).as_matrix())
    assert not found.turns['z'].given and 'doctor' in found.turns['z'].verdict


def test_an_accelerometer_without_gravity_leaves_the_level_to_the_turning_axis():
    made = driving.drive(seed=4, seconds=50.0)
    made.accel[:, 2] = 0.0
    evidence = Evidence(robot(), WheelMotion(driving.JOINTS, made.wheel_ns, made.angle),
                        Gyro(made.imu_ns, made.gyro, made.accel), None, None)
    found = mount_fit([evidence], [0.0], coverage.MATRIX)
    assert found.turns['x'].given and 'gravity' not in found.turns['x'].verdict


def test_an_accelerometer_without_a_gyro_still_tells_the_yaw():
    made = driving.drive(seed=4, seconds=50.0)
    driving.mount(made, Rotation.from_euler('z', 4, degrees=True).as_matrix())
    made.gyro[:] = np.nan
    evidence = Evidence(robot(), WheelMotion(driving.JOINTS, made.wheel_ns, made.angle),
                        Gyro(made.imu_ns, made.gyro, made.accel), None, None)
    found = mount_fit([evidence], [0.0], coverage.MATRIX)
    assert found.turns['z'].value == pytest.approx(math.radians(4), abs=math.radians(0.6))
    assert 'turn two times' in found.turns['x'].verdict


def test_the_true_pose_serves_where_the_wheels_do_not():
    turn = Rotation.from_euler('z', 5, degrees=True).as_matrix()
    alone = fit(robot(), turn, wheel_factor=0.5)
    assert not alone.turns['z'].given and 'of the acceleration' in alone.turns['z'].verdict
    found = fit(robot(), turn, wheel_factor=0.5, truth=True)
    assert 'true pose' in found.turns['z'].verdict
    assert found.turns['z'].value == pytest.approx(math.radians(5), abs=math.radians(0.6))


@pytest.mark.parametrize('imu', ['', '    imu:\n', '    imu: {}\n',
                                 '    imu: {xyz: [0.1, 0.0, 0.0]}\n',
                                 '    imu: {gyro_scale: 0.5, rpy: [0.0, 0.0, 0.0]}\n',
                                 '    imu:\n      xyz: [0.1, 0.0, 0.0]\n      gyro_scale: 1.25\n',
                                 '    imu:\n      # mine\n      rpy: [0.0, 0.0, 0.1]  # old\n',
                                 '    imu:\n      xyz: [0.1, 0.0, 0.0]\n'])
def test_the_turn_is_written_into_every_form_of_the_robot_file(imu):
    text = driving.YAML + imu
    old = robot('' if imu == '    imu:\n' else imu)
    found = Calibration('test')
    found.axes = {n: Value(n, None, None, None, '') for n in ('forward', 'sideways', 'turning')}
    found.mount = MountFit({'z': Value('z', 0.05, 0.04, 0.06, '')})
    found.constants = [Value('gyro scale', 1.02, 1.01, 1.03, '')]
    new = rewritten(text, 'test', calibrated_wheels(old.base, found), 'why',
                    imu_keys(found, old))
    again = Robot.from_mapping(parse_parameters(new, 'new'))
    true = Rotation.from_euler('z', 0.05).as_matrix() @ old.imu.base_from_sensor()
    assert apart(again.imu.base_from_sensor(), true) < 1e-7
    assert again.imu.xyz.tolist() == old.imu.xyz.tolist()
    assert again.imu.gyro_scale == pytest.approx(1.02 * old.imu.gyro_scale, abs=1e-6)
    assert ('# old' in new) == ('# old' in imu)


def test_a_mount_from_tf_is_told_not_written():
    found = Calibration('test')
    found.mount = MountFit({'z': Value('z', 0.05, 0.04, 0.06, '')})
    assert mounting(found, robot('    imu: {from_tf: true}\n')) is None
    assert '0.0500 rad' in found.notes[0]
    assert np.allclose(MountFit().applied(np.eye(3)), np.eye(3))
