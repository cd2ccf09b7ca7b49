"""What slipping and standing wheels may say of the base, and when slip is seen to be over."""

import dataclasses

import numpy as np
import pytest
from staged_drive import (
    RADIUS,
    RECTANGLE,
    T0,
    Motion,
    estimator,
    frames,
    imu,
    merged,
    run,
    staged,
    summed,
    wheel_angles,
)

from mecanum_base.core.estimation.layout import (
    ALL_SLID,
    FLAT,
    HAVE_GYRO,
    KICK,
    LATE_RUN,
    LEAN_GAIN,
    LOCKED_FOR,
    PENDING_T,
    PROBABILITY,
    SIGMA,
    SLIP,
    SLOPE,
    SLOW_AX,
    SLOW_AY,
    VX,
    K,
)
from mecanum_base.core.estimation.slip import unfelt, watch_slope
from mecanum_base.core.estimation.wheel_update import foresee, judge

REST = (0.9, (0.0, 0.0, 0.0))
ALONG_ROLLERS = 1.0 / (RADIUS * np.sin(np.pi / 4))  # rad/s of wheel for 1 m/s along its roller


def test_a_wheel_that_stands_while_its_rollers_roll_is_no_better_witness_than_one_that_turns():
    # along its diagonal two wheels stand; they turn by 6 mm/s, which is 1 % of the base's speed.
    # Taken at their word that is 25 mrad/s of yaw; the gyro says 0 with 1 mrad in 4 s
    diagonal = staged(REST, (6.0, (0.4, 0.4, 0.0)))
    creep = 0.006 * ALONG_ROLLERS
    angles = wheel_angles(diagonal, slip={0: (2.0, 6.0, creep), 3: (2.0, 6.0, -creep)})
    found = run(estimator(), merged(imu(diagonal), frames(diagonal, angles)))
    assert abs(found[-1].pose[2]) < 0.25 * 0.025 * 4.0


def test_wheels_that_slip_for_seconds_do_not_draw_the_velocity_to_their_own():
    ahead = staged(REST, (5.0, (0.5, 0.0, 0.0)))
    claim = np.interp(ahead.t, [2.0, 2.3], [0.0, 1.0])[:, None] * np.array([0.5, 0.5, 0.0])
    angles = summed((ahead.twist + claim) @ RECTANGLE.T)  # FR and RL: 0.7 m/s too fast
    found = run(estimator(), merged(imu(ahead), frames(ahead, angles)))
    late = [e for e in found if e.stamp_ns > T0 + 4_800_000_000]
    # 2.5 s of slip; an accelerometer off by 0.01 m/s^2 alone makes 2.5 cm/s
    assert max(abs(e.twist[0] - 0.5) + abs(e.twist[1]) for e in late) < 0.07


@pytest.mark.parametrize(('speeds', 'flat'), [
    (lambda t: np.maximum(1.0 - 2.0 * t, 0.0), 0.5),  # over for 0.07 s: it may grip again
    (lambda t: 1.0 - 2.0 * t, 0.0),  # passes through zero and goes on
    (lambda t: np.maximum(1.3 - 2.0 * t, 0.3), 0.0),  # stays the same, but is slip
    (lambda t: np.maximum(1.0 - 2.0 * (t + 0.25), 0.0), 1.0),  # over for long
    (lambda t: 0.3 + 0.0 * t, 1.0),  # has not changed at all
])
def test_slip_that_has_just_ended_at_zero_is_told_from_slip_that_passes_or_stays(speeds, flat):
    body = estimator()._filter
    model, memory = body.model, body.memory
    memory.wheel[PROBABILITY] = 1.0
    for speed in speeds(np.arange(0.57 - 0.01 * 4 * SLOPE, 0.575, 0.01)):
        memory.wheel[SLIP] = speed
        watch_slope(model, memory)
    assert memory.wheel[FLAT].tolist() == [flat] * 4


@pytest.mark.parametrize(('slips', 'push', 'unexplained'), [
    ([0, 1, 1, 0], (0.3, 0.3), 0.0),  # FR and RL too fast: their friction pushes ahead and left
    ([0, 1, 1, 0], (-0.3, -0.3), 0.3 * 2 ** 0.5),  # nothing that slides pushes against its slip
    ([0, -1, -1, 0], (0.3, 0.3), 0.3 * 2 ** 0.5),
    ([0, 1, 1, 0], (0.3, -0.3), 0.0),  # across: the rollers of FR and RL turn
    ([1, 1, 1, 1], (0.4, 0.0), 0.0),
    ([1, 1, 1, 1], (-0.4, 0.0), 0.4),
    ([1, 1, 1, 1], (0.4, 0.3), 0.3),  # across, but all slip speeds would have to follow
])
def test_acceleration_that_friction_of_the_sliding_wheels_cannot_explain(slips, push, unexplained):
    memory = estimator()._filter.memory
    memory.wheel[PROBABILITY] = np.abs(slips)
    memory.wheel[SLIP] = 0.3 * np.array(slips)
    memory.m[SLOW_AX], memory.m[SLOW_AY] = push
    assert unfelt(memory) == pytest.approx(unexplained)


