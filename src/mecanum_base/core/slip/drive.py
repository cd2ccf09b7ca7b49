"""What of a motor rate acts along the roller axis (T eq. 1, 3).

    T1   q_eff = n q_m sin(delta)         n = wheel rate / motor rate, q_w = n q_m      [rad/s]
    T3   e = q_eff / (n q_m) = sin(delta)      0 = rollers parallel to the axle, 1 = Swedish wheel

r q_eff is the rim speed along the roller axis. It is not the speed of travel: straight ahead the
base runs at r n q_m for any delta.
"""

from __future__ import annotations

import math


def wheel_rate(motor_rate: float, gear_factor: float) -> float:
    """Shaft rate of the wheel [rad/s]; ``gear_factor`` n = wheel rate / motor rate (T1)."""
    return gear_factor * motor_rate


def effective_rate(motor_rate: float, gear_factor: float, roller: float) -> float:
    """Rim rate along the roller axis [rad/s], ``roller`` rad from the axle (T1)."""
    return wheel_rate(motor_rate, gear_factor) * math.sin(roller)  # T eq. 1


def effectiveness(roller: float) -> float:
    """e = sin(delta) of a roller angle in rad (T3)."""
    return math.sin(roller)  # T eq. 3
