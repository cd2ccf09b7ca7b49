"""Bad data: every reason to reject fires, every gap is bridged, nothing unsound comes out."""

import math

import numpy as np
import pytest
from staged_drive import (
    MS,
    T0,
    estimator,
    frames,
    imu,
    is_sound,
    merged,
    miss,
    run,
    staged,
    wheel_angles,
)

from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.records import (
    CommandSample,
    ImuSample,
    PoseSample,
    ResetSample,
    TickSample,
    WheelSample,
)

BLANK = np.full(4, math.nan)
MOTION = staged((0.6, (0, 0, 0)), (2.4, (0.4, 0.1, 0.4)), (0.7, (0, 0, 0)))
WHEELS, IMU = frames(MOTION, wheel_angles(MOTION)), imu(MOTION)
GRAVITY = np.array([0.0, 0.0, 9.81])


def without(samples, begin, end):
    return [s for s in samples if not T0 + begin * 1e9 <= s.stamp_ns < T0 + end * 1e9]


def wheel(ms, angle=0.0):
    return WheelSample(T0 + round(ms * MS), np.full(4, angle), BLANK)


def still(ms, gyro=0.0, accel=GRAVITY):
    return ImuSample(T0 + round(ms * MS), np.array([0.0, 0.0, gyro]), np.array(accel))


def resting(count=6):
    return merged([still(5 * k) for k in range(2 * count)], [wheel(10 * k) for k in range(count)])


BAD = [
    ('joint_states', 'late', wheel(1)),
    ('joint_states', 'duplicate stamp', wheel(50)),
    ('joint_states', 'no finite wheel reading', WheelSample(T0 + 62 * MS, BLANK, BLANK)),
    ('joint_states', 'wrong number of wheels', WheelSample(T0 + 62 * MS, np.zeros(3),
                                                           np.zeros(3))),
    ('wheel_ticks', 'duplicate stamp', TickSample(T0 + 50 * MS, np.zeros(4, dtype=np.int64))),
    ('wheel_ticks', 'wrong number of wheels', TickSample(T0 + 62 * MS,
                                                         np.zeros(5, dtype=np.int64))),
    ('imu', 'late', still(2)),
    ('imu', 'duplicate stamp', still(55)),
    ('imu', 'not a number', ImuSample(T0 + 62 * MS, np.full(3, math.nan), np.full(3, math.nan))),
    ('imu', 'gyro out of range', still(62, gyro=500.0)),
    ('imu', 'gyro out of range', still(62, gyro=math.inf)),
    ('set_pose', 'late', PoseSample(T0, np.zeros(3), np.eye(3))),
    ('set_pose', 'not a number', PoseSample(T0 + 62 * MS, np.array([math.nan, 0, 0]), np.eye(3))),
    ('set_pose', 'not a number', PoseSample(T0 + 62 * MS, np.zeros(3), np.full((3, 3), math.inf))),
    ('set_pose', 'covariance not positive', PoseSample(T0 + 62 * MS, np.zeros(3), -np.eye(3))),
    ('odometry_reset', 'late', ResetSample(T0)),
    ('wheel_commands', 'late', CommandSample(T0, np.zeros(4))),
]


@pytest.mark.parametrize(('stream', 'reason', 'bad'), BAD, ids=[f'{s}: {r}' for s, r, _ in BAD])
def test_a_bad_sample_is_rejected_once_for_its_reason_and_leaves_no_trace(stream, reason, bad):
    subject = estimator()
    found = run(subject, [*resting(), bad])
    found += run(subject, [still(65), wheel(70), still(75), wheel(80)])
    assert subject.health.rejected == {(stream, reason): 1}
    assert all(map(is_sound, found))
    assert np.abs(found[-1].pose).max() < 1e-3


def test_a_lone_stamp_far_ahead_is_dropped_and_counted_when_a_second_one_disagrees():
    subject = estimator()
    for sample in [*resting(), wheel(3_600_000), wheel(7_200_000), still(65), wheel(70)]:
        subject.handle(sample)
    assert subject.health.rejected == {('joint_states', 'stamp far ahead'): 1}


def test_a_message_refused_at_the_border_is_counted_as_received_and_rejected():
    subject = estimator()
    subject.reject('joint_states', 'joint named twice')
    assert subject.health.rejected == {('joint_states', 'joint named twice'): 1}
    assert subject.health.received['joint_states'] == 1
    assert 'joint_states' not in subject.health.used


