"""The table in the docstring of core.contact, number by number."""

import math

import numpy as np
import pytest

import mecanum_base.core.contact as contact
from mecanum_base.core import se2
from mecanum_base.core.contact import odometry, passage
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.solve import body_from_wheels

COUNTS = (6, 8, 9, 10, 12, 15)
TABLE = {  # rows as printed; tolerance = half of the last printed digit
    'lateral ripple, peak [%]': (lambda k: 100 * (passage.lateral_peak(k) - 1), 0.05),
    'lateral over-read [%]': (lambda k: 100 * (1 / passage.lateral_scale(k) - 1), 0.0051),
    'yaw sawtooth +- [%]': (lambda k: 100 * sawtooth(k), 0.051),
    'contact travel [mm]': (lambda k: 1e3 * base(k)[1].travel[0], 0.051),
}


def base(count):
    wheels = layouts.rectangle(0.2, 0.15, 0.05, roller_count=count, pin_radius=0.038)
    return wheels, passage.passage(wheels, np.array([0.0, 0.0, 1.0]))


def sawtooth(count):
    """Relative to the mean yaw rate of the wheels."""
    wheels, _ = base(count)
    return passage.yaw_sawtooth(wheels)[0] / abs(wheels_from_body(wheels, corrected=False)[0, 2])


@pytest.mark.parametrize('row', TABLE)
def test_the_printed_table_is_what_the_model_gives(row):
    line = next(line for line in contact.__doc__.splitlines() if row in line)
    printed = [float(number) for number in line.split(']')[1].split()]
    function, half_digit = TABLE[row]
    assert len(printed) == len(COUNTS)
    for count, number in zip(COUNTS, printed):
        assert number == pytest.approx(function(count), abs=half_digit)


def test_a_metre_sideways_reads_21_mm_too_long_uncorrected_and_1_mm_corrected():
    wheels, _ = base(9)
    pitches = round(1.0 / passage.lateral_travel(wheels)[0])
    turns = np.array([-1.0, 1.0, 1.0, -1.0]) * pitches * 2 * math.pi / 9
    for phases, limit in ((np.zeros(4), 1e-6), (np.array([0.0, 0.2, -0.3, 0.1]), 1e-3)):
        true = odometry.integrate(wheels, phases, turns, max_step=0.06)
        plain, mean = (se2.exp(body_from_wheels(wheels_from_body(wheels, corrected=c)) @ turns)
                       for c in (False, True))
        assert plain[1] / true[1] - 1 == pytest.approx(0.0206, abs=8e-4)
        assert abs(mean[1] / true[1] - 1) < limit
