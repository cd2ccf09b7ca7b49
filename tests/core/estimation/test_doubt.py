"""Doubt of the velocity beside its covariance: who sees it, and when it becomes part of it."""

import math

import numpy as np
import pytest
from staged_drive import DIAGONAL, at_start

from mecanum_base.core.estimation.doubt import (
    ENDS,
    admit,
    doubt_held,
    doubt_velocity,
    doubted_travel,
    forget_doubt,
    velocity_covariance,
    wrong_along_slip,
)
from mecanum_base.core.estimation.layout import (
    DOUBT_XX,
    DOUBT_XY,
    DOUBT_YY,
    HELD_FOR,
    PROBABILITY,
    PX,
    SIGMA,
    SLIP,
    VX,
    VY,
    K,
)
from mecanum_base.core.estimation.obstacle import TIME
from mecanum_base.core.estimation.slip import uncertainty, unlock
from mecanum_base.core.estimation.standstill import settle
from mecanum_base.core.estimation.wheel_update import judge

ALL = np.ones(4)
GRIPS = np.zeros(4)


def sliding(twist, sigma=0.02):
    """Constants and memory of a base whose wheels slide and say that it has lost ``twist``.

    Its velocity is known to ``sigma`` m/s, wrong since 2 s: 1 m/s of it is 2 m of way.
    """
    model, memory = at_start()
    P = memory.P
    P[:, :] = 1e-8 * np.eye(len(P))
    P[VX, VX] = P[VY, VY] = sigma ** 2
    P[PX, VX] = P[VX, PX] = 2.0 * sigma ** 2
    P[PX, PX] = 4.0 * sigma ** 2 + 1e-4
    memory.wheel[SLIP] = np.linalg.pinv(model.inverse) @ np.array([*twist, 0.0])
    memory.wheel[PROBABILITY] = 1.0
    return model, memory


def doubt(memory):
    return np.array([memory.m[k] for k in (DOUBT_XX, DOUBT_XY, DOUBT_YY)])


def test_doubt_adds_up_and_is_forgotten():
    _, memory = at_start()
    for _ in range(3):
        doubt_velocity(memory, 0.01, -0.02, 0.04)
    assert doubt(memory) == pytest.approx([0.03, -0.06, 0.12])
    P = memory.P
    assert velocity_covariance(memory) == pytest.approx(
        (P[VX, VX] + 0.03, P[VX, VY] - 0.06, P[VY, VY] + 0.12))
    forget_doubt(memory)
    assert not doubt(memory).any()


def test_the_wheels_are_judged_with_the_doubt():
    """sigma of a slip speed and the spread of travel: A_i D A_i' along each roller axis."""
    model, memory = at_start()
    memory.P[:, :] = 0.0
    D = np.array([[0.04, 0.01], [0.01, 0.09]])
    doubt_velocity(memory, D[0, 0], D[0, 1], D[1, 1])
    s = math.sqrt(0.5)  # along the rollers of FL, FR, RL, RR, by hand
    A = s * np.array([[1.0, -1.0], [1.0, 1.0], [1.0, 1.0], [1.0, -1.0]])
    assert doubted_travel(memory, 0.02) == pytest.approx(0.02 ** 2 * A @ D @ A.T)
    uncertainty(model, memory)
    assert memory.wheel[SIGMA] ** 2 == pytest.approx((A @ D * A).sum(axis=1) + 25e-6)


def test_a_lateral_gain_is_part_of_the_slip_speed_of_its_wheel():
    model, memory = at_start()
    memory.P[:, :] = 0.0
    memory.P[VY, VY] = 0.01
    memory.x[K + 3 * 4 + 1] = 0.1  # FR
    uncertainty(model, memory)
    assert memory.wheel[SIGMA] ** 2 == pytest.approx(
        0.005 * np.array([1.0, 1.1 ** 2, 1.0, 1.0]) + 25e-6)


@pytest.mark.parametrize(('doubted', 'more'), [
    (0.01, 0.01),  # all of it, where the slip is larger than it all
    (0.50, 0.3 ** 2 - 0.02 ** 2),  # no more than the slip needs
])
def test_what_grips_against_the_covariance_was_wrong_by_what_is_doubted(doubted, more):
    model, memory = sliding((0.3, 0.0))
    P, before = memory.P, memory.P.copy()
    doubt_velocity(memory, doubted, 0.0, 0.7)
    assert admit(model, memory, GRIPS)
    grown = P - before
    # by hand: velocity by that much, and the way of 2 s with it; across nothing
    assert grown[VX, VX] == pytest.approx(more)
    assert grown[PX, VX] == pytest.approx(2.0 * more)
    assert grown[PX, PX] == pytest.approx(4.0 * more)
    assert grown[VY, VY] == pytest.approx(0.0)
    assert np.array_equal(P, P.T)
    assert not doubt(memory).any()


def test_what_the_covariance_explains_needs_no_doubt():
    model, memory = sliding((0.03, 0.0), sigma=0.05)
    before = memory.P.copy()
    doubt_velocity(memory, 0.1, 0.0, 0.1)
    assert not admit(model, memory, GRIPS)
    assert np.array_equal(memory.P, before)


