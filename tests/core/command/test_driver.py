"""Command to wheel rates without ROS: order of limits, saturation, clocks, both kinds of base."""

import math

import numpy as np
import pytest

from mecanum_base import robot_file
from mecanum_base.core.command.drive import DriveConfig
from mecanum_base.core.command.driver import Driver
from mecanum_base.core.command.geometry import geometry_of
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.platform.carriers import Carriers

MS = 1_000_000
STEP = 20 * MS
FREE = {'max_acceleration': (), 'max_deceleration': (), 'max_jerk': ()}


@pytest.fixture(scope='module')
def wheels():
    return robot_file.load_robot(robot_file.shipped() / 'mecanum4.yaml').base


def carriers(**changes):
    columns = {
        'name': ('front', 'rear'), 'x': (0.3, -0.3), 'y': (0.0, 0.0), 'axle_offset': (-0.1, -0.1),
        'half_track': (0.12, 0.12), 'wheel_radius': (0.05, 0.05), 'left_joint': ('fl', 'rl'),
        'right_joint': ('fr', 'rr'), 'max_speed': (20.0, 20.0)}
    return Carriers(**{**columns, **changes})


def drive(driver, twist, steps, start=0, every=True):
    told = []
    for i in range(steps):
        now = start + i * STEP
        if every or i == 0:
            driver.stopping.accept(np.array([twist[0], twist[1], 0.0]),
                                   np.array([0.0, 0.0, twist[2]]), now)
        told.append(driver.step(now))
    return told


def ground_speed(wheels, twist):
    """Rim speed from G eq. 16 by hand for axles to the left: (vx -+ vy -+ k w) / r, corrected."""
    k = math.pi / 9.0
    stretch = k / math.sin(k)  # tan(delta) / tan(delta_eff)
    rates = []
    for x, y, roller in zip(wheels.x, wheels.y, wheels.roller):
        side = math.copysign(1.0, roller) * stretch
        vx, vy = twist[0] - twist[2] * y, twist[1] + twist[2] * x
        rates.append((vx - vy * side) / 0.05)
    return rates


def test_wheel_rates_are_those_of_the_twist_that_is_told(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig())
    told = drive(driver, (0.3, -0.2, 0.4), 60)
    assert told[-1].twist == pytest.approx([0.3, -0.2, 0.4])
    for one in told:
        assert one.rates == pytest.approx(ground_speed(wheels, one.twist), abs=1e-9)


def test_a_twist_too_fast_for_the_wheels_keeps_its_direction(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig(**FREE))
    wanted = np.array([3.0, 1.0, 2.0])
    told = drive(driver, wanted, 2)[-1]
    assert np.abs(told.rates).max() == pytest.approx(20.0)
    assert told.twist / np.linalg.norm(told.twist) == pytest.approx(
        wanted / np.linalg.norm(wanted))


def test_keep_yaw_slows_the_translation_only(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig(**FREE, keep_yaw=True))
    told = drive(driver, (3.0, 0.0, 1.0), 2)[-1]
    assert told.twist[2] == pytest.approx(1.0) and 0.0 < told.twist[0] < 1.0
    assert np.abs(told.rates).max() == pytest.approx(20.0)


def test_no_wheel_is_too_fast_while_the_base_changes_from_one_extreme_to_another(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig())
    rng, start = np.random.default_rng(5), 0
    for _ in range(30):
        steps = int(rng.integers(1, 60))
        for told in drive(driver, rng.uniform(-4.0, 4.0, 3), steps, start):
            assert np.abs(told.rates).max() <= 20.0 + 1e-9
        start += steps * STEP


def test_after_the_time_out_the_base_decelerates_and_then_stands(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig(max_jerk=()))
    drive(driver, (0.6, 0.0, 0.0), 60)
    start = 60 * STEP
    speeds = [driver.step(start + i * STEP).twist[0] for i in range(60)]
    # last command at step 59: it runs for 0.5 s = until step 84; then 3 m/s^2 = 0.06 a step
    assert speeds[24] == pytest.approx(0.6)
    assert speeds[25] == pytest.approx(0.54)
    assert speeds[34] == pytest.approx(0.0, abs=1e-12) and speeds[59] == 0.0


def test_disabling_gives_zeros_to_all_wheels_at_once(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig())
    drive(driver, (0.6, 0.2, 0.5), 60)
    told = driver.enable(False, 'test')
    assert told is not None and not told.rates.any() and not told.twist.any()
    assert not driver.step(60 * STEP).rates.any()
    assert driver.enable(True, 'test') is not None  # still standing: nothing was commanded


