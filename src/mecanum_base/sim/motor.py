"""DC motors behind a gear, under a PI speed loop, seen from the wheel.

    torque  tau = k G i,   i = (U - k G u) / R,   |U| <= U_max,  |i| <= i_max     [N m, A, V]
    loop    U = k G u_ref + K_p (u_ref - u) + K_i integral(u_ref - u)
    inertia J = J_wheel + G^2 J_rotor at the wheel

K_p and K_i follow from the wanted bandwidth w_c and the inertia the wheel moves (its own and its
share of the robot): K_p k G / R = w_c J_total, K_i = K_p w_c / 4 (damping ratio 1); the back-EMF
of the wanted rate is fed forward. Not modelled: winding inductance, gear backlash, heat.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.parameter import FloatArray
from mecanum_base.sim.config import SimConfig

_SPARE = 1.3  # no-load speed over the largest wanted speed, where the gear ratio is left open
_USUAL_SPEED = 20.0  # rad/s, where no max_speed is given


@dataclass(frozen=True, slots=True)
class Motor:
    """Constants at the wheel: inertia, N m/V, V s/rad, limits and loop gains."""

    gear: float
    inertia: float
    torque_per_volt: float
    back_emf: float
    volt_limit: float
    torque_limit: float
    gain: float
    integral_gain: float


def motor_at_wheel(config: SimConfig, radius: float, count: int, max_speed: FloatArray) -> Motor:
    """The drive of one wheel of radius [m] out of ``count``; ``max_speed`` (W,) rad/s."""
    finite = [float(v) for v in max_speed if np.isfinite(v)]
    fastest = max(finite) if finite else _USUAL_SPEED
    gear = config.gear_ratio or config.supply_voltage / (config.motor_constant * _SPARE * fastest)
    constant = config.motor_constant * gear
    inertia = config.wheel_inertia + gear * gear * config.rotor_inertia
    moved = inertia + config.mass * radius * radius / count
    per_volt = constant / config.motor_resistance
    gain = config.loop_bandwidth * moved / per_volt
    return Motor(gear, inertia, per_volt, constant, config.supply_voltage,
                 constant * config.current_limit, gain, gain * config.loop_bandwidth / 4.0)
