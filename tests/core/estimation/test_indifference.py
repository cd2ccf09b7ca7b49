"""Slip that does not answer what its wheels do: the wheels grip, and the velocity is wrong."""

import numpy as np
import pytest
from staged_drive import (
    T0,
    at_start,
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

from mecanum_base.core.estimation.indifference import follows
from mecanum_base.core.estimation.layout import (
    FLAT,
    LOCKED_FOR,
    PROBABILITY,
    SIGMA,
    SLIP,
    STEP,
)

T = 0.01


def told(slip, step, flat=None, wheels=(0, 3), sigma=0.05):
    """Whether the base follows in each of 200 frames; slip, step, flat: of the time [s]."""
    model, memory = at_start()
    memory.wheel[PROBABILITY] = 0.0
    memory.wheel[PROBABILITY, list(wheels)] = 0.9
    memory.wheel[SIGMA] = sigma
    found = []
    for k in range(1, 201):
        memory.m[LOCKED_FOR] = k * T
        memory.wheel[STEP], memory.wheel[SLIP] = step(k * T), slip(k * T)
        memory.wheel[FLAT] = 1.0 if flat is None else flat(k * T)
        found.append(follows(model, memory, T))
    return np.array(found)


def sways(t):
    """0.3 m/s and back within 1.2 s."""
    return 0.15 * np.cos(2.0 * np.pi * t / 1.2)


def test_a_base_that_does_whatever_the_wheels_do_follows_them():
    found = told(lambda t: 0.2, sways)
    assert found[100:].all()
    assert not found[:10].any()  # a tenth of a second says nothing yet


@pytest.mark.parametrize('answer', [1.0, 0.6, 0.4, -1.0])
def test_slip_that_answers_the_wheels_is_slip(answer):
    """A base that friction draws along still leaves 0.4 of the change to the slip, as ice does."""
    assert not told(lambda t: 0.4 + answer * sways(t), sways).any()


def test_wheels_that_keep_their_speed_say_nothing():
    shakes = np.random.default_rng(3).standard_normal(201) * 0.01
    assert not told(lambda t: 0.2, lambda t: 0.5 + shakes[round(t / T)]).any()


def test_slip_of_less_than_a_tenth_is_left_alone():
    """What begins slowly has not answered yet."""
    assert not told(lambda t: 0.09, sways).any()


@pytest.mark.parametrize(('sigma', 'says'), [(0.034, True), (0.033, False)])
def test_a_velocity_that_cannot_be_wrong_by_the_slip_is_not_doubted(sigma, says):
    """0.2 m/s are 5.9 and 6.1 standard deviations: a floor that tilts speeds up the base too."""
    assert told(lambda t: 0.2, sways, sigma=sigma).any() == says


def test_only_wheels_believed_to_slide_are_asked():
    def slip(t):
        return np.array([0.2 + sways(t), 0.2, 0.2, 0.2 + sways(t)])

    assert not told(slip, sways).any()
    assert told(slip, sways, wheels=(1, 2)).any()


def test_what_was_before_a_change_of_slip_is_forgotten():
    """The jump at 1 s would hide for long that the slip is the same ever since."""
    def slip(t):
        return 0.6 if t < 1.0 else 0.2

    assert not told(slip, sways, lambda t: 1.0)[100:130].any()
    assert told(slip, sways, lambda t: float(not 0.95 < t < 1.05))[140:].any()


REST = (0.9, (0.0, 0.0, 0.0))
SWAY = [(0.6, (0.4, 0.15, 0.0)), (0.6, (0.4, -0.15, 0.0))] * 3


@pytest.fixture(scope='module')
def deceived():
    """(motion, estimates): from 2.5 s on the accelerometer feels 0.2 m/s that are not there."""
    motion = staged(REST, (2.0, (0.4, 0.0, 0.0)), *SWAY)
    samples = imu(motion)
    for sample in samples:
        if 2.5 <= (sample.stamp_ns - T0) / 1e9 < 3.0:
            sample.accel[:2] += 0.4 * np.array([1.0, -1.0]) / np.sqrt(2.0)
    return motion, run(estimator(), merged(samples, frames(motion, wheel_angles(motion))))


def test_what_the_accelerometer_made_up_is_over_once_the_base_has_followed_its_wheels(deceived):
    motion, found = deceived

    def off(t):
        estimate = next(e for e in found if e.stamp_ns >= T0 + t * 1e9)
        return np.hypot(*(estimate.twist - motion.twist[round(t * 1000)])[:2])

    assert off(3.2) > 0.15  # believed at first: a floor of ice would show no more
    assert off(4.3) < 0.03
    assert all(map(is_sound, found))


def test_a_third_at_least_of_the_way_that_was_made_up_is_given_back(deceived):
    motion, found = deceived
    wrong = sum(0.01 * np.hypot(*(e.twist - motion.twist[(e.stamp_ns - T0) // 1_000_000])[:2])
                for e in found)
    assert wrong > 0.2  # m: by hand, 0.2 m/s for a good second
    assert miss(found[-1], motion)[0] < 0.65 * wrong
