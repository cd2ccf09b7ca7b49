"""A base held by a wall while its wheels spin on, and bases that only look like it."""

import math

import numpy as np
import pytest
from staged_drive import RECTANGLE, T0, Motion, estimator, frames, imu, merged, run, summed

from mecanum_base.core.estimation.layout import (
    EVEN_AX,
    FLAT,
    HELD_FOR,
    LATE,
    PROBABILITY,
    SIGMA,
    SLIP,
    STEP,
    SUM_T,
    SUM_VX,
    TRAVEL,
    VX,
    VY,
    WZ,
    K,
)
from mecanum_base.core.estimation.layout import HIT as BLOW
from mecanum_base.core.estimation.obstacle import held, stop_at_obstacle
from mecanum_base.core.estimation.propagation import spread
from mecanum_base.core.estimation.slip import measure
from mecanum_base.core.estimation.wheel_update import foresee

CLAIM = 0.5  # m/s
HIT, BACK, END = 2.5, 7.5, 9.5  # s: impact, the wheels turn back, the end
DOWN = 0.04  # s in which the wall takes the speed away


def motion_of(t, speed, direction):
    """A translation along ``direction`` with ``speed`` (N,) m/s at 1 kHz."""
    ahead = np.array([*direction, 0.0])
    twist = speed[:, None] * ahead
    return Motion(t, twist, np.gradient(speed, 1e-3)[:, None] * ahead, summed(twist))


def against_a_wall(direction):
    """(motion, angles): the wheels claim 0.5 m/s for 5 s after the impact, then drive back."""
    t = np.arange(round(END * 1000) + 1) * 1e-3
    claim = np.interp(t, [0.9, 1.4, BACK, BACK + 0.3, END - 0.7, END - 0.4],
                      [0.0, CLAIM, CLAIM, -0.4, -0.4, 0.0])
    body = np.where(t < HIT, claim, np.interp(t, [HIT, HIT + DOWN], [CLAIM, 0.0]))
    body = np.where(t > BACK, np.minimum(claim, 0.0), body)
    wheels = claim[:, None] * np.array([*direction, 0.0])
    return motion_of(t, body, direction), summed(wheels @ RECTANGLE.T)


@pytest.fixture(scope='module', params=[(1.0, 0.0), (0.0, 1.0)], ids=['ahead', 'sideways'])
def pressed(request):
    """(motion, estimates) of a base that meets a wall."""
    motion, angles = against_a_wall(request.param)
    return motion, run(estimator(), merged(imu(motion), frames(motion, angles)))


