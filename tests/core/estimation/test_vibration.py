"""Noise of the accelerometer, learnt from its readings: vibration counts, motion does not."""

import math

import numpy as np
import pytest
from staged_drive import T0, at_start

from mecanum_base.core.estimation.inertial import read_imu
from mecanum_base.core.estimation.layout import (
    ALL_SLID,
    DOUBT_XX,
    DOUBT_XY,
    DOUBT_YY,
    HAVE_ACCEL,
    SHAKE,
    STRETCH,
    SUM_T,
    VX,
    VY,
)
from mecanum_base.core.estimation.propagation import spread

PERIOD = 5_000_000  # ns: 200 Hz
COUNT = 4000


@pytest.fixture
def parts():
    return at_start()


def learnt(parts, ax, ay):
    """Noise density squared (N,) (m/s^2)^2/Hz after each reading of these accelerations (N,)."""
    model, memory = parts
    memory.m[HAVE_ACCEL] = 0.0
    found = []
    for k, (x, y) in enumerate(zip(ax, ay)):
        read_imu(model, memory, T0 + k * PERIOD, 0.0, float(x), float(y))
        found.append(memory.m[SHAKE])
    return np.array(found)


def white(sigma):
    return np.random.default_rng(7).standard_normal((2, COUNT)) * sigma


def test_white_noise_counts_whole(parts):
    sigma = 0.3  # m/s^2 of each reading: density sigma sqrt(period)
    density = learnt(parts, *white(sigma))[COUNT // 2:]
    # 2000 pairs of second differences: 3 % of chance
    assert density.mean() == pytest.approx(sigma ** 2 * PERIOD * 1e-9, rel=0.1)


def test_what_the_base_truly_does_is_no_noise(parts):
    """Rocking by 2 m/s^2 at 3 Hz with the same noise: its first differences are 0.1 m/s^2."""
    sigma = 0.02
    t = np.arange(COUNT) * PERIOD * 1e-9
    rocks = 2.0 * np.sin(2.0 * math.pi * 3.0 * t)
    density = learnt(parts, *(white(sigma) + np.array([rocks, np.zeros(COUNT)])))[COUNT // 2:]
    assert density.mean() == pytest.approx(sigma ** 2 * PERIOD * 1e-9, rel=0.2)


def test_a_knock_hardly_counts(parts):
    ax, ay = white(0.05)
    quiet = learnt(parts, ax, ay)
    ax[COUNT // 2] += 30.0
    assert learnt(parts, ax, ay)[COUNT // 2:].max() < 2.5 * quiet[COUNT // 2:].max()


def test_velocity_grows_uncertain_as_the_noise_says_and_is_doubted_besides_where_all_slide(parts):
    model, memory = parts
    T, density = 0.01, 0.03 ** 2
    start = memory.P.copy()
    grown = {}
    for slid, noise in ((0.0, 0.0), (0.0, density), (1.0, density)):
        memory.P[:, :] = start
        memory.m[HAVE_ACCEL], memory.m[ALL_SLID] = 1.0, slid
        memory.m[SHAKE], memory.m[SUM_T], memory.m[STRETCH] = noise, T, 1.0
        spread(model, memory)
        grown[slid, noise] = memory.P[VX, VX], memory.P[VY, VY]
        doubted = memory.m[DOUBT_XX], memory.m[DOUBT_XY], memory.m[DOUBT_YY]
        assert slid or doubted == (0.0, 0.0, 0.0)
    # without noise the unknown offset alone
    grips, slides = (np.array(grown[slid, density]) - grown[0.0, 0.0] for slid in (0.0, 1.0))
    assert grips.min() > 1.2 * density * T  # the integral of that noise, and some margin
    assert grips.max() < 2.0 * density * T
    assert 1.0 * density * T < slides.min() and slides.max() < grips.min()  # no contact adds to it
    assert doubted[1] == 0.0 and min(doubted[::2]) > density * T  # as much again may have happened
