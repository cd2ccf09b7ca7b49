"""Exact odometry with known roller phase: convergence, hand-overs, closed forms."""

import math

import numpy as np
import pytest

from mecanum_base.core import se2
from mecanum_base.core.contact import odometry, rate
from mecanum_base.core.kinematics import layouts
from mecanum_base.core.kinematics.wheels import Wheels

BASE = layouts.rectangle(0.2, 0.15, 0.05, roller_count=9, pin_radius=0.038)


def three():
    """Three mecanum wheels: the exact twist is unique."""
    return Wheels(('a', 'b', 'c'), [0.2, 0.2, -0.25], [0.17, -0.17, 0.0],
                  [math.pi / 2, math.pi / 2, math.pi], [0.8, -0.7, 1.2], [0.05, 0.05, 0.06],
                  np.array([9, 9, 8]), [0.038, 0.037, 0.045])


def test_forward_is_exactly_rim_travel():
    pose = odometry.integrate(BASE, np.array([0.1, -0.2, 0.3, 0.05]), np.full(4, 20.0))
    np.testing.assert_allclose(pose, [1.0, 0.0, 0.0], atol=1e-9)


def test_whole_pitches_in_phase_move_sideways_by_chords():
    pitches = 14
    turns = np.array([-1.0, 1.0, 1.0, -1.0]) * pitches * 2 * math.pi / 9
    pose = odometry.integrate(BASE, np.zeros(4), turns)
    want = pitches * 2 * 0.05 * math.sin(math.pi / 9)
    np.testing.assert_allclose(pose, [0.0, want, 0.0], atol=1e-8)


def test_wheel_turns_of_a_simulated_drive_lead_back_to_its_pose():
    base, dt = three(), 1e-4
    phases, pose = np.array([0.3, -0.1, 0.25]), np.zeros(3)
    twist = np.array([0.25, 0.4, 0.9])
    start, odometer = phases.copy(), np.zeros(3)
    for _ in range(50):  # 0.5 s in samples of 10 ms, each finely integrated (midpoint)
        before = phases.copy()
        for _ in range(10):
            h = 10 * dt / 10
            middle = phases + h / 2 * (rate.wheels_from_body(base, phases) @ twist)
            phases = phases + h * (rate.wheels_from_body(base, middle) @ twist)
            pose = se2.compose(pose, se2.exp(twist * h))
        odometer = odometry.integrate(base, before, phases - before, odometer)
    assert np.max(np.abs(phases - start)) > 2 * math.pi / 9 / 2
    # hand-overs inside a simulation step and rates that are not quite constant over a sample
    np.testing.assert_allclose(odometer, pose, atol=2e-5)


def test_the_step_size_does_not_matter():
    phases, turns = np.array([0.1, 0.2, 0.3]), np.array([4.0, -2.5, 3.3])
    fine = odometry.integrate(three(), phases, turns, max_step=0.005)
    np.testing.assert_allclose(odometry.integrate(three(), phases, turns), fine, atol=1e-8)


def test_pieces_add_up_to_the_whole():
    phases, turns = np.array([0.1, 0.2, 0.3]), np.array([4.0, -2.5, 3.3])
    half = odometry.integrate(three(), phases, 0.5 * turns)
    there = odometry.integrate(three(), phases + 0.5 * turns, 0.5 * turns, half)
    np.testing.assert_allclose(odometry.integrate(three(), phases, turns), there, atol=1e-8)


def test_driving_back_leads_home():
    phases, turns = np.array([0.1, 0.2, 0.3, -0.4]), np.array([4.0, -2.5, 3.3, 1.0])
    there = odometry.integrate(BASE, phases, turns)
    np.testing.assert_allclose(odometry.integrate(BASE, phases + turns, -turns, there), 0.0,
                               atol=1e-8)


def test_hand_overs_are_counted_at_odd_half_pitches_in_both_directions():
    wheel = Wheels(('w',), [0.0], [0.0], [0.0], [1.0], [0.05], np.array([8]), [0.03])
    pitch = 2 * math.pi / 8
    assert len(odometry.handovers(wheel, np.zeros(1), np.array([3.4 * pitch]))) == 3
    assert len(odometry.handovers(wheel, np.zeros(1), np.array([-3.6 * pitch]))) == 4
    assert odometry.handovers(wheel, np.zeros(1), np.array([pitch])) == pytest.approx([0.5])
    assert odometry.handovers(wheel, np.zeros(1), np.zeros(1)) == []


def test_wheels_at_unrelated_phases_force_each_other_to_slip():
    phases = np.array([0.0, 0.2, -0.3, 0.1])
    matrix = rate.wheels_from_body(BASE, phases)
    rates = np.array([-1.0, 1.0, 1.0, -1.0])
    left = rates - matrix @ odometry.exact_twist(BASE, phases, rates)
    assert 0.005 < np.max(np.abs(left)) < 0.06  # up to 4-5 % of the wheel rate (models.md 2.1)


def test_the_odometer_needs_the_angle_of_the_index_pulse_and_nothing_else():
    base, index = three(), np.array([0.4, -1.0, 2.0])
    first, turns = np.array([0.1, 0.2, 0.3]), np.array([2.0, -1.5, 1.3])
    odometer = odometry.ExactOdometer(base, index)
    np.testing.assert_array_equal(odometer.update(index + first), 0.0)  # the first sample arms
    for share in (0.3, 0.5, 1.0):
        pose = odometer.update(index + first + share * turns)
    np.testing.assert_allclose(pose, odometry.integrate(base, first, turns), atol=1e-8)
    shifted = odometry.ExactOdometer(base, index + 0.3, np.array([1.0, 0.0, 0.0]))
    shifted.update(index + first)
    assert np.max(np.abs(shifted.update(index + first + turns) - [1, 0, 0] - pose)) > 1e-4


def test_whole_pitches_of_index_error_do_not_matter():
    base, first, turns = three(), np.array([0.1, 0.2, 0.3]), np.array([2.0, -1.5, 1.3])
    pitch = 2 * math.pi / base.roller_count
    np.testing.assert_allclose(odometry.integrate(base, first + 3 * pitch, turns),
                               odometry.integrate(base, first, turns), atol=1e-12)
