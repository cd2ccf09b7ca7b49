"""Scenario files: every shipped one is good, every mistake is named; drivers and curves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mecanum_base.core.errors import ConfigError
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim import curves
from mecanum_base.sim.driver import Follower, Idle, Script
from mecanum_base.sim.faults import FAULTS, KINDS, make_event
from mecanum_base.sim.headless import run
from mecanum_base.sim.scenario import scenario_from_mapping
from mecanum_base.sim.scenario_file import (
    find_scenario,
    load_scenario,
    parse_scenario,
    shipped_scenarios,
)

REQUIRED = ('square', 'circle_spin', 'figure8', 'strafe', 'hard_accel', 'oil', 'ice_lane',
            'carpet_tile', 'wheel_lift', 'wheel_jam', 'pushed', 'collision', 'warehouse',
            'standing', 'slope', 'hallway')


def test_every_scenario_of_the_list_is_shipped():
    assert set(REQUIRED) <= set(shipped_scenarios())
    assert load_scenario('warehouse').duration == 600.0


@pytest.mark.parametrize('name', sorted(shipped_scenarios()))
def test_a_shipped_scenario_loads_with_its_robot_and_runs(name):
    scenario = load_scenario(name)
    robot = load_robot(shipped() / scenario.robot)
    done = run(scenario, robot.base, robot.encoder, robot.imu, robot.sim, duration=0.3)
    assert np.all(np.isfinite(done.pose)) and np.all(np.isfinite(done.slip_rate))
    assert len(done.stamp_ns) == 31
    assert scenario.title


def test_the_hallway_is_100_m_long():
    points = load_scenario('hallway').driving.points
    assert max(p[0] for p in points) == 100.0


@pytest.mark.parametrize('text, words', [
    ('durration: 5.0', ['durration', "did you mean 'duration'"]),
    ('duration: -1.0', ['duration', '-1.0', 'must be > 0', '[s]']),
    ('duration: long', ['duration', "'long'", 'must be a number', '[s]']),
    ('seed: 1.5', ['seed', '1.5', 'whole number']),
    ('sim: {mas: 3.0}', ['sim.mas', "did you mean 'mass'"]),
    ('sim: {mass: 0.0}', ['sim.mass', '0.0', 'must be > 0', '[kg]']),
    ('sim: {imu_preset: mpu}', ['sim.imu_preset', "'mpu'", 'mpu6050']),
    ('floor: {patches: [{friction: 9.0, x: [0, 1], y: [0, 1]}]}',
     ['floor.patches[0].friction', '9.0', '<= 5']),
    ('floor: {patches: [{friction: 0.1}]}', ['floor.patches[0].x', 'must have two entries']),
    ('floor: {patches: [{friction: 0.1, x: [1, 0], y: [0, 1]}]}',
     ['floor.patches[0].x', 'from low to high', '[m]']),
    ('floor: {patches: [{friction: 0.1, centre: [0, 0]}]}',
     ['floor.patches[0].radius', 'must be > 0', '[m]']),
    ('floor: {hole: 1}', ['floor.hole', 'unknown key']),
    ('floor: {ramps: [{begin: 2.0, end: 1.0, grade: 0.1}]}',
     ['floor.ramps[0].end', 'must be > begin', '[m]']),
    ('floor: {walls: [{point: [1.0], facing: 0.0}]}', ['floor.walls[0].point', 'two entries']),
    ('driver: {}', ['driver', 'exactly one of script, points, circle, figure8, wander']),
    ('driver: {circle: {radius: 0.0}}', ['driver.circle.radius', 'must be > 0', '[m]']),
    ('driver: {circle: {radious: 1.0}}', ['driver.circle.radious', "did you mean 'radius'"]),
    ('driver: {points: [[1.0, 2.0]]}', ['driver.points[0]', '[x, y, yaw]', 'rad']),
    ('driver: {points: [[1.0, 2.0, 0.0, -1.0]]}', ['driver.points[0][3]', 'must be >= 0', '[s]']),
    ('driver: {script: [{seconds: 1.0, twist: [1.0]}]}',
     ['driver.script[0].twist', 'three entries']),
    ('driver: {script: []}', ['driver.script', 'at least one entry']),
    ('driver: {wander: {area: [1, 0, 0, 1]}}', ['driver.wander.area', 'x from']),
    ('events: [{kind: jamm, at: 1.0}]', ['events[0].kind', "did you mean 'jam'"]),
    ('events: [{kind: jam}]', ['events[0].at', 'when it begins', '[s]']),
    ('events: [{kind: jam, at: -1.0}]', ['events[0].at', 'must be >= 0', '[s]']),
    ('events: [{kind: jam, at: 1.0, wheels: [-1]}]', ['events[0].wheels[0]', '>= 0']),
    ('events: [{kind: push, at: 1.0, value: 3.0}]', ['events[0].value', '3 entries', 'N']),
    ('events: [{kind: imu_nan, at: 1.0, wheels: [0]}]',
     ['events[0].wheels', 'does not concern single wheels']),
    ('events: [{kind: lift, at: 1.0, value: [1.0]}]', ['events[0].value', 'must be a number']),
    ('events: [{kind: lift, at: 1.0, until: 2.0}]', ['events[0].until', 'unknown key']),
    ('- 1', ['scenario', 'block of keys']),
    ('duration: [', ['line 1', 'not valid YAML']),
])
def test_a_bad_file_is_refused_with_key_value_rule_and_unit(text, words):
    with pytest.raises(ConfigError) as caught:
        parse_scenario(text, 'bad', 'bad.yaml')
    message = str(caught.value)
    assert '\n' not in message
    for word in ['bad.yaml', *words]:
        assert word in message, message


def test_a_wheel_the_robot_does_not_have_is_refused():
    robot = load_robot(shipped() / 'mecanum4.yaml')
    scenario = scenario_from_mapping(
        {'events': [{'kind': 'jam', 'at': 0.0, 'wheels': [4]}]}, 'five')
    with pytest.raises(ConfigError, match='must be >= 0 and < 4'):
        run(scenario, robot.base, robot.encoder, robot.imu, robot.sim, duration=0.1)


def test_an_unknown_name_shows_the_nearest():
    with pytest.raises(ConfigError, match="did you mean 'oil'"):
        load_scenario('oill')
    with pytest.raises(ConfigError, match='cannot be read'):
        load_scenario('missing.yaml')
    assert find_scenario('oil').name == 'oil.yaml'


def test_every_fault_can_be_the_live_parameter_and_has_a_meaning():
    from mecanum_base.core.parameter import rules
    from mecanum_base.sim.config import SimConfig
    choices = set(rules(SimConfig)['fault'].choices)
    assert choices == {'none', *FAULTS, 'jam', 'free', 'lift', 'grip'}  # one number says it all
    assert all(kind.meaning for kind in KINDS.values())


def test_a_negative_duration_of_an_event_is_refused():
    with pytest.raises(ConfigError, match='for = -1.0: must be >= 0 .s.'):
        make_event('jam', 2_000_000_000, 1_000_000_000)


# --- curves and drivers -----------------------------------------------------------------------

CURVES = {
    'legs': curves.legs([(2.0, 1.0, 0.5, 0.4), (2.0, 1.0, 0.5, 1.0), (0.0, 0.1, 3.0, 0.0)],
                        0.6, 0.8, 0.5),
    'circle': curves.circle(0.8, 0.5, 0.3, 2.0),
    'figure8': curves.figure8(4.0, 2.0, 0.6, 0.2, 2.0),
}


@pytest.mark.parametrize('name', CURVES)
def test_the_rate_of_a_curve_is_the_derivative_of_its_pose(name):
    curve, h = CURVES[name], 1e-5
    for t in np.linspace(0.05, 14.95, 150):
        ahead, behind = np.array(curve(t + h)[0]), np.array(curve(t - h)[0])
        assert (ahead - behind) / (2 * h) == pytest.approx(np.array(curve(t)[1]), abs=1e-4)


@pytest.mark.parametrize('name', CURVES)
def test_a_curve_starts_at_the_origin_at_rest(name):
    pose, rate = CURVES[name](0.0)
    assert pose == (0.0, 0.0, 0.0)
    assert rate == pytest.approx((0.0, 0.0, 0.0))


def test_legs_keep_their_limits_and_reach_their_points():
    curve = CURVES['legs']
    times = np.arange(0.0, 25.0, 0.002)
    rates = np.array([curve(t)[1] for t in times])
    speed = np.hypot(rates[:, 0], rates[:, 1])
    accel = np.hypot(*np.diff(rates[:, :2], axis=0).T) / 0.002
    assert np.max(speed) <= 0.6 + 1e-9 and np.max(np.abs(rates[:, 2])) <= 0.8 + 1e-9
    assert np.max(accel) <= 0.5 * 1.01  # finite difference
    assert curve(25.0)[0] == pytest.approx((0.0, 0.1, 3.0))
    repeated = curves.legs([(1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)], 0.5, 0.5, 0.5,
                           repeat=True)
    assert repeated(3.0 + 10.0 * 9)[0] != (0.0, 0.0, 0.0)


def test_a_script_changes_no_faster_than_its_limits():
    script = Script([(1.0, (1.0, 0.0, 0.0)), (1.0, (-1.0, 0.5, 0.0))], (2.0, 1.0, 0.0))
    seen = np.array([script.twist(t, (0, 0, 0)) for t in np.arange(0.0, 3.0, 0.02)])
    change = np.diff(seen, axis=0) / 0.02
    assert np.max(np.abs(change[:, 0])) <= 2.0 + 1e-9
    assert np.max(np.abs(change[:, 1])) <= 1.0 + 1e-9
    assert seen[-1] == pytest.approx([0.0, 0.0, 0.0])


def test_a_follower_turns_the_way_back_into_body_axes():
    still = Follower(lambda t: ((1.0, 2.0, 0.0), (0.0, 0.0, 0.0)), 1.0, 0.5, (9.0, 9.0, 9.0))
    assert still.twist(0.5, (0.0, 0.0, 0.0)) == (0.0, 0.0, 0.0)  # waits
    # 1 m ahead and 2 m left in the floor, seen by a base that looks left
    assert still.twist(2.0, (0.0, 0.0, math.pi / 2)) == pytest.approx(
        (1.0, -0.5, -math.pi / 4))
    tight = Follower(lambda t: ((9.0, 0.0, 0.0), (0.0, 0.0, 0.0)), 0.0, 1.0, (0.3, 0.3, 0.3))
    assert tight.twist(1.0, (0.0, 0.0, 0.0)) == (0.3, 0.0, 0.0)
    assert Idle().twist(1.0, (0, 0, 0)) == (0.0, 0.0, 0.0)


def test_wander_stays_in_its_area_and_depends_on_the_seed():
    driving = scenario_from_mapping(
        {'driver': {'wander': {'area': [-1.0, 2.0, 0.0, 1.0]}}}, 'w').driving
    first, second = driving.driver(1), driving.driver(2)
    path = np.array([first.reference(t) for t in np.arange(5.0, 200.0, 0.5)])
    assert np.min(path[:, 0]) >= -1.0 and np.max(path[:, 0]) <= 2.0
    assert np.min(path[:, 1]) >= 0.0 and np.max(path[:, 1]) <= 1.0
    assert first.reference(30.0) != second.reference(30.0)


def test_the_base_follows_its_path_to_a_few_millimetres():
    robot = load_robot(shipped() / 'mecanum4.yaml')
    scenario = scenario_from_mapping(
        {'duration': 7.0, 'driver': {'wait': 0.2, 'points': [[0.6, 0.4, 0.5, 9.0]]}}, 'leg')
    done = run(scenario, robot.base, robot.encoder, robot.imu, robot.sim)
    assert done.pose[-1] == pytest.approx([0.6, 0.4, 0.5], abs=0.005)


def test_a_carrier_platform_follows_its_path_too():
    robot = load_robot(shipped() / 'dual_differential.yaml')
    scenario = scenario_from_mapping(
        {'duration': 9.0, 'sim': {'mass': 25.0},
         'driver': {'wait': 0.2, 'speed': 0.3, 'points': [[0.5, 0.5, 0.4, 9.0]]}}, 'leg')
    done = run(scenario, robot.base, robot.encoder, robot.imu, robot.sim)
    assert done.pose[-1] == pytest.approx([0.5, 0.5, 0.4], abs=0.01)


def test_samples_are_those_published_and_the_commands_in_order_of_arrival():
    robot = load_robot(shipped() / 'mecanum4.yaml')
    done = run(load_scenario('square'), robot.base, robot.encoder, robot.imu, robot.sim,
               duration=0.5)
    samples = done.samples()
    kinds = {type(s).__name__ for s in samples}
    assert kinds == {'WheelSample', 'TickSample', 'ImuSample', 'CommandSample'}
    assert len(samples) == len(done.published) - len(done.stamp_ns) + len(done.commands)
    assert len(done.samples(commands=False)) == len(samples) - 25
