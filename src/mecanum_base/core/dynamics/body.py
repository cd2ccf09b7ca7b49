"""Mass properties of a base and its drive train, as the equations of motion use them.

    M = [[m, 0, -m cy], [0, m, m cx], [-m cy, m cx, I_O]],     I_O = I_C + m |c|^2
    C(V) = m w (-vy - cx w, vx - cy w, cx vx + cy vy)

c = mass centre from the geometric centre O. M V' + C(V) = wrench at O, all in base_link: T15 holds
about O only with these coupling terms (models.md 1.3, checked against Lagrange's equations).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray, frozen_floats


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """``mass`` kg, ``inertia`` about the mass centre kg m^2, ``mass_centre`` (2,) m from O.

    ``height`` m of the mass centre over the floor. Raises ConfigError where mass or inertia is
    not positive.
    """

    mass: float
    inertia: float
    mass_centre: FloatArray = field(default_factory=lambda: np.zeros(2))
    height: float = 0.0

    def __post_init__(self) -> None:
        for key, unit in (('mass', 'kg'), ('inertia', 'kg m^2')):
            if not getattr(self, key) > 0.0:
                raise ConfigError(key, getattr(self, key), 'must be > 0', unit)
        object.__setattr__(self, 'mass_centre', frozen_floats(self.mass_centre))


@dataclass(frozen=True, slots=True)
class DriveTrain:
    """One wheel with motor and gear, at the wheel shaft (T eq. 5 corrected).

    ``inertia`` Iw kg m^2, ``viscous`` mu_v N m s/rad, ``coulomb`` tau_c N m.
    """

    inertia: float = 0.0
    viscous: float = 0.0
    coulomb: float = 0.0

    def loss(self, rates: FloatArray) -> FloatArray:
        """Torque (W,) N m that friction takes at wheel rates (W,) rad/s."""
        torque: FloatArray = self.viscous * rates + self.coulomb * np.sign(rates)
        return torque

    def torque(self, rates: FloatArray, accelerations: FloatArray,
               ground_torques: FloatArray) -> FloatArray:
        """Shaft torque (W,) N m: Iw q'' + mu_v q' + tau_c sign q' + r F_roll (T5 corrected)."""
        total: FloatArray = self.inertia * accelerations + self.loss(rates) + ground_torques
        return total


def mass_matrix(body: Body) -> FloatArray:
    """M (3, 3) of the base alone about O [kg, kg m, kg m^2]."""
    m, (cx, cy) = body.mass, body.mass_centre
    about_centre = body.inertia + m * (cx * cx + cy * cy)  # I_O = I_C + m |c|^2
    return np.array([[m, 0.0, -m * cy], [0.0, m, m * cx], [-m * cy, m * cx, about_centre]])


def coriolis(body: Body, twist: FloatArray) -> FloatArray:
    """C(V) (3,) N, N, N m at the twist (3,)."""
    vx, vy, w = (float(value) for value in twist)
    cx, cy = body.mass_centre
    return body.mass * w * np.array([-vy - cx * w, vx - cy * w, cx * vx + cy * vy])


def mass_centre_acceleration(body: Body, twist: FloatArray, twist_rate: FloatArray) -> FloatArray:
    """(ax, ay) m/s^2 of the mass centre in base_link: what shifts the wheel loads."""
    force: FloatArray = (mass_matrix(body) @ twist_rate + coriolis(body, twist))[:2]
    return force / body.mass
