"""Plain Python and numba run the same lines; same seed, same readings."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.records import ImuSample, TickSample, WheelSample
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim import engine
from mecanum_base.sim.floor import Floor, Patch, Ramp, Wall
from mecanum_base.sim.headless import run
from mecanum_base.sim.scenario import Scenario, scenario_from_mapping
from mecanum_base.sim.simulation import Simulation

ROBOT = load_robot(shipped() / 'mecanum4.yaml')
DUAL = load_robot(shipped() / 'dual_differential.yaml')
BUSY = {
    'duration': 2.0, 'seed': 5,
    'floor': {'warp': 0.0005, 'slope': 0.02,
              'patches': [{'friction': 0.05, 'centre': [0.3, 0.1], 'radius': 0.2}],
              'ramps': [{'begin': 0.2, 'end': 0.6, 'grade': 0.05}],
              'walls': [{'point': [0.7, 0.0], 'facing': 3.14159}]},
    'driver': {'script': [{'seconds': 1.2, 'twist': [0.8, 0.3, 0.5]},
                          {'seconds': 0.8, 'twist': [-0.4, 0.2, -1.0]}]},
    'events': [{'kind': 'lift', 'at': 0.5, 'for': 0.3, 'wheels': [2]},
               {'kind': 'jam', 'at': 0.9, 'for': 0.2, 'wheels': [0]},
               {'kind': 'push', 'at': 1.2, 'for': 0.2, 'value': [30.0, -20.0, 2.0]}],
}


def busy(name='busy'):
    return scenario_from_mapping(BUSY, name)


def simulate(robot, seed=None, kind='plain', scenario=None):
    sim = dataclasses.replace(robot.sim, engine=kind)
    return run(scenario or busy(), robot.base, robot.encoder, robot.imu, sim, seed=seed)


def flat(done):
    """Everything a run published, as one array of numbers."""
    numbers = []
    for item in done.published:
        reading = item.reading
        numbers.append([item.at_ns, reading.stamp_ns])
        for name in type(reading).__dataclass_fields__:
            if name != 'stamp_ns' and getattr(reading, name) is not None:
                numbers.append(np.asarray(getattr(reading, name), dtype=np.float64).ravel())
    return np.concatenate([np.asarray(n, dtype=np.float64) for n in numbers])


@pytest.mark.parametrize('robot', [ROBOT, DUAL], ids=['wheels', 'carriers'])
def test_numba_and_plain_python_agree_to_rounding(robot):
    pytest.importorskip('numba')
    plain, compiled = simulate(robot), simulate(robot, kind='numba')
    assert np.max(np.abs(plain.pose - compiled.pose)) < 1e-9
    assert np.max(np.abs(plain.twist - compiled.twist)) < 1e-6
    assert len(plain.published) == len(compiled.published)


def test_the_same_seed_gives_the_same_readings_and_another_seed_others():
    first, again, other = simulate(ROBOT), simulate(ROBOT), simulate(ROBOT, seed=6)
    assert np.array_equal(flat(first), flat(again), equal_nan=True)
    assert not np.array_equal(first.pose, other.pose)


def test_readings_do_not_depend_on_how_far_each_advance_goes():
    def readings(steps_ns):
        sim = Simulation(ROBOT.base, ROBOT.encoder, ROBOT.imu, ROBOT.sim, busy())
        sim.command([5.0, 6.0, 7.0, 8.0])
        out, now = [], 0
        while now < 200_000_000:
            now += steps_ns
            out += sim.advance(now)
        return out

    coarse, fine = readings(100_000_000), readings(1_000_000)
    assert [type(r) for r in coarse] == [type(r) for r in fine]
    assert [r.stamp_ns for r in coarse] == [r.stamp_ns for r in fine]
    for a, b in zip(coarse, fine):
        if isinstance(a, ImuSample):
            assert np.array_equal(a.accel, b.accel)
        elif isinstance(a, WheelSample):
            assert np.array_equal(a.position, b.position)
        elif isinstance(a, TickSample):
            assert np.array_equal(a.counts, b.counts)


def test_reset_puts_the_robot_back_and_time_goes_on():
    sim = Simulation(ROBOT.base, ROBOT.encoder, ROBOT.imu, ROBOT.sim)
    sim.command([10.0] * 4)
    sim.advance(200_000_000)
    assert sim.truth().pose[0] > 0.01
    sim.reset()
    assert sim.now_ns == 200_000_000
    assert sim.truth().pose == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    later = sim.advance(300_000_000)
    assert later and all(r.stamp_ns > 190_000_000 for r in later)
    assert np.max(np.abs(sim.truth().twist)) < 1e-3  # the old command is gone


def test_an_engine_that_is_not_installed_is_named(monkeypatch):
    monkeypatch.setattr(engine, 'numba_installed', lambda: False)
    with pytest.raises(ConfigError, match='sim.engine.*numba'):
        engine.choose('numba', prefer_numba=True)
    assert engine.choose('auto', prefer_numba=True) == 'plain'


def test_the_truth_is_the_integral_of_its_twist():
    done = simulate(ROBOT, scenario=Scenario(duration=3.0, driving=scenario_from_mapping(
        {'driver': {'circle': {'radius': 0.5, 'speed': 0.4, 'spin': 0.8}, 'wait': 0.2}},
        'circle').driving))
    dt = np.diff(done.stamp_ns) * 1e-9
    middle = (done.twist[1:] + done.twist[:-1]) / 2.0
    yaw = (done.pose[1:, 2] + done.pose[:-1, 2]) / 2.0
    vx = np.cos(yaw) * middle[:, 0] - np.sin(yaw) * middle[:, 1]
    vy = np.sin(yaw) * middle[:, 0] + np.cos(yaw) * middle[:, 1]
    way = np.array([np.sum(vx * dt), np.sum(vy * dt), np.sum(middle[:, 2] * dt)])
    # trapezoids of 10 ms over a motion with roller ripple
    assert way == pytest.approx(done.pose[-1] - done.pose[0], abs=2e-3)


def test_floors_with_everything_make_tables_of_the_right_length():
    floor = Floor(patches=(Patch(friction=0.5, x=[0.0, 1.0], y=[0.0, 1.0]),), warp=0.001,
                  ramps=(Ramp(begin=0.0, end=1.0, grade=0.1),),
                  walls=(Wall(point=[1.0, 0.0], facing=0.0),))
    assert len(floor.patches[0].row()) == 8
    assert len(floor.wave_rows(1)) == 16
    assert len(floor.ramps[0].row()) == 6
    assert len(floor.walls[0].row()) == 3


def test_a_change_of_any_kernel_source_makes_numba_compile_again(monkeypatch):
    """numba looks at one file only; the name of the compiled function carries all of them."""
    before = engine._digest()
    assert before == engine._digest()
    original = engine.inspect.getsource
    monkeypatch.setattr(engine.inspect, 'getsource', lambda module: original(module) + (
        '#' if module is engine.lean else ''))
    assert engine._digest() != before

    def unreadable(module):
        raise OSError

    monkeypatch.setattr(engine.inspect, 'getsource', unreadable)
    assert engine._digest() is None
