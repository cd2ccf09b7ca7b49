"""Errors raised on purpose: one line a user can act on."""

import pickle

import pytest

from mecanum_base.core.errors import BagError, ConfigError, GeometryError, MecanumBaseError


def test_a_config_error_shows_key_value_rule_and_unit():
    error = ConfigError('wheels.radius[2]', 0.0, 'must be > 0', 'm')
    assert str(error) == 'wheels.radius[2] = 0.0: must be > 0 [m]'
    assert (error.key, error.value, error.rule, error.unit) == \
        ('wheels.radius[2]', 0.0, 'must be > 0', 'm')


def test_a_missing_or_absent_value_is_not_shown():
    assert str(ConfigError.missing('imu.rpy', 'mount', 'rad')) == \
        'imu.rpy: is missing and has no default: mount [rad]'
    assert str(ConfigError('robot.yaml', None, 'cannot be read')) == 'robot.yaml: cannot be read'


def test_an_error_can_be_moved_below_a_block_and_to_a_place_in_a_file():
    error = GeometryError('radius', 0.0, 'must be > 0', 'm').under('wheels')
    assert isinstance(error, GeometryError) and error.key == 'wheels.radius'
    there = error.located('robot.yaml, line 7')
    assert isinstance(there, GeometryError)
    assert str(there) == 'robot.yaml, line 7, wheels.radius = 0.0: must be > 0 [m]'
    assert ConfigError('', 1, 'x').under('wheels').key == 'wheels'


@pytest.mark.parametrize('kind', [ConfigError, GeometryError, BagError])
def test_all_errors_have_one_root(kind):
    assert issubclass(kind, MecanumBaseError)


def test_an_error_survives_the_way_back_from_a_worker_process():
    error = pickle.loads(pickle.dumps(ConfigError('sim.rate', -1, 'must be >= 0', 'Hz')))
    found = (error.key, error.value, error.rule, error.unit)
    assert found == ('sim.rate', -1, 'must be >= 0', 'Hz')
    assert str(error) == str(ConfigError('sim.rate', -1, 'must be >= 0', 'Hz'))
