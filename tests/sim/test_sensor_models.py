"""Encoders and IMU: counts, wrap, noise and the faults of both, against the true motion."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.records import ImuSample, TickSample, WheelSample
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.encoder import Encoders
from mecanum_base.sim.imu_presets import PRESETS
from mecanum_base.sim.inertial import Inertial
from mecanum_base.sim.records import Truth
from mecanum_base.sim.scenario import Scenario
from mecanum_base.sim.simulation import Simulation

ROBOT = load_robot(shipped() / 'mecanum4.yaml')
SECOND = 1_000_000_000
CLEAN = dict(imu_preset='ideal', mount_error=0.0, vibration_accel=0.0, vibration_gyro=0.0,
             radius_error=0.0, common_radius_error=0.0, position_error=0.0, roller_error=0.0,
             runout=0.0, stamp_jitter=0.0, contact='mean', encoder_delay=0.0, imu_delay=0.0,
             command_timeout=1000.0)


def simulation(events=(), imu=None, encoder=None, **settings):
    sim = dataclasses.replace(ROBOT.sim, **{**CLEAN, **settings})
    return Simulation(ROBOT.base, encoder or ROBOT.encoder, imu or ROBOT.imu, sim,
                      Scenario(events=events))


def of(kind, readings):
    return [r for r in readings if isinstance(r, kind)]


# --- encoders ---------------------------------------------------------------------------------

@pytest.mark.parametrize('bits', [16, 32, 64])
def test_counts_wrap_at_the_width_and_carry_fractions(bits):
    config = EncoderConfig(counts_per_revolution=1000.5, counter_bits=bits, sign=[1, -1])
    encoders = Encoders(config, 2, seed=3)
    first, _ = encoders.count(np.zeros((1, 2)), np.ones(2))
    start = encoders.ticks(first)[0]
    angles = 0.173 * np.arange(1, 2001)
    for part in np.split(angles, [3, 4, 1000]):  # blocks of any length
        counts, _ = encoders.count(np.column_stack([part, part]), np.ones(2))
    angle = angles[-1]
    ticks = encoders.ticks(counts)[-1]
    half = 1 << (bits - 1)
    assert np.all(ticks >= -half) and np.all(ticks < half)
    moved = [(int(t) - int(s) + half) % (1 << bits) - half for t, s in zip(ticks, start)]
    wanted = round(angle / (2 * math.pi) * 1000.5)
    folded = (wanted + half) % (1 << bits) - half
    assert abs(moved[0] - folded) <= 1  # nothing but the last fraction is lost in 2000 updates
    assert moved[0] + moved[1] == 0  # the second counts the other way


def test_positions_are_the_true_angles_to_one_count():
    sim = simulation()
    sim.command([8.0, 6.0, 4.0, -3.0])
    samples = of(WheelSample, sim.advance(SECOND))
    truth = np.array(sim.plant.column(0))
    moved = samples[-1].position - samples[0].position
    assert np.max(np.abs(moved - truth)) <= 2 * math.pi / 4096 * 1.001
    assert len(samples) == 101  # 0, 0.01 ... 1.00 s


def test_joint_states_and_ticks_tell_the_same_story():
    sim = simulation(encoder=EncoderConfig(counts_per_revolution=500.0, sign=[1, -1, 1, -1]))
    sim.command([8.0, 6.0, 4.0, -3.0])
    readings = sim.advance(SECOND)
    angles = np.array([s.position for s in of(WheelSample, readings)])
    counts = np.array([s.counts for s in of(TickSample, readings)])
    assert angles == pytest.approx(counts * 2 * math.pi / 500.0, abs=1e-9)
    assert angles[-1, 1] < angles[0, 1]  # sign -1: the topic carries the negated value


def test_position_wrap_folds_into_one_turn():
    config = EncoderConfig(counts_per_revolution=4096.0, position_wrap='two_pi')
    sim = simulation(encoder=config)
    sim.command([15.0] * 4)
    angles = np.array([s.position for s in of(WheelSample, sim.advance(2 * SECOND))])
    assert np.all(angles >= 0.0) and np.all(angles < 2 * math.pi)
    assert np.sum(np.abs(np.diff(angles[:, 0])) > math.pi) >= 4


def moved_during(kind, value=None, wheels=(), seconds=1.0):
    sim = simulation()
    sim.command([6.0] * 4)
    before = sim.advance(SECOND)
    sim.inject(kind, seconds, wheels, value)
    during = sim.advance(2 * SECOND - 1_000_000)  # at 2 s the event has ended
    after = sim.advance(3 * SECOND)
    return before, during, after


def test_a_stuck_encoder_stands_still_and_loses_what_it_misses():
    _, during, after = moved_during('encoder_stuck', wheels=(2,))
    angles = np.array([s.position for s in of(WheelSample, during)])
    assert np.ptp(angles[:, 2]) == 0.0
    assert np.ptp(angles[:, 0]) > 5.0
    later = np.array([s.position for s in of(WheelSample, after)])
    assert abs(later[0, 2] - angles[-1, 2]) < 0.1  # goes on from where it stuck
    assert np.ptp(later[:, 2]) > 5.0


def test_a_reversed_encoder_runs_backwards_and_a_reset_one_starts_at_zero():
    _, during, _ = moved_during('encoder_reversed', wheels=(1,))
    angles = np.array([s.position for s in of(WheelSample, during)])
    assert angles[-1, 1] - angles[0, 1] == pytest.approx(-(angles[-1, 0] - angles[0, 0]), abs=0.1)
    _, during, _ = moved_during('encoder_reset', wheels=(3,), seconds=0.0)
    assert 0 <= of(TickSample, during)[0].counts[3] < 200


def test_dropped_messages_are_missing_and_late_ones_late():
    _, during, after = moved_during('encoder_dropped')
    assert not of(WheelSample, during) and of(ImuSample, during)
    assert len(of(WheelSample, after)) == 101
    sim = simulation()
    sim.inject('encoder_late', 2.0, value=0.05)
    late = [p.at_ns - p.reading.stamp_ns for p in sim.advance_published(SECOND)
            if isinstance(p.reading, WheelSample)]
    assert set(late) == {50_000_000}


def test_shares_of_missing_and_late_messages_are_as_configured():
    sim = simulation(missing_share=0.2, late_share=0.1, late_time=0.03, encoder_rate=1000.0)
    published = [p for p in sim.advance_published(4 * SECOND)
                 if isinstance(p.reading, WheelSample)]
    late = sum(p.at_ns > p.reading.stamp_ns + 20_000_000 for p in published)
    assert len(published) / 4000 == pytest.approx(0.8, abs=0.025)  # 4 sigma of 4000 draws
    assert late / len(published) == pytest.approx(0.1, abs=0.022)


def test_bursts_take_whole_stretches_of_messages():
    sim = simulation(burst_rate=2.0, burst_time=0.2)
    stamps = np.array([s.stamp_ns for s in of(WheelSample, sim.advance(8 * SECOND))])
    gaps = np.diff(stamps) * 1e-9
    assert np.sum(gaps > 0.15) >= 5
    assert np.all((gaps < 0.011) | (gaps > 0.15))


def test_stamp_jitter_has_the_configured_size():
    sim = simulation(stamp_jitter=0.001, encoder_rate=500.0)
    stamps = np.array([s.stamp_ns for s in of(WheelSample, sim.advance(2 * SECOND))])
    error = stamps * 1e-9 - np.arange(len(stamps)) * 0.002
    assert np.std(error) == pytest.approx(0.001, rel=0.1)  # 1000 draws: 2.2 % sigma


def test_reordered_messages_change_places_and_none_is_lost():
    sim = simulation()
    sim.inject('reorder', 1.0)
    stamps = [s.stamp_ns for s in of(WheelSample, sim.advance(2 * SECOND))]
    assert stamps != sorted(stamps)
    assert len(stamps) == 201


def test_a_time_jump_moves_all_stamps_for_good():
    sim = simulation()
    sim.inject('time_jump', 0.0, value=-5.0)
    readings = sim.advance(SECOND)
    assert min(r.stamp_ns for r in of(WheelSample, readings)) == -5 * SECOND
    assert min(r.stamp_ns for r in of(ImuSample, readings)) == -5 * SECOND
    assert min(r.stamp_ns for r in of(TickSample, readings)) == -5 * SECOND


# --- commands ---------------------------------------------------------------------------------

def test_wheels_stop_when_commands_cease():
    sim = simulation(command_timeout=0.25)
    sim.command([10.0] * 4)
    sim.advance(SECOND // 4)
    assert min(sim.plant.column(1)) > 8.0
    sim.advance(SECOND)
    assert max(map(abs, sim.plant.column(1))) < 0.2


def test_lost_commands_are_ignored_and_bad_ones_keep_the_last():
    sim = simulation(command_timeout=0.25)
    sim.inject('command_loss', 0.5)
    sim.command([10.0] * 4)
    sim.advance(SECOND // 2)
    assert max(map(abs, sim.plant.column(1))) < 1e-2
    sim.command([5.0, float('nan'), float('inf'), 99.0])
    sim.advance(SECOND // 2 + SECOND // 5)
    rates = sim.plant.column(1)
    assert rates[0] == pytest.approx(5.0, abs=1.5)
    assert abs(rates[1]) < 2.5 and abs(rates[2]) < 2.5  # not commanded, dragged at most
    assert rates[3] > 10.0  # cut at max_speed 20, still speeding up


# --- IMU --------------------------------------------------------------------------------------

def test_at_rest_the_imu_feels_gravity_upwards():
    last = of(ImuSample, simulation().advance(SECOND))[-1]
    assert last.accel == pytest.approx([0.0, 0.0, 9.80665], abs=2e-3)
    assert last.gyro == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)


def test_on_a_slope_gravity_leaks_into_the_plane():
    sim = dataclasses.replace(ROBOT.sim, **CLEAN)
    from mecanum_base.sim.floor import Floor
    scenario = Scenario(floor=Floor(slope=0.05, slope_direction=math.pi / 2))
    last = of(ImuSample, Simulation(ROBOT.base, ROBOT.encoder, ROBOT.imu, sim,
                                    scenario).advance(SECOND))[-1]
    # uphill to the left: the left side is up, the sensor feels +y; sag adds a little tilt
    assert last.accel[1] == pytest.approx(9.80665 * math.sin(0.05), abs=0.03)
    assert last.accel[0] == pytest.approx(0.0, abs=5e-3)


def test_a_turning_base_feels_centripetal_acceleration_at_the_lever():
    imu = ImuConfig(xyz=[0.1, 0.05, 0.0])
    sim = simulation(imu=imu)
    rate = 1.5
    wheel = 0.35 * rate / 0.05
    sim.command([-wheel, wheel, -wheel, wheel])
    samples = of(ImuSample, sim.advance(4 * SECOND))[-200:]
    mean = np.mean([s.accel for s in samples], axis=0)
    turn = np.mean([s.gyro[2] for s in samples])
    assert turn == pytest.approx(rate, rel=0.02)
    assert mean[:2] == pytest.approx([-turn**2 * 0.1, -turn**2 * 0.05], abs=0.01)


def test_the_integral_of_the_clean_imu_is_the_true_motion_even_while_all_wheels_slip():
    """Strapdown integration written here; samples between contact shocks must lose nothing."""
    imu = ImuConfig(xyz=[0.05, 0.0, 0.0])
    sim = simulation(imu=imu, friction=0.15, contact='exact', mass_height=0.05)
    wheel, readings = 20.0, []
    for k, rates in enumerate(([1, 1, 1, 1], [-1, 1, 1, -1], [1, 1, -1, -1], [-1, 1, -1, 1])):
        sim.command([wheel * r for r in rates])
        readings += sim.advance((k + 1) * SECOND)
    samples, truth = of(ImuSample, readings), of(Truth, readings)
    assert max(np.max(np.abs(t.slip_rate)) for t in truth) > 15.0
    speed, seen = np.zeros(2), []
    for sample in samples[1:]:
        w = sample.gyro[2]
        speed = speed + 0.005 * (sample.accel[:2] + w * np.array([speed[1], -speed[0]]))
        seen.append(speed - [0.0, w * 0.05])  # from the sensor back to base_link
    error = np.array(seen)[1::2] - np.array([t.twist[:2] for t in truth[1:]])
    # half a sample of delay at 3 m/s2 is 7 mm/s; pitch of the body leaks 0.1 %
    assert np.max(np.abs(error)) < 0.04
    assert np.abs(error[-1]) == pytest.approx([0.0, 0.0], abs=0.02)


def test_a_rotated_mount_reports_in_its_own_axes():
    imu = ImuConfig(rpy=[math.pi, 0.0, 0.0])  # upside down
    last = of(ImuSample, simulation(imu=imu).advance(SECOND))[-1]
    assert last.accel[2] == pytest.approx(-9.80665, abs=2e-3)


@pytest.mark.parametrize('preset', ['mpu6050', 'bno055', 'bmi088'])
def test_noise_bias_and_steps_are_those_of_the_preset(preset):
    errors = PRESETS[preset]
    sim = dataclasses.replace(ROBOT.sim, imu_preset=preset, mount_error=0.0, imu_rate=400.0)
    rest, speed = np.zeros((4000, 3)), np.zeros(4000)
    starts = []
    for seed in range(60):
        sensor = Inertial(ImuConfig(), dataclasses.replace(sim, seed=seed))
        starts += sensor.read(rest[:100], rest[:100], speed[:100])[0].mean(axis=0).tolist()
    assert np.std(starts) == pytest.approx(errors.gyro_zero_rate, rel=0.3)  # 180 draws, 5 % sigma
    sensor = Inertial(ImuConfig(), sim)
    gyro, _ = sensor.read(rest, rest, speed)
    density = np.std(np.diff(gyro, axis=0), axis=0) / math.sqrt(2.0) / math.sqrt(200.0)
    step = errors.gyro_lsb / math.sqrt(12.0) / math.sqrt(200.0)  # rounding adds to the noise
    assert density == pytest.approx([math.hypot(errors.gyro_noise_density, step)] * 3, rel=0.1)
    assert gyro / errors.gyro_lsb == pytest.approx(np.round(gyro / errors.gyro_lsb), abs=1e-6)
    loud = sensor.read(np.array([[1e3, 0.0, 0.0]]), np.array([[0.0, 0.0, -1e3]]), np.zeros(1))
    assert loud[0][0, 0] == pytest.approx(errors.gyro_range)
    assert loud[1][0, 2] == pytest.approx(-errors.accel_range)


def test_rolling_shakes_the_imu():
    quiet = simulation(vibration_accel=0.0)
    shaken = simulation(vibration_accel=1.0)
    spread = []
    for sim in (quiet, shaken):
        sim.command([10.0] * 4)
        accel = np.array([s.accel for s in of(ImuSample, sim.advance(3 * SECOND))[-300:]])
        spread.append(np.std(accel[:, 1]))
    assert spread[0] < 0.1
    assert spread[1] == pytest.approx(0.5, rel=0.2)  # 1.0 per m/s at 0.5 m/s


def test_imu_faults_do_what_their_names_say():
    _, during, _ = moved_during('imu_frozen')
    assert np.ptp([s.accel for s in of(ImuSample, during)], axis=0) == pytest.approx([0, 0, 0])
    _, during, after = moved_during('imu_nan')
    assert np.all(np.isnan([s.gyro for s in of(ImuSample, during)]))
    assert np.all(np.isfinite([s.gyro for s in of(ImuSample, after)]))
    _, during, _ = moved_during('imu_dropped')
    assert not of(ImuSample, during)
    sim = simulation(imu=ImuConfig(xyz=[0.2, 0.0, 0.0]))
    wheel = 0.35 * 2.0 / 0.05
    sim.command([-wheel, wheel, -wheel, wheel])
    sim.advance(2 * SECOND)
    sim.inject('imu_rotated', 1.0, value=math.pi / 2)
    mean = np.mean([s.accel for s in of(ImuSample, sim.advance(3 * SECOND))], axis=0)
    assert mean[1] == pytest.approx(-4.0 * 0.2, rel=0.1)  # centripetal force now shows on y
    sim = simulation()
    sim.inject('imu_clock_offset', 1.0, value=0.03)
    first = of(ImuSample, sim.advance(SECOND))[0]
    assert first.stamp_ns == 30_000_000


@pytest.mark.parametrize('late, published', [(0.06, 0.06), (-0.02, 0.0)])
def test_an_imu_is_stamped_as_late_as_the_robot_file_says_and_published_no_earlier(late,
                                                                                  published):
    sim = simulation(imu=dataclasses.replace(ROBOT.imu, late=late))
    first, second = [p for p in sim.advance_published(SECOND)
                     if isinstance(p.reading, ImuSample)][:2]
    assert first.reading.stamp_ns == round(late * SECOND)
    assert first.at_ns == round(published * SECOND)
    assert second.reading.stamp_ns - first.reading.stamp_ns == SECOND // 200


def test_the_held_fault_lasts_until_it_is_switched_off():
    sim = simulation()
    sim.set_fault('imu_nan')
    assert np.all(np.isnan([s.gyro for s in of(ImuSample, sim.advance(SECOND))]))
    sim.set_fault('encoder_dropped')
    readings = sim.advance(2 * SECOND)
    assert np.all(np.isfinite([s.gyro for s in of(ImuSample, readings)]))
    assert not of(WheelSample, readings)
    sim.set_fault('none')
    assert len(of(WheelSample, sim.advance(3 * SECOND))) == 100


def test_slip_angle_is_the_integral_of_slip_rate():
    sim = simulation(friction=0.05, encoder_rate=100.0, truth_rate=1000.0)
    sim.command([18.0] * 4)
    truth = of(Truth, sim.advance(SECOND))
    total = np.sum([t.slip_rate for t in truth[1:]], axis=0) * 1e-3
    assert total == pytest.approx(truth[-1].slip_angle, rel=1e-9)
    assert np.all(total > 1.0)
    # slip rate: wheel rate minus rolling rate, here vx / r
    rolling = truth[-1].twist[0] / 0.05
    assert np.array(sim.plant.column(1)) - rolling == pytest.approx(truth[-1].slip_rate, abs=0.02)
