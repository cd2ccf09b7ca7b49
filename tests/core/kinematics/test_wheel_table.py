"""The wheel table refuses what no wheel set can be."""

import numpy as np
import pytest

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.kinematics.wheels import Wheels

GOOD = {'joint': ('a', 'b', 'c'), 'x': [0.1, -0.1, 0.0], 'y': [0.1, 0.1, -0.2],
        'axle': [1.57, 1.57, 0.0], 'roller': [0.8, -0.8, 1.57], 'radius': [0.05, 0.05, 0.06],
        'roller_count': [9, 9, 0], 'roller_pin_radius': [0.038, 0.038, 0.0],
        'max_speed': [20.0, 20.0, 10.0]}


def test_columns_are_read_only_float_arrays_in_the_order_of_the_joints():
    wheels = Wheels(**GOOD)
    assert wheels.count == 3 and wheels.radius.dtype == np.float64
    assert wheels.roller_count.dtype == np.int64
    for column in (wheels.x, wheels.roller_count):
        with pytest.raises(ValueError, match='read-only'):
            column[0] = 1


def test_optional_columns_default_to_unknown():
    wheels = Wheels(**{key: GOOD[key] for key in ('joint', 'x', 'y', 'axle', 'roller', 'radius')})
    assert wheels.roller_count.tolist() == [0, 0, 0]
    assert wheels.roller_pin_radius.tolist() == [0.0, 0.0, 0.0]
    assert np.all(np.isinf(wheels.max_speed))


@pytest.mark.parametrize(('key', 'value', 'text'), [
    ('joint', (), 'at least one wheel'), ('joint', ('a', '', 'c'), r'joint\[1\].*not be empty'),
    ('joint', ('a', 'b', 'a'), r'joint\[2\].*only once'),
    ('x', [0.1, 0.2], '3 as in joint, not 2'),
    ('radius', [0.05, 0.0, 0.05], r'radius\[1\] = 0\.0: must be > 0'),
    ('roller', [0.8, 0.0, 0.8], r'roller\[1\].*cannot drive'),
    ('roller', [0.8, np.pi, 0.8], r'roller\[1\].*cannot drive'),
    ('roller_count', [9, 2, 9], r'roller_count\[1\].*at least 3'),
    ('roller_pin_radius', [0.05, 0.038, 0.0], r'roller_pin_radius\[0\].*below the wheel radius'),
    ('roller_pin_radius', [0.0475, 0.038, 0.0], r'cos\(pi/roller_count\) = 0\.0469846')])
def test_a_wrong_column_is_named(key, value, text):
    with pytest.raises(ConfigError, match=text):
        Wheels(**{**GOOD, key: value})
