"""Where rollers touch and how the true robot differs from its file, against models.md."""

from __future__ import annotations

import dataclasses
import math
import pathlib
import sys

import numpy as np
import pytest

from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim import layout as at
from mecanum_base.sim.body import make_body
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.floor import Floor, Patch
from mecanum_base.sim.headless import run
from mecanum_base.sim.scenario_file import load_scenario

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from plants import (
    LX,
    LY,
    RADIUS,
    four_wheels,
    make_plant,
    set_inputs,
    set_velocity,
)

ROLLERS, PIN = 9, 0.038


@pytest.mark.parametrize('seed', range(4))
def test_the_wheel_that_does_not_slip_turns_as_the_exact_contact_says(seed):
    """models.md 2.1 in closed form; friction 0, so the motion is what was set."""
    draw = np.random.default_rng(seed)
    plant = make_plant(four_wheels(ROLLERS, PIN), contact='exact', friction=0.0, roller_drag=0.0,
                       seed=seed, bearing_torque=0.0, bearing_viscous=0.0)
    set_inputs(plant, at.I_FREE, 1.0)
    vx, vy, w = draw.uniform(-1.0, 1.0, 3)
    set_velocity(plant, vx, vy, w)
    angles, rates = draw.uniform(-20.0, 20.0, 4), draw.uniform(-10.0, 10.0, 4)
    for i in range(4):
        plant.turn[i * at.TURN + at.T_ANGLE] = angles[i]
        plant.turn[i * at.TURN + at.T_RATE] = rates[i]
    phases = [plant.body.wheels[i * at.WHEEL + at.W_PHASE] for i in range(4)]
    plant.advance(1)
    half = w * 0.5e-3  # the step sees the base half a step later
    bx, by = (math.cos(half) * vx + math.sin(half) * vy, math.cos(half) * vy - math.sin(half) * vx)
    for i, (x, y, sign) in enumerate(((LX, LY, 1), (LX, -LY, -1), (-LX, LY, -1), (-LX, -LY, 1))):
        cot = sign  # cot(delta) for 45 degrees
        pitch = 2.0 * math.pi / ROLLERS
        u = (angles[i] + phases[i] + pitch / 2.0) % pitch - pitch / 2.0
        ax_speed, ay_speed = bx - w * y, by + w * x
        exact = (ax_speed - cot / math.cos(u) * ay_speed
                 + w * PIN * cot * math.tan(u)) / RADIUS
        slip = plant.turn[i * at.TURN + at.T_SLIP_RATE]
        assert rates[i] - slip == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize('twist, axis', [((0.0, 0.3, 0.0), 1), ((0.0, 0.0, 0.8), 2),
                                         ((0.3, 0.0, 0.0), 0)])
def test_commands_with_the_mean_correction_come_out_right_on_exact_contacts(twist, axis):
    """tan(d_eff) = tan(d) sin(p)/p by hand; less than 0.2 % off, 2 % without it."""
    vx, vy, w = twist
    p = math.pi / ROLLERS
    cot = p / math.sin(p)  # of the corrected roller angle
    lever = LX * cot + LY
    rates = np.array([vx - cot * vy - lever * w, vx + cot * vy + lever * w,
                      vx + cot * vy - lever * w, vx - cot * vy + lever * w]) / RADIUS
    moved, other = [], []
    for seed in range(3):
        plant = make_plant(four_wheels(ROLLERS, PIN), contact='exact', seed=seed)
        set_inputs(plant, at.I_RATE, rates)
        plant.advance(2000)
        seen = np.zeros(3)
        for _ in range(1500):  # 15 s: tens of rollers, so that the ripple averages out
            plant.advance(10)
            seen += np.array(plant.twist) / 1500
        moved.append(seen[axis] / twist[axis] - 1.0)
        other.append(np.delete(seen, axis))
    assert np.max(np.abs(moved)) < 0.002
    assert np.max(np.abs(other)) < 0.001
    if axis == 1:
        assert cot - 1.0 > 0.02  # what the correction is worth


