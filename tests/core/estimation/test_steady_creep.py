"""Wheels that grip creep under traction: more than they roll, on slopes all the time."""

import math

import numpy as np
import pytest
from staged_drive import (
    MS,
    RADIUS,
    RECTANGLE,
    T0,
    at_start,
    estimator,
    frames,
    imu,
    merged,
    rectangle,
    run,
    staged,
    summed,
)

from mecanum_base.core.estimation.layout import (
    BAX,
    BAY,
    BSX,
    BSY,
    CREEPS,
    EVEN_AX,
    EVEN_AY,
    HAVE_ACCEL,
    HAVE_GYRO,
    SLOW_AX,
    SLOW_AY,
    SUM_T,
    SUM_VX,
    SUM_VY,
    SUM_X,
    VX,
    K,
)
from mecanum_base.core.estimation.propagation import spread
from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.platform.carriers import Carriers

G = 9.80665  # m/s^2
SIDE = {4: (-1, 1, 1, -1), 6: (-1, 1, -1, 1, 1, -1)}  # how each roller axis leans
ALONG = {count: np.array([[1, side] for side in sides]) * math.sqrt(0.5)
         for count, sides in SIDE.items()}


def parts(base, creep=0.05):
    model, memory = at_start(base, EstimatorConfig(creep=creep))
    memory.m[HAVE_GYRO] = memory.m[HAVE_ACCEL] = 1.0
    memory.m[SUM_T], memory.m[SUM_X], memory.x[VX] = 0.02, 0.01, 0.5  # 0.5 m/s for 20 ms
    return model, memory


@pytest.mark.parametrize('count', [4, 6])
@pytest.mark.parametrize('felt', [(0.4, 0.0), (0.0, -0.6), (0.5, 0.3)])
def test_forces_of_the_creep_add_up_to_what_the_accelerometer_feels(count, felt):
    model, memory = parts(rectangle(count))
    push = 0.25 * np.array(felt)  # a quarter of it accelerates the base,
    memory.m[EVEN_AX], memory.m[EVEN_AY] = memory.m[SLOW_AX], memory.m[SLOW_AY] = push
    memory.m[SUM_VX], memory.m[SUM_VY] = 0.02 * push
    memory.x[[BAX, BAY]] = 0.75 * np.array(felt) + 0.2  # the rest holds it on its slope
    memory.x[[BSX, BSY]] = 0.2
    spread(model, memory)
    travel = memory.x[K + count:K + 2 * count]
    along = ALONG[count]
    traction = (travel - 0.01 * along[:, 0]) / (0.05 * 0.01)  # over load, of each wheel
    # by hand: N = m g/count on each wheel, sum of traction N along = m felt, and no moment
    base = rectangle(count)
    lever = base.x * along[:, 1] - base.y * along[:, 0]
    balance = np.column_stack([along, lever]).T
    wanted = np.array([*felt, 0.0]) * count / G
    assert balance @ traction == pytest.approx(wanted, abs=1e-9)
    smallest = np.linalg.lstsq(balance, wanted, rcond=None)[0]
    assert traction == pytest.approx(smallest, abs=1e-9)


def test_wheels_of_carriers_and_a_coefficient_of_0_do_not_creep():
    carriers = Carriers(('front', 'rear'), [0.3, -0.3], [0.0, 0.0], [-0.1, -0.1], [0.12, 0.12],
                        [0.05, 0.05], ('fl', 'rl'), ('fr', 'rr'))
    for base, creep in ((carriers, 0.05), (rectangle(), 0.0)):
        model, memory = parts(base, creep)
        memory.m[EVEN_AX] = 1.0
        spread(model, memory)
        rolled = memory.rows[:, 0] * 0.01
        assert memory.x[K + 4:K + 8] == pytest.approx(rolled, abs=1e-12)


def test_creep_beyond_what_traction_explains_is_looked_at():
    model, memory = parts(rectangle())
    assert memory.m[CREEPS] == 0.3  # nothing is known yet
    spread(model, memory)
    assert memory.m[CREEPS] == pytest.approx(0.05)  # no traction
    model, memory = parts(rectangle())
    memory.m[HAVE_ACCEL] = 0.0  # nor is traction without an accelerometer
    spread(model, memory)
    assert memory.m[CREEPS] == 0.3


@pytest.mark.parametrize('pull', [(0.0, 0.35), (-0.3, 0.2)])  # m/s^2: slopes of 2 degrees
def test_on_a_slope_the_way_lost_to_creep_comes_back(pull):
    motion = staged((1.5, (0.0, 0.0, 0.0)), (8.0, (0.5, 0.0, 0.0)), (1.0, (0.0, 0.0, 0.0)))
    # an own model of the contact: wheels turn farther by 5 % of speed times traction over load
    traction = np.linalg.lstsq(ALONG[4].T, np.array(pull) * 4 / G, rcond=None)[0]
    speed = np.abs(motion.twist[:, :1])
    per_radian = RADIUS * math.sqrt(0.5)
    angles = summed(motion.twist @ RECTANGLE.T + 0.05 * speed * traction / per_radian)
    off = {}
    for creep in (0.0, 0.05):
        # all of the offset is the slope: the accelerometer is known to be good
        tuning = EstimatorConfig(creep=creep, accel_bias_sigma=1e-3)
        found = run(estimator(tuning=tuning), merged(imu(motion, accel_bias=pull),
                                                     frames(motion, angles)))
        at = (found[-1].stamp_ns - T0) // MS
        off[creep] = np.hypot(*(found[-1].pose[:2] - motion.pose[at, :2]))
    # by hand: v 2 c |pull|/g is 0.36 % of 4 m along the slope; the scale states take up a part
    assert off[0.0] > 0.006
    assert off[0.05] < 0.3 * off[0.0]
