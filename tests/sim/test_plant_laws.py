"""The plant against laws of mechanics and results worked out by hand."""

from __future__ import annotations

import pathlib
import sys

import numpy as np
import pytest

from mecanum_base.sim import layout as at
from mecanum_base.sim.floor import Floor, Patch, Ramp, Wall

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from plants import (
    LX,
    LY,
    RADIUS,
    G,
    four_wheels,
    make_plant,
    ring,
    set_inputs,
    set_velocity,
)

MASS = 12.0


def test_a_free_body_with_offset_mass_centre_keeps_its_world_momentum():
    plant = make_plant(friction=0.0, roller_drag=0.0, mass_centre=(0.07, -0.04),
                       mass_height=0.0)
    set_inputs(plant, at.I_FREE, 1.0)
    set_velocity(plant, 0.6, -0.3, 1.7)
    before = [plant.state[k] for k in (at.S_VX, at.S_VY, at.S_W)]
    start = np.array([plant.state[at.S_X], plant.state[at.S_Y]])
    plant.advance(2000)
    after = [plant.state[k] for k in (at.S_VX, at.S_VY, at.S_W)]
    assert after == pytest.approx(before, abs=1e-12)  # rounding of 2000 rotations
    # the mass centre moves in a straight line while base_link circles around it
    end = np.array([plant.state[at.S_X], plant.state[at.S_Y]])
    assert end - start == pytest.approx([1.2, -0.6], abs=1e-9)
    yaw = 1.7 * 2.0
    arm = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]) @ [0.07, -0.04]
    assert np.array(plant.pose[:2]) == pytest.approx(end - arm, abs=1e-9)


def test_free_motion_agrees_with_the_equations_about_the_geometric_centre():
    """models.md 1.3 written about O, integrated by Runge-Kutta, no code of the simulator."""
    cx, cy, inertia = 0.08, 0.05, 0.3
    plant = make_plant(friction=0.0, roller_drag=0.0, mass_centre=(cx, cy), yaw_inertia=inertia)
    set_inputs(plant, at.I_FREE, 1.0)
    force = np.array([5.0, -3.0, 0.4])  # at the mass centre, body axes
    plant.push[0], plant.push[1], plant.push[2] = force
    about_o = inertia + MASS * (cx * cx + cy * cy)
    matrix = np.array([[MASS, 0, -MASS * cy], [0, MASS, MASS * cx],
                       [-MASS * cy, MASS * cx, about_o]])
    moment = force[2] + cx * force[1] - cy * force[0]

    def rate(state):
        vx, vy, w = state[3:]
        c = MASS * w * np.array([-vy - cx * w, vx - cy * w, cx * vx + cy * vy])
        accel = np.linalg.solve(matrix, np.array([force[0], force[1], moment]) - c)
        cos, sin = np.cos(state[2]), np.sin(state[2])
        return np.array([cos * vx - sin * vy, sin * vx + cos * vy, w, *accel])

    state, dt = np.zeros(6), 1e-3
    for _ in range(1500):
        k1 = rate(state)
        k2 = rate(state + dt / 2 * k1)
        k3 = rate(state + dt / 2 * k2)
        k4 = rate(state + dt * k3)
        state = state + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    plant.advance(1500)
    # first order in the step: half a step of acceleration is 0.2 mm/s here
    assert np.array(plant.twist) == pytest.approx(state[3:], abs=2e-3)
    assert np.array(plant.pose) == pytest.approx(state[:3], abs=2e-3)


def energy(plant):
    """Kinetic energy of base and wheels plus the energy stored in sheared contacts [J]."""
    state, c = plant.state, plant.constants
    total = 0.5 * c[at.MASS] * (state[at.S_VX] ** 2 + state[at.S_VY] ** 2)
    total += 0.5 * c[at.INERTIA] * state[at.S_W] ** 2
    for rate, load, shear in zip(plant.column(at.T_RATE), plant.column(at.T_LOAD),
                                 plant.column(at.T_SHEAR)):
        total += 0.5 * c[at.WHEEL_INERTIA] * rate**2 + 0.5 * load * c[at.SIGMA0] * shear**2
    return total


