"""From encoder pulses to wheel rates (T eq. 2, corrected: no wheel radius in C).

    q_w = C dm / dT,     C = 2 pi / (pulses per revolution * quadrature * G),   G = motor / wheel

C [rad per count] times the radius would be a speed; the quantum of the rate is C/dT, of the rim
travel r C.
"""

from __future__ import annotations

import math

from mecanum_base.core.errors import ConfigError


def counts_per_wheel_turn(pulses: float, quadrature: float, gear_ratio: float) -> float:
    """Counts per revolution of the wheel; ``gear_ratio`` G = motor rate / wheel rate."""
    for key, value in (('pulses', pulses), ('quadrature', quadrature), ('gear_ratio', gear_ratio)):
        if not value > 0.0:
            raise ConfigError(key, value, 'must be > 0')
    return pulses * quadrature * gear_ratio


def encoder_constant(pulses: float, quadrature: float = 4.0, gear_ratio: float = 1.0) -> float:
    """C [rad per count] at the wheel (T2); ConfigError where a factor is not positive."""
    return 2.0 * math.pi / counts_per_wheel_turn(pulses, quadrature, gear_ratio)  # T eq. 2


def rate_from_counts(counts: float, interval: float, constant: float) -> float:
    """Wheel rate [rad/s] from ``counts`` in ``interval`` s (T2)."""
    return constant * counts / interval  # T eq. 2
