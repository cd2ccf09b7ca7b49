"""The true robot as tables for the kernel: geometry with its errors, masses, supports, drives.

The true geometry differs from the robot file by errors drawn from the seed (``sim.radius_error``
and its like), as a real robot does; with these at zero it is the geometry of the file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Union

import numpy as np

from mecanum_base.core.kinematics.matrix import effective_roller
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.sim import layout as at
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.motor import Motor, motor_at_wheel
from mecanum_base.sim.randomness import stream

Base = Union[Wheels, Carriers]
STANDARD_GRAVITY = 9.80665  # m/s^2
_WALL_STIFFNESS = 2500.0  # 1/s^2 per kg: force over mass and depth
_WALL_DAMPING = 20.0  # 1/s per kg


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Tables of one robot: W wheel rows (layout.WHEEL), C hinge rows (layout.HINGE)."""

    constants: list[float]
    wheels: list[float]
    hinges: list[float]
    corners: list[float]
    joints: tuple[str, ...]
    max_speed: FloatArray
    motor: Motor

    @property
    def count(self) -> int:
        """Number of wheels W."""
        return len(self.joints)


def make_body(base: Base, config: SimConfig, imu_xyz: FloatArray) -> Body:
    """Draw the true robot of ``config.seed``; ``imu_xyz`` (3,) m is the mount in base_link."""
    hinges: list[list[float]] = []
    if isinstance(base, Wheels):
        rows, max_speed = _wheel_rows(base, config), base.max_speed
    else:
        rows, hinges = _carrier_rows(base, config)
        max_speed = np.repeat(base.max_speed, 2)
    table = np.array(rows)
    centres = table[:, [at.W_X, at.W_Y]].copy()
    for i, row in enumerate(rows):
        if row[at.W_HINGE] >= 0:
            hinge = hinges[int(row[at.W_HINGE])]
            c, s = math.cos(hinge[at.H_ANGLE]), math.sin(hinge[at.H_ANGLE])
            centres[i] = (hinge[at.H_X] + c * row[at.W_X] - s * row[at.W_Y],
                          hinge[at.H_Y] + s * row[at.W_X] + c * row[at.W_Y])
    radius = float(np.mean(table[:, at.W_RADIUS]))
    motor = motor_at_wheel(config, radius, len(rows), max_speed)
    reach = np.max(np.abs(centres), axis=0) + config.bumper
    corners = [v for sx, sy in ((1, 1), (1, -1), (-1, -1), (-1, 1))
               for v in (sx * reach[0], sy * reach[1])]
    return Body(_constants(config, centres, motor, imu_xyz), [v for row in rows for v in row],
                [v for hinge in hinges for v in hinge], [float(v) for v in corners], base.joint,
                max_speed, motor)


def _constants(config: SimConfig, centres: FloatArray, motor: Motor,
               imu_xyz: FloatArray) -> list[float]:
    mass, count = config.mass, len(centres)
    cx, cy = (float(v) for v in config.mass_centre)
    spread = np.mean(centres**2, axis=0)  # m^2, along x and y
    inertia = config.yaw_inertia or mass * float(np.sum(spread)) / 2.0
    stiffness = mass * STANDARD_GRAVITY / (count * config.support_sag)
    damping = 2.0 * config.support_damping * math.sqrt(stiffness * mass / count)
    out = [0.0] * at.BODY
    out[at.MASS], out[at.INERTIA], out[at.CX], out[at.CY] = mass, inertia, cx, cy
    out[at.HEIGHT] = config.mass_height
    height = config.mass_height**2 / 3.0
    out[at.ROLL_INERTIA] = mass * (float(spread[1]) / 2.0 + height)
    out[at.PITCH_INERTIA] = mass * (float(spread[0]) / 2.0 + height)
    out[at.GRAVITY] = STANDARD_GRAVITY
    out[at.SUPPORT_K], out[at.SUPPORT_C] = stiffness, damping
    out[at.STATIC], out[at.KINETIC] = config.friction * config.static_ratio, config.friction
    out[at.STRIBECK] = config.stribeck_speed
    out[at.SIGMA0], out[at.SIGMA1] = config.shear_stiffness, config.shear_damping
    out[at.KAPPA] = config.shear_stiffness / config.creep_stiffness
    out[at.ROLLER_DRAG] = config.roller_drag
    out[at.BEARING], out[at.VISCOUS] = config.bearing_torque, config.bearing_viscous
    out[at.WHEEL_INERTIA] = motor.inertia
    out[at.TORQUE_PER_VOLT], out[at.BACK_EMF] = motor.torque_per_volt, motor.back_emf
    out[at.VOLT_LIMIT], out[at.TORQUE_LIMIT] = motor.volt_limit, motor.torque_limit
    out[at.KP], out[at.KI] = motor.gain, motor.integral_gain
    out[at.IMU_X], out[at.IMU_Y] = float(imu_xyz[0]) - cx, float(imu_xyz[1]) - cy
    out[at.IMU_Z] = float(imu_xyz[2]) - config.mass_height
    out[at.IMU_FILTER] = 1.0
    out[at.WALL_K], out[at.WALL_C] = _WALL_STIFFNESS * mass, _WALL_DAMPING * mass
    return out


