"""Whatever the sensors send, numbers stay finite, variances positive and the pose within reach."""

import math

import numpy as np
import pytest
from motion import parts, wheel_rates

from mecanum_base.core.estimation.estimator import Estimator
from mecanum_base.core.records import (
    CommandSample,
    ImuSample,
    PoseSample,
    ResetSample,
    WheelSample,
)

NAN, INF = math.nan, math.inf


def broken(rng, value):
    """``value`` with one entry made absurd now and then."""
    value = np.array(value, dtype=float)
    if rng.random() < 0.05:
        bad = rng.choice([NAN, INF, -INF, 1e300, -1e6])
        value[rng.integers(len(value))] = bad
    return value


def stream(rng, count):
    """Samples of a robot that drives at random while everything may go wrong."""
    angle, stamp, offset = np.zeros(4), 10**12, np.zeros(4)
    twist = np.zeros(3)
    for _ in range(count):
        stamp += int(rng.choice([0, 5, 5, 5, 10, 300, 5000], p=[.03, .3, .3, .2, .15, .015, .005])
                     * 1_000_000)
        if rng.random() < 0.02:
            twist = rng.normal(size=3) * [0.5, 0.5, 1.0]
        angle = angle + wheel_rates(twist) * 0.007
        if rng.random() < 0.005:
            offset = rng.normal(size=4) * 100.0
        seen = stamp - int(rng.choice([0, 0, 0, 15, 400]) * 1_000_000)
        kind = rng.random()
        if kind < 0.5:
            yield ImuSample(seen, broken(rng, [0.0, 0.0, twist[2]]),
                            broken(rng, rng.normal(size=3) * 0.1 + [0.0, 0.0, 9.8]))
        elif kind < 0.95:
            yield WheelSample(seen, broken(rng, angle + offset), broken(rng, np.full(4, NAN)))
        elif kind < 0.97:
            yield CommandSample(seen, broken(rng, np.zeros(4)))
        elif kind < 0.99:
            yield PoseSample(seen, broken(rng, np.zeros(3)), np.eye(3) * rng.choice([1.0, 0.0]))
        else:
            yield ResetSample(seen)


@pytest.mark.parametrize('seed', range(3))
def test_no_input_makes_it_run_away_or_stop_being_a_number(seed):
    rng = np.random.default_rng(seed)
    own = Estimator(*parts())
    found = []
    for sample in stream(rng, 1200):
        found += own.handle(sample)
        if rng.random() < 0.002:
            own.restart()
    found += own.flush()
    assert len(found) > 100
    for e in found:
        for value in (e.pose, e.twist, e.pose_covariance, e.twist_covariance, e.slip.rate,
                      e.slip.probability, e.slip.twist):
            assert np.isfinite(value).all()
        assert np.diag(e.pose_covariance).min() > -1e-12
        assert ((e.slip.probability >= 0.0) & (e.slip.probability <= 1.0)).all()
        # far beyond any way of 1200 samples, far below the 1e300 some readings claim
        assert np.abs(e.pose[:2]).max() < 3000.0
    assert all(count > 0 for count in own.health.rejected.values())