def test_a_clock_that_jumps_back_stops_the_base_until_the_next_command(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig())
    drive(driver, (0.6, 0.0, 0.0), 60, start=10_000 * MS)
    assert not driver.step(5_000 * MS).rates.any()
    assert 'jumped back' in driver.stopping.reason
    assert not driver.step(5_000 * MS + STEP).rates.any()
    restart = drive(driver, (0.6, 0.0, 0.0), 3, start=5_000 * MS + 2 * STEP)
    assert 0.0 < restart[-1].twist[0] < 0.1  # the ramp starts again from zero


def test_a_pause_longer_than_the_time_out_stops_the_base_at_once(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig())
    drive(driver, (0.6, 0.0, 0.0), 60)
    assert not driver.step(60 * STEP + 2_000 * MS).rates.any()
    assert 'between two steps' in driver.stopping.reason


def test_a_pause_while_standing_is_no_event(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig())
    driver.step(0)
    driver.step(100_000 * MS)
    driver.step(0)
    assert driver.stopping.take_transitions() == ()


def test_limits_changed_while_driving_hold_from_the_next_step(wheels):
    driver = Driver(geometry_of(wheels), DriveConfig(max_jerk=()))
    drive(driver, (0.6, 0.0, 0.0), 60)
    driver.configure(DriveConfig(max_jerk=(), max_velocity=(0.3, 0.3, 1.0)))
    told = drive(driver, (0.6, 0.0, 0.0), 20, start=60 * STEP)
    assert told[0].twist[0] == pytest.approx(0.6 - 0.06)  # decelerating at 3 m/s^2
    assert told[-1].twist[0] == pytest.approx(0.3)


def test_carriers_with_straight_hinges_drive_forward_on_all_four_wheels():
    driver = Driver(geometry_of(carriers()), DriveConfig(**FREE))
    told = drive(driver, (0.5, 0.0, 0.0), 2)[-1]
    assert told.rates == pytest.approx([10.0] * 4)


def test_hinge_angles_of_carriers_follow_the_commands():
    geometry = geometry_of(carriers(initial_angle=(0.4, -0.3)))
    driver = Driver(geometry, DriveConfig(**FREE))
    drive(driver, (0.2, 0.0, 0.0), 150)
    # trailing axles align like casters: theta' = -(v/e) sin(0 - theta), e = -0.1 (models.md 4)
    for start, end in zip((0.4, -0.3), geometry.angles):
        expected = 2.0 * math.atan(math.tan(start / 2.0) * math.exp(-0.2 / 0.1 * 149 * 0.02))
        assert end == pytest.approx(expected, abs=2e-5)  # midpoint rule, step 0.02 s


def test_measured_hinge_angles_replace_integrated_ones_and_nan_does_not():
    geometry = geometry_of(carriers())
    geometry.measure(np.array([0.5, math.nan]))
    assert geometry.angles == pytest.approx([0.5, 0.0])
    # D20 by hand for carrier 0 at theta = 0.5, V = (1, 0, 0): hX = cos, hY = -sin
    hx, hy = math.cos(0.5), -math.sin(0.5)
    left = (hx + 0.12 / -0.1 * hy) / 0.05
    assert (geometry.matrix() @ [1.0, 0.0, 0.0])[0] == pytest.approx(left)


def test_carriers_never_exceed_their_wheel_limit_while_they_swing_round():
    driver = Driver(geometry_of(carriers(max_speed=(6.0, 8.0))), DriveConfig())
    limit = np.array([6.0, 6.0, 8.0, 8.0])
    for i, wanted in enumerate([(0.5, 0.0, 0.0), (-0.5, 0.0, 0.0), (0.0, 0.6, 0.9)]):
        for told in drive(driver, wanted, 100, start=i * 100 * STEP):
            assert (np.abs(told.rates) <= limit + 1e-9).all()


@pytest.mark.parametrize('order', [('a',), ('a', 'b', 'b'), ('a', 'b', 'd')])
def test_a_command_order_that_does_not_name_every_wheel_once_is_an_error(order):
    with pytest.raises(ConfigError, match='command_joints.*every wheel once: a, b, c'):
        DriveConfig(command_joints=order).order_of(('a', 'b', 'c'))


def test_a_limit_needs_three_entries_or_none():
    with pytest.raises(ConfigError, match='max_velocity.*three entries'):
        DriveConfig(max_velocity=(1.0, 2.0))


def test_a_jittering_timer_neither_bends_the_ramp_nor_overshoots(wheels):
    driver, rng = Driver(geometry_of(wheels), DriveConfig()), np.random.default_rng(3)
    now, speeds = 0, []
    for i in range(300):
        if i < 150:
            driver.stopping.accept(np.array([0.6, 0.0, 0.0]), np.zeros(3), now)
        speeds.append(driver.step(now).twist[0])
        now += int(STEP + rng.uniform(-9, 9) * MS)
    assert max(speeds) == 0.6 and min(speeds) == 0.0 and speeds[-1] == 0.0
    # 3 m/s^2 over at most two periods of 0.02 s between two sendings
    assert np.abs(np.diff(speeds)).max() <= 0.12 + 1e-12