def test_the_contact_choices_differ_as_they_should():
    wheels = four_wheels(ROLLERS, PIN)
    bodies = {kind: make_body(wheels, dataclasses.replace(
        SimConfig(), contact=kind, roller_error=0.0), np.zeros(3))
        for kind in ('exact', 'mean', 'nominal')}
    assert bodies['exact'].wheels[at.W_PITCH] == pytest.approx(2 * math.pi / ROLLERS)
    assert bodies['nominal'].wheels[at.W_PITCH] == bodies['mean'].wheels[at.W_PITCH] == 0.0
    tangent = bodies['mean'].wheels[at.W_SIN] / bodies['mean'].wheels[at.W_COS]
    p = math.pi / ROLLERS
    assert tangent == pytest.approx(math.sin(p) / p)
    assert bodies['nominal'].wheels[at.W_SIN] == pytest.approx(math.sqrt(0.5))


def test_the_true_robot_differs_from_its_file_by_the_stated_errors():
    wheels = four_wheels(ROLLERS, PIN)
    config = dataclasses.replace(SimConfig(), radius_error=0.003, common_radius_error=0.004,
                                 position_error=0.002, roller_error=0.005)
    tables = np.array([np.reshape(make_body(wheels, dataclasses.replace(config, seed=seed),
                                            np.zeros(3)).wheels, (4, at.WHEEL))
                       for seed in range(200)])
    radius = tables[:, :, at.W_RADIUS] / RADIUS - 1.0
    # 200 draws: 5 % sigma of a deviation, 2.5 % where four wheels are pooled
    assert np.std(radius) == pytest.approx(0.005, rel=0.15)
    assert np.std(radius - radius.mean(axis=1, keepdims=True)) == pytest.approx(
        0.003 * math.sqrt(3 / 4), rel=0.15)
    assert np.std(tables[:, :, at.W_X] - wheels.x) == pytest.approx(0.002, rel=0.15)
    angle = np.arctan2(tables[:, :, at.W_SIN], tables[:, :, at.W_COS])
    assert np.std(angle - wheels.roller) == pytest.approx(0.005, rel=0.15)
    assert np.ptp(tables[:, :, at.W_PHASE]) > 0.9 * 2 * math.pi / ROLLERS
    again = make_body(wheels, config, np.zeros(3)).wheels
    assert again == make_body(wheels, config, np.zeros(3)).wheels


def test_without_errors_the_true_robot_is_that_of_the_file():
    robot = load_robot(shipped() / 'mecanum4.yaml')
    exact = dataclasses.replace(robot.sim, radius_error=0.0, common_radius_error=0.0,
                                position_error=0.0, roller_error=0.0)
    table = np.reshape(make_body(robot.base, exact, np.zeros(3)).wheels, (4, at.WHEEL))
    assert np.array_equal(table[:, at.W_X], robot.base.x)
    assert np.array_equal(table[:, at.W_RADIUS], robot.base.radius)


# --- the dual-differential platform -----------------------------------------------------------

DUAL = load_robot(shipped() / 'dual_differential.yaml')


def dual_plant(**settings):
    return make_plant(DUAL.base, mass=25.0, friction=1.5, creep_stiffness=1000.0, **settings)


def test_carriers_drive_the_platform_as_the_constraints_say():
    """D12-D14 by hand: platform forwards, hinges at rest; then a turn on the spot."""
    plant = dual_plant()
    set_inputs(plant, at.I_RATE, 6.0)
    plant.advance(2000)
    assert plant.twist == pytest.approx((0.3, 0.0, 0.0), abs=1e-3)
    assert plant.hinge_angles == pytest.approx([0.0, 0.0], abs=1e-3)
    # equal and opposite wheels: each carrier turns about its axle midpoint at 2 r u / (2 b)
    plant = dual_plant()
    set_inputs(plant, at.I_RATE, [-1.0, 1.0, -1.0, 1.0])
    plant.advance(300)
    speed = plant.hinges[at.H_RATE]
    assert speed == pytest.approx(0.05 * 1.0 / 0.12, rel=0.03)
    assert plant.hinges[at.HINGE + at.H_RATE] == pytest.approx(speed, rel=0.01)