def test_received_is_used_and_rejected_together_on_every_stream():
    subject = estimator()
    run(subject, [*resting(), *(bad for *_, bad in BAD[:3]), *(bad for *_, bad in BAD[7:10])])
    health = subject.health
    for stream, count in health.received.items():
        rejected = sum(n for (name, _), n in health.rejected.items() if name == stream)
        assert count == health.used.get(stream, 0) + rejected


@pytest.mark.parametrize('field', ['gyro', 'accel'])
def test_an_imu_axis_that_is_no_number_for_a_while_costs_little(field):
    samples = []
    for s in IMU:
        hit = 1.5e9 <= s.stamp_ns - T0 < 2.0e9
        gone = np.full(3, math.nan)
        samples.append(ImuSample(s.stamp_ns, gone if hit and field == 'gyro' else s.gyro,
                                 gone if hit and field == 'accel' else s.accel))
    subject = estimator()
    found = run(subject, merged(samples, WHEELS))
    assert miss(found[-1], MOTION)[0] < 0.008
    assert miss(found[-1], MOTION)[1] < math.radians(0.6)
    assert all(map(is_sound, found))


def test_an_absurd_acceleration_is_left_out_while_its_gyro_is_used():
    samples = [ImuSample(s.stamp_ns, s.gyro, s.accel * (1e6 if k % 37 == 5 else 1.0)
                         + np.array([1e5 if k % 37 == 5 else 0.0, 0.0, 0.0]))
               for k, s in enumerate(IMU)]
    subject = estimator()
    found = run(subject, merged(samples, WHEELS))
    assert miss(found[-1], MOTION)[0] < 0.01
    assert subject.health.used['imu'] == len(IMU)


def test_silent_encoders_are_predicted_through_at_min_rate():
    subject = estimator(tuning=EstimatorConfig(min_rate=20.0))
    found = run(subject, merged(IMU, without(WHEELS, 1.5, 9.9)))
    gap = [e for e in found if e.stamp_ns > T0 + 1.6e9]
    assert {e.source for e in gap} == {'predicted'}
    step = np.diff([e.stamp_ns for e in gap])
    assert (step == 50 * MS).all()  # 20 Hz of data time, IMU stamps fall on it
    # 2.2 s on an accelerometer with 0.1 m/s^2 of bias not yet known: 0.05 * 2.2^2
    assert miss(gap[-1], MOTION)[0] < 0.25
    assert all(map(is_sound, found))


def test_without_a_single_encoder_sample_nothing_is_published():
    assert run(estimator(), IMU) == []


def test_a_drop_out_of_the_encoders_keeps_the_way():
    found = run(estimator(), merged(IMU, without(WHEELS, 1.5, 2.1)))
    assert miss(found[-1], MOTION)[0] < 0.005


def test_without_an_imu_a_drop_out_is_made_up_for_by_the_next_frame():
    motion = staged((0.3, (0, 0, 0)), (2.2, (0.4, 0.2, 0)), (0.7, (0, 0, 0)))
    samples = without(frames(motion, wheel_angles(motion)), 1.2, 1.6)
    found = run(estimator(), samples)
    assert miss(found[-1], motion)[0] < 0.008


def test_an_imu_gap_is_bridged_by_the_wheels_and_its_silence_is_named_while_it_lasts():
    subject = estimator()
    early = [s for s in merged(without(IMU, 1.5, 2.1), WHEELS) if s.stamp_ns < T0 + 2.08e9]
    late = [s for s in merged(without(IMU, 1.5, 2.1), WHEELS) if s.stamp_ns >= T0 + 2.08e9]
    found = []
    for sample in early:
        found.extend(subject.handle(sample))
    assert subject.health.imu == 'lost'
    assert any('IMU has fallen silent' in note for note in subject.health.notes)
    found += run(subject, late)
    assert subject.health.imu == 'gyro + accelerometer'
    assert miss(found[-1], MOTION)[0] < 0.006
    assert miss(found[-1], MOTION)[1] < math.radians(0.5)


