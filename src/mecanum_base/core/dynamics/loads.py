"""How the weight of the base rests on its wheels, mass centre off the middle (T eq. 14).

    bilinear    N_i = m g (1 - e_i/y)(1 - d_i/x)        T14 with g and without the bracket error;
                e_i, d_i = distances of the mass centre from wheel i along and across the base
    springs     minimum-norm N with sum N = m g, sum N x = m (g cx - h ax), sum N y = m (g cy
                - h ay): equal stiffness under every wheel of a rigid base on a flat floor

Both satisfy all balances; four supports are one-fold hyperstatic and the two differ by
(m g / 4) (cx cy / (lx ly)) on the diagonals. The bilinear one is positive for a mass centre inside
the rectangle, the spring one lifts a wheel (N < 0) when |cx|/lx + |cy|/ly > 1. Acceleration (ax,
ay) of the mass centre at height h acts as a shift of the mass centre by -h a / g. Friction can
hold mu N (T14). Three wheels leave no choice.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray

GRAVITY = 9.80665  # m/s^2


def _pressure_centre(mass_centre: FloatArray, height: float, acceleration: FloatArray | None,
                     gravity: float) -> FloatArray:
    if acceleration is None:
        return np.asarray(mass_centre, dtype=np.float64)
    shifted: FloatArray = np.asarray(mass_centre) - height * np.asarray(acceleration) / gravity
    return shifted


def bilinear_loads(half_wheelbase: float, half_track: float, mass: float,
                   mass_centre: FloatArray, *, height: float = 0.0,
                   acceleration: FloatArray | None = None,
                   gravity: float = GRAVITY) -> FloatArray:
    """Loads (4,) N of FL, FR, RL, RR (T14 corrected); ConfigError outside the rectangle.

    ``mass_centre`` (2,) m from the geometric centre, ``acceleration`` (2,) m/s^2 in base_link.
    """
    cx, cy = _pressure_centre(mass_centre, height, acceleration, gravity)
    if abs(cx) > half_wheelbase or abs(cy) > half_track:
        raise ConfigError('mass_centre', [float(cx), float(cy)], 'must lie between the wheels '
                          f'(+-{half_wheelbase:g}, +-{half_track:g}), shift by acceleration '
                          'included', 'm')
    front = np.array([1.0, 1.0, -1.0, -1.0])
    left = np.array([1.0, -1.0, 1.0, -1.0])
    loads: FloatArray = (0.25 * mass * gravity * (1.0 + front * cx / half_wheelbase)
                         * (1.0 + left * cy / half_track))  # T eq. 14 corrected
    return loads


def spring_loads(contacts: FloatArray, mass: float, mass_centre: FloatArray, *,
                 height: float = 0.0, acceleration: FloatArray | None = None,
                 gravity: float = GRAVITY) -> FloatArray:
    """Loads (W,) N at ``contacts`` (W, 2) m, W >= 3, equal stiffness; negative = lift-off.

    Raises ConfigError where the contacts lie on one line.
    """
    rows = _balance(contacts)
    cx, cy = _pressure_centre(mass_centre, height, acceleration, gravity)
    loads: FloatArray = np.linalg.pinv(rows) @ (mass * gravity * np.array([1.0, cx, cy]))
    return loads


def _balance(contacts: FloatArray) -> FloatArray:
    rows = np.vstack([np.ones(len(contacts)), np.asarray(contacts).T])
    if np.linalg.matrix_rank(rows) < 3:
        raise ConfigError('contacts', np.asarray(contacts).tolist(),
                          'must not lie on one line: the base would tip', 'm')
    return rows


def hyperstatic_patterns(contacts: FloatArray) -> FloatArray:
    """Orthonormal rows (W - 3, W) that keep all balances: (1, -1, -1, 1)/2 for a rectangle."""
    rows = _balance(contacts)
    patterns: FloatArray = np.linalg.svd(rows)[2][3:]
    return patterns


def friction_limits(loads: FloatArray, friction: float) -> FloatArray:
    """(W,) N: largest ground force of each wheel, mu N; 0 for a lifted wheel (T14)."""
    limit: FloatArray = friction * np.maximum(loads, 0.0)
    return limit
