"""What is claimed of a wheel's slip, from its speed and from what was before."""

import numpy as np
import pytest
from staged_drive import at_start

from mecanum_base.core.estimation.layout import LOOSE_FOR, SIGMA, SLIP
from mecanum_base.core.estimation.output import BODY, describe, row_size, slipping


@pytest.mark.parametrize(('speed', 'just_before', 'grips', 'claimed'), [
    (0.055, 0.0, 1.0, True),  # 1 cm/s beyond the threshold of 4.5
    (0.055, 0.1, 1.0, False),  # what a slip just over has left behind in the velocity
    (-0.055, 0.1, 1.0, False),  # either way
    (0.065, 0.1, 1.0, True),  # more than that
    (0.055, 0.1, 0.6, True),  # a wheel begins to slip again
])
def test_just_after_a_slip_the_error_of_the_velocity_is_no_slip(speed, just_before, grips,
                                                                claimed):
    model, memory = at_start()
    memory.m[LOOSE_FOR] = just_before
    memory.mode[0] = grips
    memory.wheel[SLIP, 2] = speed
    memory.wheel[SIGMA] = 0.006
    row = np.zeros(row_size(4))
    describe(model, memory, row)
    assert (row[BODY] > 0.5) == claimed


def test_a_claim_is_even_at_the_threshold_and_sure_far_beyond_it():
    assert slipping(0.045, 0.01) == pytest.approx(0.5)
    assert slipping(-0.045, 0.01) == pytest.approx(0.5)
    # by hand: Student's t with 3 degrees of freedom at 10 sigma leaves 1.1e-3
    assert 1.0 - slipping(0.145, 0.01) == pytest.approx(1.064e-3, rel=1e-2)
