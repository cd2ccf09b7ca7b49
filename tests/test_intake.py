"""Messages become samples; poses, resets and the IMU mount are applied by the data's own time."""

import math
import random
from types import SimpleNamespace as Made

import numpy as np
import pytest

from mecanum_base import robot_file
from mecanum_base.core.estimation.sensors import ImuConfig
from mecanum_base.core.records import ImuSample, PoseSample, ResetSample, WheelSample
from mecanum_base.intake import Intake
from mecanum_base.robot import Robot

START = 1_000_000_000_000
STEP = 10_000_000  # ns
WAIT = 20_000_000  # ns, estimator.reorder_wait


@pytest.fixture(scope='module')
def mapping():
    return robot_file.read_parameters(robot_file.shipped() / 'mecanum4.yaml')


@pytest.fixture
def robot(mapping):
    return Robot.from_mapping(mapping)


@pytest.fixture
def from_tf(mapping):
    return Robot.from_mapping({**mapping, 'imu': {'from_tf': True}})


def wheels(index, speed=0.0):
    angle = speed * index * STEP * 1e-9 / 0.05
    return WheelSample(START + index * STEP, np.full(4, angle), np.full(4, math.nan))


def imu(index, shift=0):
    return ImuSample(START + index * STEP + shift, np.zeros(3), np.array([0.0, 0.0, 9.81]))


def pose(stamp, x=3.0, frame='odom'):
    return PoseSample(stamp, np.array([x, 0.0, 0.0]), np.eye(3) * 1e-4, frame)