@pytest.mark.parametrize(('alone', 'kick', 'all_slid', 'followed', 'factor'), [
    (1.0, 0.05, 0.0, 0.6, np.exp(-3.0)),  # by hand: each of two wheels at 2 sigma exp(-(4 - 1)/2)
    (1.0, 0.09, 0.0, 0.6, 1.0),  # slip has changed at once by more than is left: it may be over
    (1.0, 0.05, 1.0, 0.6, 1.0),  # once all wheels have slid, the velocity may be off by much
    (0.0, 0.05, 0.0, 0.6, 1.0),  # wheels that grip hold the velocity
    (1.0, 0.05, 0.0, 0.4, 1.0),  # what tilt does to the accelerometer is not known
])
def test_a_diagonal_whose_slip_came_slowly_does_not_grip_because_its_speed_is_doubted(
        alone, kick, all_slid, followed, factor):
    body = estimator()._filter
    model, memory = body.model, body.memory
    pair = (model.member == [0.0, 1.0, 1.0, 0.0]).all(axis=1)
    memory.mode[:] = pair / pair.sum()
    memory.wheel[[PROBABILITY, FLAT]] = np.array([[0.0, 1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 1.0]])
    memory.wheel[SLIP], memory.wheel[SIGMA] = [0.0, 0.08, 0.08, 0.0], 1.0
    memory.m[LOCKED_FOR], memory.m[KICK], memory.m[ALL_SLID] = alone, kick, all_slid
    memory.m[LEAN_GAIN] = followed

    def grips_again():
        prior = foresee(model, memory, 0.01)
        return prior[0] / prior[pair].sum()

    free = grips_again()
    memory.wheel[SIGMA] = 0.04
    assert grips_again() == pytest.approx(factor * free, rel=1e-9)  # rounding only


@pytest.mark.parametrize(('rate', 'seed'), [(0.1, 1), (0.1, 2), (0.1, 3), (0.12, 1)])
def test_slip_of_a_diagonal_that_comes_slowly_is_believed_in_until_it_ends(rate, seed):
    # gravity takes the base along the rollers of a diagonal by ``rate`` m/s^2, later by less
    t = np.arange(5901) * 1e-3
    wheels = np.interp(t, [0.9, 1.4], [0.0, 0.5])[:, None] * np.array([1.0, 0.0, 0.0])
    glide = np.interp(t, [2.5, 3.0, 4.9, 5.1], rate * np.array([0.0, 0.5, 1.26, 0.0]))
    body = wheels + glide[:, None] * np.array([1.0, 1.0, 0.0]) * np.sqrt(0.5)
    motion = Motion(t, body, np.gradient(body, 1e-3, axis=0), summed(body))
    found = run(estimator(), merged(imu(motion, seed=seed),
                                    frames(motion, summed(wheels @ RECTANGLE.T))))
    at = np.array([(e.stamp_ns - T0) // 1_000_000 for e in found])
    slips = np.array([e.slip.body_probability for e in found]) > 0.5
    first = at[slips][0]
    assert first < 3500  # a second after it began it is seen
    assert slips[(at > first) & (at < 4900)].all()
    assert not slips[at > 5500].any()


def test_a_floor_that_tilts_unseen_for_long_is_soon_no_slip_any_more():
    # an IMU without x and y gyro axes: 0.9 degrees from 3 to 6 s are a push of 0.15 m/s^2
    along = staged(REST, (8.0, (0.5, 0.0, 0.0)))
    samples = []
    for s in imu(along):
        accel, gyro = s.accel.copy(), s.gyro * [0.0, 0.0, 1.0]
        accel[:2] += 0.15 * np.sqrt(0.5) * (3.0 < (s.stamp_ns - T0) * 1e-9 < 6.0)
        samples.append(dataclasses.replace(s, accel=accel, gyro=gyro))
    found = run(estimator(), merged(samples, frames(along, wheel_angles(along))))
    # believed to be slip all the time it would cost 0.15 3^2/2 + 0.45 2 = 1.5 m
    assert np.hypot(*(found[-1].pose[:2] - along.pose[-1, :2])) < 0.1 * 1.5


def test_a_sudden_turn_back_of_all_wheels_is_slip_and_no_late_stamp():
    # at 0.9 m/s every residual of a late stamp is that of wheels that turn back at once; judged
    # late again and again, the residual grows until no slip speed seems to explain it
    t = np.arange(5001) * 1e-3
    claim = np.interp(t, [0.9, 2.0, 3.0, 3.06], [0.0, 0.9, 0.9, -0.9])
    speed = np.maximum(claim, np.interp(t, [0.9, 2.0, 3.0, 3.9], [0.0, 0.9, 0.9, -0.9]))
    ahead = np.array([1.0, 0.0, 0.0])
    body = Motion(t, speed[:, None] * ahead, np.gradient(speed, 1e-3)[:, None] * ahead,
                  summed(speed[:, None] * ahead))
    found = run(estimator(), merged(imu(body), frames(body, summed(
        claim[:, None] * RECTANGLE[:, 0]))))
    for e in found:
        if e.stamp_ns > T0 + 3_150_000_000:
            truth = speed[(e.stamp_ns - T0) // 1_000_000]
            # 2 cm/s of noise in a second of accelerometer, 1 cm/s for the frames before it is seen
            assert np.hypot(e.twist[0] - truth, e.twist[1]) < 0.03


def test_slip_may_have_lasted_as_long_as_the_frames_before_counted_as_late():
    body = estimator()._filter
    model, memory = body.model, body.memory
    memory.x[VX] = 0.9
    memory.m[PENDING_T], memory.m[LATE_RUN] = 0.03, 1.0
    memory.m[HAVE_GYRO] = 1.0
    travel = memory.x[K + 4:K + 8] - 0.04 * 1.0 * memory.rows[:, 0]  # 1 m/s for 0.04 s
    judge(model, memory, travel, np.ones(4), 0.01)
    # by hand: 1 m/s along x is 1/0.25 = 4 sigma of the body's slip; as lateness it is
    # 44 ms, seven times its sigma
    assert memory.wheel[PROBABILITY].min() > 0.9