def energy_account(step):
    """(motor work, stored, lost in contacts, lost in bearings) of one hard manoeuvre [J]."""
    plant = make_plant(four_wheels(9, 0.038), step=step, contact='exact', mass_height=0.0,
                       friction=0.5)
    steps, begin = round(0.5 / step), energy(plant)
    work = contact = bearing = 0.0
    for goal in ([18, 4, 9, -12], [-6, 6, 15, 15], [0, 0, 0, 0]):
        set_inputs(plant, at.I_RATE, goal)
        for _ in range(steps):
            shear = plant.column(at.T_SHEAR)
            old = plant.column(at.T_RATE)
            plant.advance(1)
            for i, rate in enumerate(plant.column(at.T_RATE)):
                t = i * at.TURN
                work += step * plant.turn[t + at.T_TORQUE] * rate
                bearing += step * rate * rate * (0.002 + 0.03 / np.hypot(old[i], 0.05))
                lost = -(plant.turn[t + at.T_FORCE] * plant.turn[t + at.T_SLIP]
                         + plant.turn[t + at.T_FORCE_SIDE] * plant.turn[t + at.T_SLIP_SIDE]) * step
                # what the contact takes is lost except for what its shear stores
                stored = 0.5 * plant.turn[t + at.T_LOAD] * 2000.0 * (
                    plant.turn[t + at.T_SHEAR] ** 2 - shear[i] ** 2)
                contact += lost - stored
    return work, energy(plant) - begin, contact, bearing


def test_energy_balances_over_a_hard_manoeuvre_and_better_with_smaller_steps():
    residual = []
    for step in (1e-3, 5e-4, 2.5e-4):
        work, stored, contact, bearing = energy_account(step)
        assert work > 10.0 and contact > 1.0 and bearing > 1.0  # the run is a real one
        residual.append((work - stored - contact - bearing) / work)
    # the implicit step itself damps a little (never drives), and less with smaller steps
    assert all(0.0 <= r < 0.03 for r in residual)
    assert residual[0] > 1.8 * residual[1] > 1.8 * 1.8 * residual[2]


def test_the_result_converges_with_the_step_size():
    def end(step):
        plant = make_plant(four_wheels(9, 0.038), step=step, contact='exact', friction=0.4)
        for goal in ([12, 3, 8, -2], [-5, 12, 12, -5], [0, 0, 0, 0]):
            set_inputs(plant, at.I_RATE, goal)
            plant.advance(round(0.4 / step))
        return np.array(plant.pose)

    reference = end(6.25e-5)
    error = [np.linalg.norm(end(step) - reference) for step in (2e-3, 1e-3, 5e-4)]
    assert error[1] < 1e-3  # 1 kHz is good to a millimetre over this 0.5 m manoeuvre
    assert error[0] > 1.5 * error[1] > 1.5 * 1.5 * error[2]  # first order


def test_a_spinning_wheel_reaches_the_speed_worked_out_by_hand():
    plant = make_plant(friction=0.0, roller_drag=0.0, gear_ratio=20.0)
    set_inputs(plant, at.I_RATE, 1000.0)  # full voltage
    plant.advance(4000)
    constant = 0.03 * 20.0  # N m/A at the wheel
    # constant/R (24 V - constant u) = 0.03 N m + 0.002 u
    by_hand = (constant / 0.8 * 24.0 - 0.03) / (constant * constant / 0.8 + 0.002)
    assert plant.column(at.T_RATE) == pytest.approx([by_hand] * 4, rel=1e-4)


def test_a_pushed_base_with_free_wheels_reaches_the_speed_worked_out_by_hand():
    plant = make_plant(creep_stiffness=1000.0, bearing_viscous=0.02)
    set_inputs(plant, at.I_FREE, 1.0)
    plant.push[0] = 14.0
    plant.advance(6000)
    # 14 N x 0.05 m = 4 wheels x (0.03 + 0.02 u); rollers stand still when driving forward
    rate = (14.0 * RADIUS / 4.0 - 0.03) / 0.02
    assert plant.twist[0] == pytest.approx(rate * RADIUS, rel=0.002)  # 6 s = 8 time constants
    assert plant.twist[1:] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_constant_torque_accelerates_as_mass_and_reflected_inertia_say():
    plant = make_plant(current_limit=0.5, gear_ratio=20.0, rotor_inertia=1e-6,
                       bearing_torque=0.0, bearing_viscous=0.0, creep_stiffness=1000.0)
    set_inputs(plant, at.I_RATE, 18.0)
    plant.advance(500)
    torque = 0.03 * 20.0 * 0.5
    inertia = 6e-4 + 400 * 1e-6
    by_hand = 4.0 * torque / RADIUS / (MASS + 4.0 * inertia / RADIUS**2)  # T5-T12, no slip
    assert plant.twist[0] / 0.5 == pytest.approx(by_hand, rel=0.005)  # 0.5 %: creep


def test_locked_wheels_stop_on_a_patch_in_the_distance_worked_out_by_hand():
    mu, drag, speed = 0.25, 0.015, 1.2
    floor = Floor(patches=(Patch(friction=mu, x=[-5.0, 5.0], y=[-5.0, 5.0], static_ratio=1.0),))
    plant = make_plant(floor=floor, mass_height=0.0)
    set_inputs(plant, at.I_JAM, 1.0)
    set_velocity(plant, speed, 0.0, 0.0)
    plant.advance(3000)
    # each roller passes mu N along its axis at 45 degrees and its drag across it
    decel = G * (mu + drag) / np.sqrt(2.0)
    assert plant.twist == pytest.approx((0.0, 0.0, 0.0), abs=1e-4)
    assert plant.pose[0] == pytest.approx(speed**2 / (2.0 * decel), rel=0.01)