def run(intake, count=60, extra=()):
    """Feed standstill data; ``extra`` are (index, sample) that arrive behind sample ``index``."""
    found = []
    for index in range(count):
        for sample in (imu(index, -STEP // 2), imu(index), wheels(index)):
            found += intake.handle(sample)
        for at, sample in extra:
            if at == index:
                found += intake.handle(sample)
    return [*found, *intake.flush()]


def jump_of(estimates):
    """Stamp of the first estimate beyond x = 1 m."""
    return next((e.stamp_ns for e in estimates if e.pose[0] > 1.0), None)


def test_a_pose_acts_at_its_stamp_wherever_it_arrives(robot):
    stamp = START + 30 * STEP + 3_000_000
    for arrives in (20, 29, 30, 31):
        estimates = run(Intake(robot), extra=[(arrives, pose(stamp))])
        assert jump_of(estimates) == START + 31 * STEP


def test_stamp_zero_means_the_newest_sensor_stamp(robot):
    # a pose is taken before the encoder sample of the same stamp
    assert jump_of(run(Intake(robot), extra=[(30, pose(0))])) == START + 30 * STEP


def test_a_pose_without_stamp_before_all_data_is_where_the_track_begins(robot):
    intake = Intake(robot)
    assert intake.handle(pose(0)) == ()
    estimates = run(intake)
    assert estimates[0].pose[0] == pytest.approx(3.0, abs=1e-3)


def test_a_pose_far_ahead_waits_and_makes_no_sample_late(robot):
    intake = Intake(robot)
    estimates = run(intake, extra=[(10, pose(START + 50 * STEP)), (11, pose(START + 10**15))])
    assert jump_of(estimates) == START + 50 * STEP
    assert intake.estimator.health.rejected == {}


def test_a_late_pose_is_counted_and_not_applied(robot):
    intake = Intake(robot)
    late = START + 30 * STEP - WAIT - 1
    assert jump_of(run(intake, extra=[(30, pose(late))])) is None
    assert intake.estimator.health.rejected == {('set_pose', 'late'): 1}


def test_a_reset_acts_at_its_stamp(robot):
    estimates = run(Intake(robot), extra=[(10, pose(START + 10 * STEP)),
                                          (30, ResetSample(START + 30 * STEP))])
    beyond = [e.stamp_ns for e in estimates if e.pose[0] > 1.0]
    assert (beyond[0], beyond[-1]) == (START + 10 * STEP, START + 29 * STEP)


@pytest.mark.parametrize('frame,taken', [('odom', True), ('', True), ('map', False)])
def test_a_pose_of_another_frame_is_refused(robot, frame, taken):
    intake = Intake(robot)
    estimates = run(intake, extra=[(30, pose(START + 30 * STEP, frame=frame))])
    assert (jump_of(estimates) is not None) == taken
    assert (('set_pose', "in frame 'map' instead of 'odom'")
            in intake.estimator.health.rejected) == (not taken)


def test_many_poses_ahead_do_not_pile_up(robot):
    intake = Intake(robot)
    run(intake, extra=[(10, pose(START + 10**15 + i)) for i in range(1000)])
    assert len(intake._ahead) < 100


def test_malformed_messages_are_counted_and_give_nothing(robot):
    intake = Intake(robot)
    names = list(robot.base.joint)
    header = Made(stamp=Made(sec=1000, nanosec=0), frame_id='')
    assert intake.joint_states(Made(header=header, name=names, position=[0.0], velocity=[])) == ()
    assert intake.wheel_ticks(Made(data=[1]), START) == ()
    assert intake.joint_states(Made(header=header, name=['arm'], position=[0.0],
                                    velocity=[])) == ()
    assert intake.estimator.health.rejected == {
        ('joint_states', 'array length differs from name'): 1,
        ('wheel_ticks', 'wheel_ticks length differs from wheels'): 1}


# --- IMU mount ----------------------------------------------------------------------------------

def test_samples_wait_for_the_mount_and_none_is_lost(robot, from_tf):
    intake = Intake(from_tf)
    early = []
    for index in range(30):
        for sample in (imu(index), wheels(index)):
            early += intake.handle(sample)
    assert early == [] and not intake.mount_known
    found = list(intake.static_transform('base_link', 'imu_link', (0.1, 0.2, 0.3),
                                         (0.0, 0.0, 0.0, 1.0)))
    for index in range(30, 60):
        for sample in (imu(index), wheels(index)):
            found += intake.handle(sample)
    found += intake.flush()
    plain = Intake(robot.replace(imu=intake.robot.imu))
    expected = []
    for index in range(60):
        for sample in (imu(index), wheels(index)):
            expected += plain.handle(sample)
    expected += plain.flush()
    assert intake.robot.imu.xyz.tolist() == [0.1, 0.2, 0.3]
    assert [(e.stamp_ns, e.pose.tolist()) for e in found] == [
        (e.stamp_ns, e.pose.tolist()) for e in expected]


def test_without_the_mount_the_wheels_alone_go_on_after_the_wait(from_tf, monkeypatch):
    monkeypatch.setattr('mecanum_base.intake.MOUNT_WAIT', 0.5)
    intake = Intake(from_tf)
    estimates = run(intake, count=70)
    assert len(estimates) > 60
    assert intake.estimator.health.used.get('imu', 0) == 0
    assert intake.estimator.health.rejected[('imu', 'mount unknown: not on tf_static')] > 120


def test_a_mount_that_comes_late_is_used_from_the_last_pose_on(from_tf, monkeypatch):
    monkeypatch.setattr('mecanum_base.intake.MOUNT_WAIT', 0.5)
    intake = Intake(from_tf)
    before = run(intake, count=70, extra=[(60, pose(START + 60 * STEP))])
    intake.static_transform('base_link', 'imu_link', (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    after = []
    for index in range(71, 110):
        for sample in (imu(index), wheels(index)):
            after += intake.handle(sample)
    assert before[-1].pose[0] == pytest.approx(3.0, abs=1e-3)
    assert after[0].pose[0] == pytest.approx(3.0, abs=1e-3)
    assert intake.estimator.health.used['imu'] > 30


def test_the_smoothed_past_goes_on_over_a_mount_that_comes_late(from_tf, monkeypatch):
    monkeypatch.setattr('mecanum_base.intake.MOUNT_WAIT', 0.5)
    intake = Intake(from_tf, smoothed=True)
    found = run(intake, count=70)
    intake.static_transform('base_link', 'imu_link', (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    for index in range(71, 110):
        found += intake.handle(wheels(index))
    found += intake.flush()
    past = [int(stamp) for part in intake.past(last=True) for stamp in part.smoothed().stamp_ns]
    assert past == [e.stamp_ns for e in found if e.source == 'encoder']


def test_a_bag_that_never_tells_the_mount_is_still_replayed(from_tf):
    assert len(run(Intake(from_tf), count=100)) > 90


def test_links_that_are_no_rigid_motion_are_not_learnt(from_tf):
    intake = Intake(from_tf)
    for quaternion in ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, math.nan), (1.0, 1.0, 1.0, 1.0)):
        intake.static_transform('base_link', 'imu_link', (0.0, 0.0, 0.0), quaternion)
        assert not intake.mount_known


# --- clocks -------------------------------------------------------------------------------------

@pytest.mark.parametrize('silence,doubt', [(3.0, 0.5), (3600.0, 1.2), (50 * 365 * 86400.0, 1.2)])
def test_a_silence_of_any_length_keeps_the_pose_finite_and_near(robot, silence, doubt):
    """From a pulled plug to a robot without a battery-backed clock that boots in 1970."""
    intake = Intake(robot)
    found = run(intake, count=100)
    late = round(silence * 1e9)
    for index in range(100, 160):
        for sample in (imu(index, late), wheels(index)):
            if isinstance(sample, WheelSample):
                sample = WheelSample(sample.stamp_ns + late, sample.position, sample.velocity)
            found += intake.handle(sample)
    last = found[-1]
    assert len(found) < 200
    assert np.all(np.abs(last.pose) < 0.05)  # it stood all the time
    assert np.sqrt(last.pose_covariance[0, 0]) < doubt


def test_a_clock_set_back_by_hours_goes_on_from_the_last_pose(robot):
    intake = Intake(robot)
    run(intake, count=60, extra=[(30, pose(START + 30 * STEP))])
    early = -3600 * 10**9
    found = []
    for index in range(60, 120):
        moved = wheels(index)
        found += intake.handle(imu(index, early))
        found += intake.handle(WheelSample(moved.stamp_ns + early, moved.position,
                                           moved.velocity))
    assert intake.estimator.health.restarts == 1
    assert found[-1].pose[0] == pytest.approx(3.0, abs=0.01)
    assert found[-1].stamp_ns < START


# --- late stamps --------------------------------------------------------------------------------

@pytest.mark.parametrize('late', [0.0123456789, -0.2])
def test_messages_of_an_imu_are_read_as_much_earlier_as_they_are_stamped_late(mapping, late):
    robot = Robot.from_mapping({**mapping, 'imu': {'late': late, 'rpy': [0.0, 0.0, 0.3]}})
    poses = []
    for moved, intake in ((0, Intake(robot.replace(imu=ImuConfig(rpy=robot.imu.rpy)))),
                          (round(1e9 * late), Intake(robot))):
        found = []
        for index in range(200):
            stamp = START + index * STEP + moved
            found += intake.imu(Made(
                header=Made(stamp=Made(sec=stamp // 10**9, nanosec=stamp % 10**9)),
                angular_velocity=Made(x=0.0, y=0.0, z=math.sin(0.1 * index)),
                linear_acceleration=Made(x=0.2, y=0.0, z=9.81),
                angular_velocity_covariance=[0.0] * 9,
                linear_acceleration_covariance=[0.0] * 9))
            found += intake.handle(wheels(index, 0.3))
        assert intake.estimator.health.used['imu'] > 190
        poses.append([(e.stamp_ns, *e.pose, *e.twist) for e in found])
    assert len(poses[0]) > 150 and poses[0] == poses[1]


# --- wild data ----------------------------------------------------------------------------------

WILD = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1e-308, 1e18)


class Wild:
    """Random messages of all kinds: right and wrong names, lengths, numbers and stamps."""

    def __init__(self, seed, joints):
        self.rng, self.joints = random.Random(seed), list(joints)

    def number(self, size):
        return self.rng.choice(WILD) if self.rng.random() < 0.1 else self.rng.gauss(0.0, size)

    def vector(self, size):
        return Made(x=self.number(size), y=self.number(size), z=self.number(size))

    def header(self, now):
        if self.rng.random() < 0.15:
            now += self.rng.choice([-5_000_000, 10**9, -10**9, 10**12, -10**12, -now])
        seconds, nanoseconds = divmod(now, 10**9)
        return Made(stamp=Made(sec=seconds, nanosec=nanoseconds),
                    frame_id=self.rng.choice(['', 'odom', 'x']))

    def feed(self, intake, now):
        rng, kind = self.rng, self.rng.random()
        if kind < 0.4:
            names = rng.choice([self.joints, self.joints[::-1], self.joints[:2], ['arm'],
                                self.joints + self.joints])
            length = len(names) if rng.random() < 0.9 else rng.randrange(6)
            return intake.joint_states(Made(
                header=self.header(now), name=list(names),
                position=[self.number(1.0) for _ in range(length)],
                velocity=[self.number(9.0) for _ in range(rng.choice([0, len(names)]))]))
        if kind < 0.9:
            return intake.imu(Made(
                header=self.header(now), angular_velocity=self.vector(1.0),
                linear_acceleration=self.vector(5.0),
                angular_velocity_covariance=[rng.choice([0.0, 0.0, -1.0])] + [0.0] * 8,
                linear_acceleration_covariance=[rng.choice([0.0, -1.0])] + [0.0] * 8))
        if kind < 0.94:
            good = np.eye(6).ravel().tolist()
            turn = Made(x=0.0, y=0.0, z=self.number(1.0), w=self.number(1.0))
            return intake.set_pose(Made(header=self.header(now), pose=Made(
                pose=Made(position=self.vector(5.0), orientation=turn),
                covariance=rng.choice([good, [self.number(1.0) for _ in range(36)]]))))
        if kind < 0.97:
            return intake.odometry_reset(self.header(now))
        return intake.wheel_ticks(Made(data=[rng.choice([0, 2**63 - 1, -2**63])] * 4), now)


@pytest.mark.parametrize('seed', range(5))
def test_wild_messages_never_raise_nor_give_an_estimate_that_is_not_sound(robot, seed):
    wild, intake, now = Wild(seed, robot.base.joint), Intake(robot), START
    for _ in range(300):
        now += wild.rng.choice([1_000_000, 5_000_000, 10_000_000])
        for estimate in wild.feed(intake, now):
            for numbers in (estimate.pose, estimate.twist, estimate.pose_covariance,
                            estimate.twist_covariance, estimate.slip.rate):
                assert np.all(np.isfinite(numbers))
            assert np.all((estimate.slip.probability >= 0.0) & (estimate.slip.probability <= 1.0))
            eigenvalues = np.linalg.eigvalsh(estimate.pose_covariance)
            assert eigenvalues[0] > -1e-9 * max(1.0, eigenvalues[-1])
    assert sum(intake.estimator.health.rejected.values()) > 50
