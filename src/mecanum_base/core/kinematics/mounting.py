"""Were the rollers mounted the wrong way round? Left and right wheels of a set look alike.

Mirrored rollers change the sign of every delta. A rectangular base then keeps its translations
but its yaw lever falls from lx cot(delta) + ly to |ly - lx cot(delta)|: a square 45-degree base
loses yaw altogether, all roller axes meet in its centre (G Theorem 2, models.md section 3).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

SUSPICIOUS = 1.5  # the mirrored set turns this much better: worth a warning


@dataclass(frozen=True, slots=True)
class Mounting:
    """Mean yaw lever as mounted and with all rollers mirrored [m]; ``suspicious`` = swap them?"""

    lever: float
    mirrored_lever: float
    suspicious: bool

    def text(self) -> str:
        """One sentence for people."""
        if not self.suspicious:
            return f'rollers as usual: mean yaw lever {self.lever:.4g} m'
        return (f'the rollers seem to be mirrored: the yaw lever is {self.lever:.4g} m, with left '
                f'and right wheels swapped it would be {self.mirrored_lever:.4g} m; seen from '
                'above, the upper rollers of a usual base form an X')


def mirrored(wheels: Wheels) -> Wheels:
    """The same base with every roller angle of the opposite sign."""
    return dataclasses.replace(wheels, roller=-wheels.roller)


def yaw_lever(wheels: Wheels) -> FloatArray:
    """(W,) m: rim travel of each wheel per radian the base turns, |r H_yaw| (nominal contact)."""
    lever: FloatArray = np.abs(wheels.radius * wheels_from_body(wheels, corrected=False)[:, 2])
    return lever


def judge_mounting(wheels: Wheels) -> Mounting:
    """Compare the yaw lever as mounted with that of mirrored rollers."""
    own = float(np.mean(yaw_lever(wheels)))
    other = float(np.mean(yaw_lever(mirrored(wheels))))
    return Mounting(own, other, other > SUSPICIOUS * own)