@pytest.mark.parametrize('chance', [ALL, np.full(4, ENDS + 0.01)])
def test_while_all_that_slips_goes_on_slipping_the_doubt_stays_doubt(chance):
    model, memory = sliding((0.3, 0.0))
    before = memory.P.copy()
    doubt_velocity(memory, 0.1, 0.0, 0.1)
    assert not admit(model, memory, chance)
    assert np.array_equal(memory.P, before)
    assert doubt(memory) == pytest.approx([0.1, 0.0, 0.1])


def test_without_doubt_nothing_is_admitted():
    model, memory = sliding((0.3, 0.0))
    before = memory.P.copy()
    assert not admit(model, memory, GRIPS)
    assert np.array_equal(memory.P, before)


def test_doubt_is_admitted_along_the_slip_only():
    """Slip of one diagonal, doubt of the other direction: by hand u'D u = 0."""
    model, memory = sliding(0.2 * DIAGONAL[:2])
    before = memory.P.copy()
    doubt_velocity(memory, 0.05, -0.05, 0.05)
    admit(model, memory, GRIPS)
    assert memory.P == pytest.approx(before, abs=1e-12)


def test_a_held_base_is_doubted_across_its_slip_and_noisy_along_it():
    model, memory = sliding((0.0, -0.4))  # pushes to the right
    before = memory.P.copy()
    doubt_held(model, memory, 0.01)
    assert doubt(memory) == pytest.approx([0.01, 0.0, 0.0])
    grown = memory.P - before
    assert grown[VY, VY] == pytest.approx(0.01)
    grown[VY, VY] = 0.0
    assert not grown.any()


def test_doubt_gives_back_what_a_wrong_velocity_has_done_to_the_pose():
    """A velocity wrong since 2 s: 1 m/s of it is 2 m of way. By hand: that ratio stays."""
    model, memory = at_start()
    P = memory.P
    P[:, :] = 1e-8 * np.eye(len(P))
    P[VX, VX], P[PX, VX], P[VX, PX], P[PX, PX] = 4e-4, 8e-4, 8e-4, 17e-4
    before = P.copy()
    twist = np.array([0.3, 0.0, 0.0])  # what all wheels slip
    memory.wheel[SLIP] = np.linalg.pinv(model.inverse) @ twist
    wrong_along_slip(model, memory, 0.5)
    assert P[VX, VX] == pytest.approx(4e-4 + 0.5 * 0.3 ** 2)
    assert P[PX, VX] == pytest.approx(2.0 * P[VX, VX])
    assert P[PX, PX] - before[PX, PX] == pytest.approx(4.0 * (P[VX, VX] - before[VX, VX]))
    assert P[VY, VY] == pytest.approx(before[VY, VY])
    assert np.array_equal(P, P.T)


def test_wheels_that_contradict_each_other_raise_no_doubt():
    """The front wheels ahead as much as the rear ones behind: no motion of the base does that."""
    model, memory = at_start()
    before = memory.P.copy()
    memory.wheel[SLIP] = np.array([0.3, 0.3, -0.3, -0.3])
    wrong_along_slip(model, memory, 1.0)
    assert np.array_equal(memory.P, before)


@pytest.mark.parametrize('held_for', [0.0, 2.0 * TIME])
def test_while_all_wheels_slide_doubt_grows_and_what_an_obstacle_tells_is_in_the_covariance(
        held_for):
    model, memory = sliding((0.0, -0.4))
    before = memory.P.copy()
    memory.m[HELD_FOR] = held_for
    for _ in range(100):
        unlock(model, memory, 0.01)
    # by hand: 0.02 m/s^2 for 1 s; a sum of 100 steps, the last of them included
    grown, whole = memory.P[VY, VY] - before[VY, VY], 1.01 * 0.02 ** 2
    assert doubt(memory)[0] == pytest.approx(whole)
    assert doubt(memory)[2] == pytest.approx(0.0 if held_for else whole, abs=1e-12)
    assert grown == pytest.approx(whole if held_for else 0.0, abs=1e-12)


def test_wheels_that_hold_the_velocity_end_the_doubt():
    model, memory = sliding((0.3, 0.0))
    doubt_velocity(memory, 0.1, 0.0, 0.1)
    memory.wheel[PROBABILITY] = 0.1
    unlock(model, memory, 0.01)
    assert not doubt(memory).any()


def test_a_standstill_ends_the_doubt():
    model, memory = sliding((0.3, 0.0))
    doubt_velocity(memory, 0.1, 0.0, 0.1)
    settle(memory, 4, np.zeros(4), model.resolution)
    assert not doubt(memory).any()


def test_what_the_doubt_explains_may_be_grip():
    """Wheels roll 0.1 m/s faster than the base is believed to go, known to 1 cm/s: ten sigma."""
    T, chance = 0.01, []
    for doubted in (0.0, 0.1 ** 2):
        model, memory = sliding((0.1, 0.0), sigma=0.01)
        doubt_velocity(memory, doubted, 0.0, doubted)
        phi = slice(K + 4, K + 8)
        memory.P[phi, phi] = memory.rows[:, :2] @ memory.rows[:, :2].T * (0.01 * T) ** 2
        memory.mode[:] = 1.0 / len(memory.mode)
        judge(model, memory, memory.rows[:, 0] * 0.1 * T, np.ones(4), T)
        chance.append(memory.wheel[PROBABILITY].max())
    assert chance[1] < 0.5 * chance[0]
