"""What encoders see of slip, alone and with a gyro, against slips put in by hand."""

import numpy as np
from hypothesis import given
from wheel_strategies import mobile_sets

from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.visibility import assess_visibility
from mecanum_base.core.kinematics.wheels import Wheels


def residual(wheels, slip, gyro):
    """What is left of rates that slip by ``slip`` when the best motion is taken away."""
    matrix = wheels_from_body(wheels)
    if gyro:  # the base stands: the gyro reads 0
        matrix, slip = np.vstack([matrix, [0, 0, 1]]), np.append(slip, 0.0)
    return slip - matrix @ np.linalg.lstsq(matrix, slip, rcond=None)[0]


def test_encoders_alone_see_slip_of_the_usual_base_but_blame_no_wheel():
    seen = assess_visibility(layouts.rectangle(0.2, 0.15, 0.05), gyro=False)
    assert seen.parities == 1 and seen.seen == (True,) * 4 and seen.isolable == (False,) * 4
    assert len(seen.hidden) == 3


def test_a_gyro_tells_the_diagonals_apart_but_not_their_wheels():
    seen = assess_visibility(layouts.rectangle(0.2, 0.15, 0.05), gyro=True)
    assert seen.parities == 2 and len(seen.hidden) == 2
    assert seen.confused == ((3,), (2,), (1,), (0,))
    assert seen.isolable == (False,) * 4


def test_three_wheels_see_nothing_alone_and_one_thing_with_a_gyro():
    base = layouts.swedish_ring(0.2, 0.05, [0.1, 2.2, 4.3])
    alone, helped = (assess_visibility(base, gyro=gyro) for gyro in (False, True))
    assert alone.parities == 0 and not any(alone.seen) and len(alone.hidden) == 3
    assert helped.parities == 1 and all(helped.seen) and not any(helped.isolable)


def test_six_wheels_can_blame_every_wheel():
    base = Wheels(tuple('abcdef'), [.4, .4, 0, 0, -.4, -.4], [.25, -.25] * 3, [np.pi / 2] * 6,
                  [.785, -.785, -.785, .785, .785, -.785], [.07] * 6)
    seen = assess_visibility(base, gyro=True)
    assert seen.parities == 4 and all(seen.isolable)


@given(mobile_sets())
def test_hidden_slip_leaves_no_residual_and_seen_wheels_leave_one(wheels):
    for gyro in (False, True):
        seen = assess_visibility(wheels, gyro=gyro)
        assert len(seen.hidden) == wheels.count - min(seen.parities, wheels.count)
        for pattern in seen.hidden:
            assert np.max(np.abs(residual(wheels, pattern, gyro))) < 1e-6
        for i in range(wheels.count):
            trace = np.max(np.abs(residual(wheels, np.eye(wheels.count)[i], gyro)))
            assert seen.seen[i] == (trace > 1e-9)  # far from the threshold of 1e-6, both ways