def test_a_carrier_that_is_pushed_ahead_of_its_axle_turns_round():
    """Caster law of models.md 4: psi' = -(v/e) sin(beta - psi), e < 0 trails."""
    plant = dual_plant(bearing_torque=0.0, bearing_viscous=0.0, wheel_inertia=1e-5,
                       rotor_inertia=0.0, carrier_inertia=1e-4)
    set_inputs(plant, at.I_FREE, 1.0)
    for carrier in range(2):  # nearly backwards
        plant.hinges[carrier * at.HINGE + at.H_ANGLE] = 2.8
    set_velocity(plant, 0.5, 0.0, 0.0)
    seen, speeds = [], []
    for _ in range(120):
        plant.advance(10)
        seen.append(plant.hinge_angles[0])
        speeds.append(plant.twist[0])
    angle = 2.8
    for value, speed in zip(seen, speeds):  # integrate the law at the true speed
        for _ in range(10):
            angle += 1e-3 * (speed / -0.1) * math.sin(angle)
        assert value == pytest.approx(angle, abs=0.08)  # carriers have some inertia
    assert abs(seen[-1]) < 0.6  # trails now


@pytest.mark.parametrize('direction', [0.0, 0.5, math.pi / 2, 2.5])
def test_locked_tyres_of_carriers_slide_alike_in_every_direction(direction):
    """Friction circle: mu N against the slip, whichever way it points; v^2 / (2 mu g) by hand."""
    mu, speed = 0.3, 1.0
    plant = dual_plant(static_ratio=1.0, mass_height=0.0, carrier_inertia=1e3)
    plant.constants[at.STATIC] = plant.constants[at.KINETIC] = mu
    set_inputs(plant, at.I_JAM, 1.0)
    set_velocity(plant, speed * math.cos(direction), speed * math.sin(direction), 0.0)
    plant.advance(2000)
    x, y, yaw = plant.pose
    distance = speed**2 / (2.0 * mu * 9.80665)
    # 2 %: the shear of the contact builds up first
    assert math.hypot(x, y) == pytest.approx(distance, rel=0.02)
    assert math.atan2(y, x) == pytest.approx(direction, abs=0.02) and abs(yaw) < 0.01
    assert plant.twist == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_carriers_on_oil_spin_their_wheels_and_the_platform_gains_no_more_than_friction_allows():
    plant = dual_plant(static_ratio=1.0, mass_height=0.0)
    plant.constants[at.STATIC] = plant.constants[at.KINETIC] = 0.05
    set_inputs(plant, at.I_RATE, 12.0)  # 0.6 m/s at once
    plant.advance(300)
    assert plant.twist[0] == pytest.approx(0.05 * 9.80665 * 0.3, rel=0.05)
    rates, slip = plant.column(at.T_RATE), plant.column(at.T_SLIP_RATE)
    for rate, slipping in zip(rates, slip):
        assert rate > 10.0
        assert slipping == pytest.approx(rate - plant.twist[0] / 0.05, rel=1e-3)


def test_a_carrier_on_oil_is_pulled_along_by_the_other():
    floor = Floor(patches=(Patch(friction=0.05, centre=[0.3, 0.0], radius=0.25),))
    plant = make_plant(DUAL.base, floor, mass=25.0, friction=1.0)
    set_inputs(plant, at.I_RATE, [-6.0, -6.0, 6.0, 6.0])  # front backwards on oil, rear ahead
    plant.advance(150)
    slip = np.abs(plant.column(at.T_SLIP_RATE))
    assert plant.twist[0] > 0.1
    assert slip[:2].min() > 5.0 and slip[2:].max() < 0.5 * slip[:2].min()


def test_the_shipped_scenario_of_the_carriers_slips_where_its_oil_is():
    scenario = load_scenario('carriers')
    done = run(scenario, DUAL.base, DUAL.encoder, DUAL.imu, DUAL.sim, duration=5.0)
    slip, x = np.abs(done.slip_rate).max(axis=1), done.pose[:, 0]
    assert slip[x < 0.5].max() < 0.2  # rad/s: creep
    assert slip[(x > 1.2) & (x < 2.0)].max() > 5.0


def test_every_shipped_robot_can_be_simulated():
    for path in sorted(shipped().glob('*.yaml')):
        robot = load_robot(path)
        plant = make_plant(robot.base)
        set_inputs(plant, at.I_RATE, 3.0)
        plant.advance(300)
        assert np.all(np.isfinite(plant.part(slice(0, at.STATE)))), path.name
        assert sum(plant.column(at.T_LOAD)) == pytest.approx(12.0 * 9.80665, rel=0.1), path.name