def _radii(nominal: FloatArray, config: SimConfig) -> FloatArray:
    draw = stream(config.seed, 'radius').standard_normal(len(nominal) + 1)
    radii: FloatArray = nominal * (1.0 + config.common_radius_error * draw[0]
                                   + config.radius_error * draw[1:])
    return radii


def _row(config: SimConfig, index: int, x: float, y: float, axle: float, radius: float,
         ) -> list[float]:
    draw = stream(config.seed, f'wheel {index}')
    errors = draw.standard_normal(2) * config.position_error
    row = [0.0] * at.WHEEL
    row[at.W_X], row[at.W_Y] = x + float(errors[0]), y + float(errors[1])
    row[at.W_AX], row[at.W_AY] = math.cos(axle), math.sin(axle)
    row[at.W_COS], row[at.W_SIN] = 0.0, 1.0
    row[at.W_RADIUS] = radius
    row[at.W_RUNOUT] = config.runout
    row[at.W_RUNOUT_PHASE] = float(draw.random()) * 2.0 * math.pi
    row[at.W_HINGE] = -1.0
    return row


def _wheel_rows(wheels: Wheels, config: SimConfig) -> list[list[float]]:
    nominal = effective_roller(wheels) if config.contact == 'mean' else wheels.roller
    radii = _radii(wheels.radius, config)
    rows = []
    for i in range(wheels.count):
        row = _row(config, i, float(wheels.x[i]), float(wheels.y[i]), float(wheels.axle[i]),
                   float(radii[i]))
        draw = stream(config.seed, f'roller {i}')
        angle = float(nominal[i]) + config.roller_error * float(draw.standard_normal())
        row[at.W_COS], row[at.W_SIN] = math.cos(angle), math.sin(angle)
        rollers = int(wheels.roller_count[i])
        if config.contact == 'exact' and rollers:
            row[at.W_PITCH] = 2.0 * math.pi / rollers
            row[at.W_PHASE] = float(draw.random()) * row[at.W_PITCH]
            row[at.W_REACH] = float(wheels.roller_pin_radius[i]) * math.cos(angle) / math.sin(
                angle)
        rows.append(row)
    return rows


def _carrier_rows(carriers: Carriers, config: SimConfig,
                  ) -> tuple[list[list[float]], list[list[float]]]:
    rows, hinges = [], []
    radii = _radii(np.repeat(carriers.wheel_radius, 2), config)
    for c in range(len(carriers.name)):
        hinge = [0.0] * at.HINGE
        hinge[at.H_X], hinge[at.H_Y] = float(carriers.x[c]), float(carriers.y[c])
        hinge[at.H_INERTIA] = config.carrier_inertia
        hinge[at.H_ANGLE] = float(carriers.initial_angle[c])
        hinges.append(hinge)
        for k, side in enumerate((1.0, -1.0)):
            row = _row(config, 2 * c + k, float(carriers.axle_offset[c]),
                       side * float(carriers.half_track[c]), math.pi / 2.0,
                       float(radii[2 * c + k]))
            row[at.W_TYRE], row[at.W_HINGE] = 1.0, float(c)
            rows.append(row)
    return rows, hinges
