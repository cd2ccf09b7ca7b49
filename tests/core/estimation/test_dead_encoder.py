"""An encoder that stops counting while its wheel rolls on."""

import math

from motion import Drive, error, parts, ramp, run, wheel_rates

from mecanum_base.core.estimation.estimator import Estimator


def lap(t):
    on = ramp(t, 1.0, 7.0)
    return (0.4 * on, 0.2 * on * math.sin(t), 0.4 * on)


def dead(t):
    """The front left counter stands between 4.0 and 5.5 s."""
    return (-wheel_rates(lap(t))[0] if 4.0 <= t < 5.5 else 0.0, 0.0, 0.0, 0.0)


def test_a_dead_encoder_is_named_and_costs_nothing():
    drive = Drive(lap, 8.0, slip=dead, noise=0.5)
    own = Estimator(*parts())
    found = run(own, drive.samples)
    assert [(e.kind, e.wheels) for e in own.episodes] == [('encoder dead', (0,))]
    assert error(found, drive) < 0.005  # 2 mm without the fault