def test_a_counter_jump_in_mid_drive_costs_no_more_than_one_wheel_for_one_frame():
    angles = wheel_angles(MOTION)
    angles[1800:, 2] += 500.0
    subject = estimator()
    found = run(subject, merged(IMU, frames(MOTION, angles)))
    assert subject.health.rejected == {('joint_states', 'implausible wheel jump'): 1}
    assert miss(found[-1], MOTION)[0] < 0.006


def test_a_silence_of_all_streams_beyond_five_seconds_adds_a_metre_of_doubt_and_keeps_the_pose():
    subject = estimator()
    found = run(subject, merged(IMU, WHEELS))
    before, end = found[-1], len(MOTION.t)
    angle = WHEELS[-1].position
    later = [WheelSample(T0 + (end + 9000 + 10 * k) * MS, angle, BLANK) for k in range(20)]
    after = run(subject, later)[-1]
    assert after.pose == pytest.approx(before.pose, abs=1e-3)
    assert after.pose_covariance[0, 0] > 0.9
    assert subject.health.restarts == 1


def test_stamps_that_go_back_for_good_restart_the_estimator_at_its_last_pose():
    subject = estimator()
    before = run(subject, merged(IMU, WHEELS))[-1]
    back = [WheelSample(s.stamp_ns - 100_000_000_000, WHEELS[-1].position, BLANK)
            for s in WHEELS[:40]]
    after = run(subject, back)
    assert subject.health.restarts == 1
    assert after[-1].stamp_ns == back[-1].stamp_ns
    assert after[-1].pose == pytest.approx(before.pose, abs=1e-3)
    assert all(map(is_sound, after))


def test_some_old_stamps_among_good_ones_are_late_and_nothing_else():
    samples = merged(IMU, WHEELS)
    mixed = [s for k, good in enumerate(samples) for s in
             ((good, wheel(-5000)) if k % 50 == 49 else (good,))]
    subject = estimator()
    found = run(subject, mixed)
    assert subject.health.rejected == {('joint_states', 'late'): len(samples) // 50}
    assert subject.health.restarts == 0
    assert miss(found[-1], MOTION)[0] < 0.005


def test_stamps_that_start_at_zero_are_as_good_as_any():
    zero = [WheelSample(s.stamp_ns - T0, s.position, s.velocity) for s in WHEELS[:150]]
    same = [ImuSample(s.stamp_ns - T0, s.gyro, s.accel) for s in IMU[:300]]
    one = run(estimator(), merged(same, zero))
    two = run(estimator(), merged(IMU[:300], WHEELS[:150]))
    assert [e.stamp_ns + T0 for e in one] == [e.stamp_ns for e in two]
    # 1e-9: seconds as floats are coarser at today's stamps
    assert one[-1].pose == pytest.approx(two[-1].pose, abs=1e-9)


def test_a_counter_jump_is_a_fault_and_no_slip():
    motion = staged((0.6, (0, 0, 0)), (2.4, (0.4, 0.1, 0.4)), (0.7, (0, 0, 0)))
    angles = wheel_angles(motion)
    angles[1800:, 2] += 500.0
    subject = estimator()
    found = run(subject, merged(imu(motion), frames(motion, angles)))
    assert subject.episodes == ()
    assert miss(found[-1], motion)[0] < 0.01


def test_a_doubtful_stamp_that_the_end_of_the_data_drops_is_counted_too():
    subject = estimator()
    still = frames(staged((0.1, (0, 0, 0))), np.zeros((101, 4)))
    far = WheelSample(T0 + 3600 * 1000 * MS, np.zeros(4), np.full(4, math.nan))
    run(subject, [*still, far])
    health = subject.health
    assert health.rejected == {('joint_states', 'stamp far ahead'): 1}
    assert health.used['joint_states'] + 1 == health.received['joint_states']


@pytest.mark.parametrize('place', [(3, 3), (21, 21)], ids=['velocity', 'travel'])
def test_numbers_that_stop_being_finite_are_started_anew_at_the_last_pose(place):
    subject = estimator()
    samples = merged(IMU, WHEELS)
    before = run(subject, samples[:400])  # estimates up to 1.3 s: it drives
    subject._filter.memory.P[place] = math.nan
    after = run(subject, samples[400:])
    assert all(is_sound(estimate) for estimate in after)
    jump = after[2].pose[:2] - before[-1].pose[:2]
    assert np.hypot(*jump) < 0.1  # some frames at 0.4 m/s
    assert after[2].pose_covariance[0, 0] > 0.5  # a metre of doubt