def test_the_edge_of_a_patch_changes_the_friction_where_it_lies():
    floor = Floor(patches=(Patch(friction=0.05, centre=[1.0, 0.0], radius=0.5),))
    plant = make_plant(floor=floor, mass_height=0.0)
    set_inputs(plant, at.I_JAM, 1.0)
    set_velocity(plant, 0.5, 0.0, 0.0)
    plant.advance(1)
    grip = sum(abs(f) for f in plant.column(at.T_FORCE))
    plant.state[at.S_X], plant.state[at.S_VX] = 1.0, 0.5
    plant.advance(30)
    assert sum(abs(f) for f in plant.column(at.T_FORCE)) < 0.3 * max(grip, 0.05 * MASS * G * 4)
    assert sum(abs(f) for f in plant.column(at.T_FORCE)) == pytest.approx(0.05 * MASS * G,
                                                                         rel=0.12)


def test_locked_wheels_break_away_at_the_static_limit():
    limit = 0.5 * 1.2 * MASS * G / np.sqrt(2.0)
    for share, moves in ((0.95, False), (1.05, True)):
        plant = make_plant(friction=0.5, static_ratio=1.2, mass_height=0.0)
        set_inputs(plant, at.I_JAM, 1.0)
        for k in range(200):  # the force rises slowly enough not to overshoot
            plant.push[0] = limit * share * (k + 1) / 200
            plant.advance(10)
        plant.advance(500)
        assert (plant.pose[0] > 0.05) == moves


def test_creep_is_proportional_to_force_and_speed():
    plant = make_plant(creep_stiffness=20.0, mass_height=0.0, roller_drag=0.0)
    set_inputs(plant, at.I_RATE, 8.0)
    plant.push[0] = -12.0  # a load dragged along
    plant.advance(3000)
    speed = plant.twist[0]
    load = MASS * G / 4.0
    force = 12.0 / 4.0 * np.sqrt(2.0)  # along the roller axis, plus nothing for free rollers
    for slip, along in zip(plant.column(at.T_SLIP), plant.column(at.T_FORCE)):
        assert abs(along) == pytest.approx(force, rel=1e-3)
        # z' = 0: s = (s^2 (sigma0/mu)^2 + (kappa v)^2)^(1/2) f/(N sigma0)
        share = force / (0.72 * load)
        by_hand = force / load / 20.0 * speed / np.sqrt(1.0 - share**2)
        assert abs(slip) == pytest.approx(by_hand, rel=0.01)


