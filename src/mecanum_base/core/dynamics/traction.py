"""Does a wheel ask more of the ground than friction gives? Valid range of the no-slip equations.

A wheel holds while its force along the roller axis stays within the friction of its load,
|f_i| <= mu N_i with f_i = r F_roll,i / (r sin(delta)) (T6 corrected, T14). Loads follow the
acceleration of the mass centre. Beyond that the wheel slips and the equations of motion do not
hold; the saturation is reported, never hidden.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.dynamics.body import Body, DriveTrain, mass_centre_acceleration
from mecanum_base.core.dynamics.forces import roller_forces
from mecanum_base.core.dynamics.loads import GRAVITY, friction_limits, spring_loads
from mecanum_base.core.dynamics.motion import forward_dynamics, ground_torques
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Traction:
    """Of each wheel: ``force`` N along +b, ``load`` N, ``limit`` N, ``use`` = |force|/limit (W,).

    ``slips`` (W,) bool where use > 1 (a lifted wheel that is driven slips too); ``lifted`` (W,)
    bool where the load is not positive.
    """

    force: FloatArray
    load: FloatArray
    limit: FloatArray
    use: FloatArray
    slips: tuple[bool, ...]
    lifted: tuple[bool, ...]

    def text(self, names: tuple[str, ...]) -> str:
        """One sentence for people, wheels by name."""
        parts = [f'{name} slips (asks {self.use[i]:.2f} of its friction)'
                 for i, name in enumerate(names) if self.slips[i]]
        parts += [f'{name} is lifted' for i, name in enumerate(names) if self.lifted[i]]
        if parts:
            return 'not valid: ' + ', '.join(parts)
        return f'all wheels hold, at most {float(np.max(self.use)):.2f} of the friction is used'


def judge(force: FloatArray, load: FloatArray, friction: float) -> Traction:
    """Compare forces (W,) N along the rollers with the friction of the loads (W,) N."""
    limit = friction_limits(load, friction)
    with np.errstate(divide='ignore', invalid='ignore'):
        use = np.where(limit > 0.0, np.abs(force) / limit, np.where(force != 0.0, np.inf, 0.0))
    return Traction(force, load, limit, use, tuple(bool(v > 1.0) for v in use),
                    tuple(bool(v <= 0.0) for v in load))


def judge_torques(wheels: Wheels, body: Body, train: DriveTrain, twist: FloatArray,
                  torques: FloatArray, friction: float, *,
                  gravity: float = GRAVITY) -> tuple[FloatArray, Traction]:
    """(V' (3,) without slip, traction) for wheel torques (W,) N m at the twist (3,)."""
    rate = forward_dynamics(wheels, body, train, twist, torques)
    ground = ground_torques(wheels, train, twist, rate, torques)
    load = spring_loads(np.column_stack([wheels.x, wheels.y]), body.mass, body.mass_centre,
                        height=body.height, gravity=gravity,
                        acceleration=mass_centre_acceleration(body, twist, rate))
    return rate, judge(roller_forces(wheels, ground), load, friction)
