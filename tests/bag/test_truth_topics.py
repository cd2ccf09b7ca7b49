"""Every kind of pose topic serves as truth, for the analysis and for the calibration."""

import numpy as np
import pytest

from mecanum_base.bag.analysis.analyze import Options, analyze
from mecanum_base.bag.analysis.evidence import evidence_of
from mecanum_base.robot_file import load_robot, shipped

ROBOT = shipped() / 'mecanum4.yaml'
SPEED = 0.2  # m/s, of make.drive: 4 rad/s at 0.05 m


def transform(make, stamp, x, frame, child='base_link'):
    return make.T['geometry_msgs/msg/TransformStamped'](
        header=make.header(stamp, frame), child_frame_id=child,
        transform=make.T['geometry_msgs/msg/Transform'](
            translation=make.T['geometry_msgs/msg/Vector3'](x=float(x), y=0.0, z=0.0),
            rotation=make.quaternion(0.0)))


def truth(make, kind, stamp, x):
    """(topic, message) of the place x."""
    if kind == 'odometry':
        return '/ground_truth/odom', make.odometry(stamp, (x, 0.0, 0.0))
    if kind == 'pose':
        return '/vicon/robot', make.T['geometry_msgs/msg/PoseStamped'](
            header=make.header(stamp, 'map'), pose=make.T['geometry_msgs/msg/Pose'](
                position=make.T['geometry_msgs/msg/Point'](x=float(x), y=0.0, z=0.0),
                orientation=make.quaternion(0.0)))
    if kind == 'transform':
        return '/vrpn/robot', transform(make, stamp, x, 'map')
    parts = [transform(make, stamp, x, 'map'), transform(make, stamp, 3.0 * x, 'odom'),
             transform(make, stamp, 0.1, 'base_link', 'camera')]
    return '/tf', make.T['tf2_msgs/msg/TFMessage'](transforms=parts)


def recorded(tmp_path, make, kind):
    entries = make.drive(6.0)
    for i in range(300):
        stamp = make.T0 + i * 20 * make.MS
        topic, message = truth(make, kind, stamp, SPEED * i * 0.02 * 0.95)
        entries.append((topic, stamp + make.MS, message))
    return make.write_mcap(tmp_path / f'{kind}.mcap', sorted(entries, key=lambda e: e[1]))


@pytest.mark.parametrize('kind, options', [
    ('odometry', {}), ('pose', {}), ('transform', {}),
    ('tf', {'truth_topic': '/tf', 'truth_frame': 'map'})])
def test_the_drift_against_it_is_that_of_the_wheels(tmp_path, make, kind, options):
    """The wheels say 5 % more than the truth; over 1.2 m that is 6 cm."""
    path = recorded(tmp_path, make, kind)
    result = analyze(path, Options(str(ROBOT), **options))
    found = {d['name']: d for d in result['drift']}
    assert found['wheels only']['final'] == pytest.approx(0.05 * 6.0 * SPEED, abs=0.005)
    evidence = evidence_of(path, load_robot(ROBOT), **options)
    assert np.ptp(evidence.truth.pose[:, 0]) == pytest.approx(0.95 * 6.0 * SPEED, rel=0.01)


def test_of_tf_the_frame_that_was_asked_for_counts(tmp_path, make):
    path = recorded(tmp_path, make, 'tf')
    result = analyze(path, Options(str(ROBOT), truth_topic='/tf', truth_frame='odom'))
    found = {d['name']: d for d in result['drift']}
    # 3 x 0.95 of the way instead of 1
    assert found['wheels only']['final'] == pytest.approx((2.85 - 1.0) * 6.0 * SPEED,
                                                                rel=0.02)