def test_loads_follow_from_mass_centre_and_moment_balance():
    cx, cy = 0.05, -0.03
    plant = make_plant(mass_centre=(cx, cy))
    plant.advance(1000)
    share = MASS * G / 4.0
    by_hand = [share * (1 + sx * cx / LX + sy * cy / LY)
               for sx, sy in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
    assert plant.column(at.T_LOAD) == pytest.approx(by_hand, rel=1e-3)


def test_a_push_at_the_height_of_the_mass_centre_shifts_the_loads():
    height, force = 0.3, 20.0
    plant = make_plant(mass_height=height)
    plant.push[0] = force
    plant.advance(3000)
    shift = force * height / (4.0 * LX)
    share = MASS * G / 4.0
    assert plant.column(at.T_LOAD) == pytest.approx(
        [share + shift, share + shift, share - shift, share - shift], rel=2e-3)


def test_a_mass_centre_far_out_lifts_one_wheel_and_three_carry():
    cx, cy = 0.16, 0.06  # |cx|/lx + |cy|/ly > 1: the wheel opposite is in the air
    plant = make_plant(mass_centre=(cx, cy), support_damping=1.0)
    plant.advance(4000)
    loads = plant.column(at.T_LOAD)
    weight = MASS * G
    front = weight * (1 + cx / LX) / 2.0  # balance about the rear axle
    left = weight * (1 + cy / LY) / 2.0
    rear_left = weight - front  # rear right carries nothing
    assert loads == pytest.approx([left - rear_left, weight - left, rear_left, 0.0], abs=0.05)


def test_three_wheels_carry_what_balance_demands():
    plant = make_plant(ring(3), mass_centre=(0.04, 0.0))
    plant.advance(1000)
    weight = MASS * G
    first = weight * (0.04 + 0.1) / 0.3  # about the line through wheels 1 and 2 at x = -0.1
    rest = (weight - first) / 2.0
    assert plant.column(at.T_LOAD) == pytest.approx([first, rest, rest], rel=1e-3)


@pytest.mark.parametrize('share, slides', [(0.9, False), (1.5, True)])
def test_a_braked_base_holds_on_a_slope_up_to_the_friction_angle(share, slides):
    mu = 0.4
    angle = np.arctan(share * mu / np.sqrt(2.0))
    plant = make_plant(floor=Floor(slope=angle), friction=mu, static_ratio=1.0, mass_height=0.0)
    set_inputs(plant, at.I_JAM, 1.0)
    plant.advance(1000)
    decel = G * np.cos(angle) * (mu + 0.015) / np.sqrt(2.0)
    if slides:
        expected = -0.5 * (G * np.sin(angle) - decel)
        assert plant.pose[0] == pytest.approx(expected, rel=0.03)
        assert plant.pose[0] < -0.05
    else:
        assert abs(plant.pose[0]) < 1e-3
        assert abs(plant.twist[0]) < 1e-4


def test_a_ramp_pulls_with_its_grade():
    floor = Floor(ramps=(Ramp(begin=1.0, end=4.0, grade=0.05),))
    plant = make_plant(floor=floor, friction=0.0, roller_drag=0.0, mass_height=0.0)
    set_inputs(plant, at.I_FREE, 1.0)
    plant.state[at.S_X], plant.state[at.S_HEAVE] = 2.5, plant.state[at.S_HEAVE] + 1.5 * 0.05
    plant.state[at.S_PITCH] = -0.05
    plant.advance(400)
    before = plant.state[at.S_VX]
    plant.advance(600)
    assert (plant.state[at.S_VX] - before) / 0.6 == pytest.approx(-0.05 * G, rel=0.01)


def test_a_wall_stops_the_base_and_the_wheels_spin_on():
    plant = make_plant(floor=Floor(walls=(Wall(point=[0.8, 0.0], facing=np.pi),)), friction=0.2)
    set_inputs(plant, at.I_RATE, 10.0)
    plant.advance(3000)
    assert plant.pose[0] == pytest.approx(0.8 - LX - 0.06, abs=0.02)
    assert abs(plant.twist[0]) < 0.01
    assert min(plant.column(at.T_RATE)) > 9.0
    assert min(plant.column(at.T_SLIP_RATE)) > 9.0  # all wheels slip at their full rate


def test_a_hole_below_a_wheel_takes_its_load():
    plant = make_plant(mass_centre=(-0.02, 0.0))
    plant.inputs[at.I_DROP] = 0.01
    plant.advance(2000)
    loads = plant.column(at.T_LOAD)
    assert loads[0] == 0.0
    assert sum(loads) == pytest.approx(MASS * G, rel=0.02)


@pytest.mark.parametrize('twist', [(0.3, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 0.9),
                                   (0.2, -0.15, 0.5)])
def test_with_high_friction_the_base_moves_as_no_slip_says(twist):
    """Rates from the printed listing for a 45 degree rectangle (R), not from the code."""
    vx, vy, w = twist
    rates = np.array([vx - vy - (LX + LY) * w, vx + vy + (LX + LY) * w,
                      vx + vy - (LX + LY) * w, vx - vy + (LX + LY) * w]) / RADIUS
    plant = make_plant(friction=2.0, creep_stiffness=1000.0, roller_drag=0.001,
                       bearing_torque=0.0)
    set_inputs(plant, at.I_RATE, rates)
    plant.advance(3000)
    assert np.array(plant.twist) == pytest.approx(twist, abs=2e-4)


@pytest.mark.parametrize('count', [3, 4, 6, 8])
def test_rings_of_any_number_of_wheels_drive_where_they_should(count):
    base = ring(count)
    plant = make_plant(base, friction=1.5, creep_stiffness=1000.0, roller_drag=0.001)
    vx, vy, w = 0.2, 0.1, 0.4
    # axle outwards at angle a: it rolls along -tangent, r u = -(-vx sin a + vy cos a + L w)
    angles = 2.0 * np.pi * np.arange(count) / count
    set_inputs(plant, at.I_RATE, -(-vx * np.sin(angles) + vy * np.cos(angles) + 0.2 * w) / 0.05)
    plant.advance(1500)
    assert np.array(plant.twist) == pytest.approx([vx, vy, w], abs=5e-4)


def test_the_plant_stays_finite_at_extreme_stiffness_and_load():
    plant = make_plant(shear_stiffness=1e5, shear_damping=0.0, creep_stiffness=1000.0, mass=400.0,
                       loop_bandwidth=500.0, friction=3.0, step=2e-3, wheel_inertia=1e-5)
    for goal in (20.0, -20.0, 20.0, 0.0):
        set_inputs(plant, at.I_RATE, [goal, -goal, goal, goal])
        plant.advance(250)
        assert np.all(np.isfinite(plant.state))
        assert np.max(np.abs(plant.twist)) < 5.0
