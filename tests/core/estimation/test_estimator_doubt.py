"""What an estimate doubts at its own stamp: silent encoders, given poses, resets."""

import numpy as np
import pytest
from staged_drive import MS, T0, estimator, frames, imu, merged, run, staged, wheel_angles

from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.records import PoseSample, ResetSample

MOTION = staged((0.6, (0, 0, 0)), (2.4, (0.4, 0.1, 0.4)), (0.7, (0, 0, 0)))
WHEELS, IMU = frames(MOTION, wheel_angles(MOTION)), imu(MOTION)
SAMPLES = merged(IMU, WHEELS)
AT = 1500


def in_order(samples, extra):
    return sorted([*samples, extra], key=lambda s: s.stamp_ns)


def without(samples, begin, end):
    return [s for s in samples if not T0 + begin * 1e9 <= s.stamp_ns < T0 + end * 1e9]


def at(found, ms):
    return min(found, key=lambda e: abs(e.stamp_ns - T0 - ms * MS))


def size(found, ms):
    return float(np.trace(at(found, ms).pose_covariance[:2, :2]))


def test_silent_encoders_are_predicted_with_growing_covariance():
    found = run(estimator(tuning=EstimatorConfig(min_rate=20.0)),
                merged(IMU, without(WHEELS, 1.5, 9.9)))
    sizes = [np.trace(e.pose_covariance[:2, :2]) for e in found if e.stamp_ns > T0 + 1.6e9]
    assert sizes == sorted(sizes)
    assert sizes[-1] > 4 * sizes[0]


def test_a_drop_out_of_the_encoders_is_doubted_while_it_lasts():
    found = run(estimator(), merged(IMU, without(WHEELS, 1.5, 2.1)))
    assert size(found, 2050) > 1.5 * size(found, 1480)
    assert size(found, 2200) < size(found, 2050)  # the first frame brings the whole way


def test_a_given_pose_has_its_covariance_at_its_stamp():
    pose = PoseSample(T0 + AT * MS, np.array([3.0, -1.0, 2.0]), np.diag([0.01, 0.02, 0.03]))
    found = run(estimator(), in_order(SAMPLES, pose))
    assert at(found, AT).pose_covariance.diagonal() == pytest.approx([0.01, 0.02, 0.03], rel=0.02)


def test_after_a_reset_the_pose_is_certain_again():
    found = run(estimator(), in_order(SAMPLES, ResetSample(T0 + AT * MS)))
    assert (at(found, AT).pose_covariance.diagonal()[:2] < 1e-6).all()


def test_a_reset_zeroes_the_slip_angles_at_its_stamp():
    slip = {1: (1.0, 1.3, 8.0)}
    samples = merged(IMU, frames(MOTION, wheel_angles(MOTION, slip=slip)))
    found = run(estimator(), in_order(samples, ResetSample(T0 + AT * MS)))
    assert np.abs(at(found, AT).slip.angle).max() < 0.1