def test_wheels_that_spin_on_against_a_wall_for_five_seconds_move_the_base_nowhere(pressed):
    motion, found = pressed
    truth = np.array([motion.pose[(e.stamp_ns - T0) // 1_000_000, :2] for e in found])
    error = np.hypot(*(np.array([e.pose[:2] for e in found]) - truth).T)
    # the wheels claim 2.5 m; 5 cm/s of doubt for some seconds are allowed for
    assert error.max() < 0.1 * CLAIM * (BACK - HIT)


def test_all_the_time_the_wheels_are_said_to_slip_and_afterwards_no_longer(pressed):
    _, found = pressed
    seconds = np.array([(e.stamp_ns - T0) * 1e-9 for e in found])
    chance = np.array([e.slip.body_probability for e in found])
    assert chance[(seconds > HIT + 0.1) & (seconds < BACK)].min() > 0.5
    assert chance[seconds > BACK + 1.0].max() < 0.5


def test_a_base_on_ice_that_gains_speed_slowly_is_not_taken_for_held():
    # wheels at 0.8 m/s at once, the base follows with 0.4 m/s^2: by hand 2 s and 0.8 m of slip
    t = np.arange(5001) * 1e-3
    claim = np.interp(t, [1.0, 1.1, 4.0, 4.5], [0.0, 0.8, 0.8, 0.0])
    body = np.minimum(np.clip(0.4 * (t - 1.0), 0.0, None), claim)
    motion = motion_of(t, body, (1.0, 0.0))
    angles = summed(claim[:, None] * RECTANGLE[:, 0])
    found = run(estimator(), merged(imu(motion), frames(motion, angles)))
    path = float(motion.pose[-1, 0])
    assert found[-1].pose[0] == pytest.approx(path, abs=0.1)


def sliding(speed=0.02, sigma=0.05):
    """(model, memory): all wheels slide evenly by 0.4 m/s along x, the base drives ``speed``."""
    body = estimator()._filter
    model, memory = body.model, body.memory
    memory.wheel[SLIP] = memory.rows[:, 0] * 0.4
    memory.wheel[STEP] = memory.rows[:, 0] * 0.4
    memory.wheel[PROBABILITY] = 1.0
    memory.wheel[FLAT] = 1.0
    memory.m[BLOW] = 2.0  # m/s^2 of mean over 0.1 s: it has lost the 0.4 m/s at once
    memory.x[VX] = speed
    for i in (VX, VY):
        memory.P[i, :] = memory.P[:, i] = 0.0
        memory.P[i, i] = sigma ** 2
    return model, memory


def frames_pass(model, memory, count=12):
    for _ in range(count):
        stop_at_obstacle(model, memory, 0.01)


def test_its_velocity_along_the_slip_is_taken_for_zero_and_the_slip_grows_by_as_much():
    model, memory = sliding(speed=0.08, sigma=0.06)
    frames_pass(model, memory)
    assert held(memory)
    # by hand: gain 0.06^2/(0.06^2 + 0.05^2) = 0.5902, once; then sigma is 0.0384 < 0.05
    assert memory.x[VX] == pytest.approx(0.08 * (1.0 - 0.5902), abs=1e-5)
    assert memory.P[VX, VX] == pytest.approx(0.06 ** 2 * (1.0 - 0.5902), rel=1e-3)
    assert memory.P[VY, VY] == 0.06 ** 2
    assert memory.wheel[SLIP] @ memory.rows[:, 0] / 4 * 2 == pytest.approx(
        0.4 + 0.08 * 0.5902, abs=1e-4)


@pytest.mark.parametrize('change', [
    lambda memory: memory.m.__setitem__(EVEN_AX, 0.4),
    lambda memory: memory.wheel[PROBABILITY].__setitem__(2, 0.1),
    lambda memory: memory.wheel[FLAT].__setitem__(1, 0.0),
    lambda memory: memory.x.__setitem__(VX, 0.2),
    lambda memory: memory.wheel[STEP].__imul__(0.0),
    lambda memory: memory.wheel[SLIP].__imul__(0.1),
    lambda memory: memory.m.__setitem__(BLOW, 0.9),
], ids=['gains speed', 'a wheel grips', 'slip changes', 'velocity disagrees', 'wheels stand',
        'hardly slips', 'was not slowed down at once'])
def test_nothing_is_in_the_way_of_a_base_that(change):
    model, memory = sliding()
    change(memory)
    frames_pass(model, memory)
    assert not held(memory)
    assert memory.m[HELD_FOR] == 0.0


def test_a_velocity_too_doubtful_to_tell_standing_from_gripping_decides_nothing():
    model, memory = sliding(sigma=0.2)  # 0.4 m/s of slip are two standard deviations
    frames_pass(model, memory)
    assert not held(memory)


def test_two_and_a_half_standard_deviations_between_gripping_and_standing_are_enough():
    model, memory = sliding(speed=0.0, sigma=0.16)
    frames_pass(model, memory)
    assert held(memory)


@pytest.mark.parametrize(('along', 'known'), [(0.0, False), (0.4, True)])
def test_along_a_wall_its_direction_is_as_doubtful_as_the_slip_across_it(along, known):
    model, memory = sliding(speed=0.12, sigma=0.06)  # two sigma: standing seems wrong
    memory.x[VY], memory.P[VY, VY] = along, 0.12 ** 2
    frames_pass(model, memory, 7)
    memory.m[HELD_FOR] *= 1.2
    frames_pass(model, memory, 1)
    # by hand: d(u.v)/dv = (1, -0.4/0.4), variance 0.06^2 + 0.12^2 = 0.018; noise 0.05^2 and
    # (0.2 0.4)^2 of rubbing; one frame moves vx by -0.12 0.0036/0.0269, vy by 0.12 0.0144/0.0269
    assert held(memory) is known
    assert memory.x[VX] == pytest.approx(0.12 - 0.12 * 0.0036 / 0.0269 * known, abs=1e-9)
    assert memory.x[VY] == pytest.approx(along + 0.12 * 0.0144 / 0.0269 * known, abs=1e-9)


def test_a_base_that_rubs_along_a_wall_goes_to_the_nearest_velocity_across_its_slip():
    # velocities across their slip lie on the circle with the diameter 0 to (0.4, 0.4), the
    # speed of the wheels (Thales); (0.06, 0.46) is 12.5 mm/s outside, in the direction `out`
    model, memory = sliding(sigma=0.12)
    claim, start = np.array([0.4, 0.4]), np.array([0.06, 0.46])
    memory.x[VX], memory.x[VY] = start
    memory.wheel[SLIP] = memory.rows[:, :2] @ (claim - start)
    memory.wheel[STEP] = memory.rows[:, :2] @ claim
    out = (start - 0.5 * claim) / math.hypot(*(start - 0.5 * claim))
    outside = math.hypot(*(start - 0.5 * claim)) - math.hypot(*claim) / 2
    frames_pass(model, memory)
    moved = np.array([memory.x[VX], memory.x[VY]]) - start
    assert held(memory)
    assert -outside < moved @ out < -0.7 * outside  # a part stays: doubt of the wall
    assert abs(moved @ (out[1], -out[0])) < 0.02 * outside  # curvature of the circle


def test_a_base_that_turns_about_a_held_corner_is_not_thought_to_stand():
    model, memory = sliding(speed=0.08, sigma=0.06)
    memory.m[WZ] = 0.3
    frames_pass(model, memory)
    assert held(memory)  # no wheel may grip
    assert memory.x[VX] == 0.08 and memory.P[VX, VX] == 0.06 ** 2
    memory.m[WZ] = 0.0
    frames_pass(model, memory, 1)
    assert memory.x[VX] < 0.05


def grips_again(model, memory):
    """Odds, before a frame is seen, of no wheel slipping any more against all of them."""
    everything = model.member.min(axis=1) > 0.0
    memory.mode[:] = everything / everything.sum()
    prior = foresee(model, memory, 0.01)
    return prior[0] / prior[everything].sum()


def test_while_something_holds_the_base_grip_is_a_thousand_times_less_probable():
    model, memory = sliding()
    memory.wheel[SIGMA] = 10.0  # slip speeds within one sigma: nothing else speaks
    free = grips_again(model, memory)
    frames_pass(model, memory)
    assert held(memory)
    memory.wheel[SIGMA] = 10.0
    assert grips_again(model, memory) == pytest.approx(1e-12 * free, rel=1e-9)


def test_grip_is_as_improbable_while_it_only_looks_as_if_something_held_the_base():
    model, memory = sliding()
    memory.wheel[SIGMA] = 10.0
    free = grips_again(model, memory)
    frames_pass(model, memory, 1)
    assert not held(memory)
    assert grips_again(model, memory) == pytest.approx(1e-12 * free, rel=1e-9)


def test_where_all_wheels_slip_a_speed_beyond_one_sigma_makes_grip_less_probable():
    model, memory = sliding()
    memory.wheel[SIGMA] = 10.0
    free = grips_again(model, memory)
    memory.wheel[SIGMA] = np.abs(memory.wheel[SLIP]) / 2.0
    # by hand: each of four wheels at 2 sigma takes exp(-(4 - 1)/2); rounding only
    assert grips_again(model, memory) == pytest.approx(math.exp(-6.0) * free, rel=1e-9)


@pytest.mark.parametrize(('late', 'told'), [(0.0, True), (0.3, False)])
def test_a_step_whose_stamp_may_be_late_says_nothing_of_slip_until_the_next_frame(late, told):
    body = estimator()._filter
    model, memory = body.model, body.memory
    memory.m[LATE] = late
    measure(model, memory, np.full(4, 0.002), np.ones(4), 0.01)  # 0.2 m/s, the base stands
    assert bool(memory.wheel[SLIP].min() > 0.1) is told
    memory.m[LATE] = 0.0
    measure(model, memory, np.full(4, 0.002), np.ones(4), 0.01)  # the wheels have stopped
    assert memory.wheel[TRAVEL] == pytest.approx([0.002] * 4)


def test_a_knock_lets_gripping_wheels_creep_less_than_a_lasting_push_does():
    grown = []
    for lasting in (0.0, 3.0):
        body = estimator()._filter
        model, memory = body.model, body.memory
        memory.m[SUM_T] = 0.01
        memory.m[SUM_VX] = 0.05  # 5 m/s^2 for one frame
        memory.m[EVEN_AX] = lasting
        creep = K + 2 * model.wheels
        spread(model, memory)
        grown.append(math.sqrt(memory.P[creep, creep]))
    assert grown[0] < 0.5 * grown[1]


def test_a_blow_is_remembered_while_all_wheels_slide_and_fades_when_one_grips():
    model, memory = sliding()
    frames_pass(model, memory, 200)
    assert memory.m[BLOW] == 2.0
    memory.wheel[PROBABILITY, 1] = 0.1
    frames_pass(model, memory, 100)
    assert memory.m[BLOW] == pytest.approx(2.0 * math.exp(-1.0 / 0.5))
    memory.m[EVEN_AX] = -1.5
    frames_pass(model, memory, 1)
    assert memory.m[BLOW] == 1.5
