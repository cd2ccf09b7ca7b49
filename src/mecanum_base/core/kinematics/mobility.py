"""Can these wheels hold and drive the base? Gfrerrer's Theorem 2 for n wheels.

H has rank 3 unless the roller axes on the ground all meet in one point or are all parallel. Then
one motion costs no wheel rate and no wheel can resist it, the self-motion:

    axes meet in I:      rotation about I,             V ~ (I_y, -I_x, 1)
    axes parallel at b:  translation across the axes,  V ~ (-sin b, cos b, 0)

Conditioning is judged on H with lengths scaled by the mean distance of the wheels from their
centre, so that the verdict does not depend on the unit of length. Both the nominal H and the one
with the mean contact correction are judged; the worse counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.errors import GeometryError
from mecanum_base.core.kinematics.lines import name_motion
from mecanum_base.core.kinematics.matrix import wheels_from_body
from mecanum_base.core.kinematics.mounting import mirrored
from mecanum_base.core.kinematics.solve import parity_basis
from mecanum_base.core.kinematics.wheels import MIN_WHEELS, Wheels
from mecanum_base.core.parameter import FloatArray

SINGULAR = 1e-6  # relative singular value below which a motion counts as free
POOR = 0.05  # below this the base can be driven, but badly


@dataclass(frozen=True, slots=True, eq=False)
class Mobility:
    """Verdict on a wheel set.

    ``rank`` of H; ``redundancy`` = W - rank; ``condition`` = smallest over largest singular value
    of the scaled H (0 = singular, 1 = equally good in all directions); ``weakest`` (3,) the twist
    that moves the wheels least, unit length in scaled coordinates; ``self_motion`` (3,) that twist
    where rank < 3, else None; ``text`` one sentence for people.
    """

    rank: int
    redundancy: int
    condition: float
    weakest: FloatArray
    self_motion: FloatArray | None
    text: str


def assess(wheels: Wheels) -> Mobility:
    """Rank, redundancy and conditioning of the wheel set; a self-motion is named."""
    rank, condition, weakest = min(
        (_decompose(wheels, wheels_from_body(wheels, corrected=corrected))
         for corrected in (False, True)), key=lambda found: found[1])
    return Mobility(rank, wheels.count - rank, condition, weakest,
                    weakest if rank < 3 else None, _sentence(wheels, rank, condition, weakest))


def _decompose(wheels: Wheels, matrix: FloatArray) -> tuple[int, float, FloatArray]:
    """Rank, condition and weakest twist (3,) of H, lengths scaled by the reach of the wheels."""
    centre = np.array([np.mean(wheels.x), np.mean(wheels.y)])
    reach = _reach(wheels)
    # twist of the wheels' centre, yaw rate scaled by the reach: V = shift @ scaled
    shift = np.array([[1.0, 0.0, centre[1] / reach], [0.0, 1.0, -centre[0] / reach],
                      [0.0, 0.0, 1.0 / reach]])
    scaled = matrix @ shift * float(np.mean(wheels.radius))
    _, singular, right = np.linalg.svd(scaled)
    singular = np.concatenate([singular, np.zeros(3 - len(singular))])
    rank = int(np.sum(singular > SINGULAR * singular[0]))
    return rank, float(singular[2] / singular[0]), shift @ right[2]


def _reach(wheels: Wheels) -> float:
    """Mean distance of the wheels from their centre [m]; 1 where they coincide."""
    return float(np.mean(np.hypot(wheels.x - np.mean(wheels.x),
                                  wheels.y - np.mean(wheels.y)))) or 1.0


def _sentence(wheels: Wheels, rank: int, condition: float, weakest: FloatArray) -> str:
    if rank == 3 and condition >= POOR:
        spare = wheels.count - 3
        return ('every motion is driven and held; '
                + (f'{spare} redundant wheel equation{"s" if spare > 1 else ""}' if spare
                   else 'no redundancy: the encoders alone cannot show slip'))
    motion = name_motion(weakest, _reach(wheels))
    if rank == 3:
        return f'nearly singular: {motion.text()} is hardly driven (condition {condition:.3g})'
    reason = ('all roller axes meet in that point' if motion.kind == 'rotation'
              else 'all roller axes are parallel, across that bearing')
    extra = '' if rank == 2 else f' (and {2 - rank} more free motion)'
    return f'no wheel drives or resists the {motion.text()}: {reason}{extra}{_mirror_hint(wheels)}'


def _mirror_hint(wheels: Wheels) -> str:
    rank, condition, _ = _decompose(wheels, wheels_from_body(mirrored(wheels)))
    if rank == 3 and condition >= POOR:
        swap = np.ptp(np.sin(wheels.axle)) < SINGULAR and np.ptp(np.cos(wheels.axle)) < SINGULAR
        how = ' (left and right wheels swapped)' if swap else ''
        return f'; with the rollers mirrored{how} the base is sound'
    return ''


def require_mobile(wheels: Wheels) -> Mobility:
    """The verdict, or GeometryError where wheels are too few or leave a free self-motion."""
    if wheels.count < MIN_WHEELS:
        raise GeometryError('wheels.joint', list(wheels.joint),
                            f'must name at least {MIN_WHEELS} wheels')
    verdict = assess(wheels)
    if verdict.rank < 3:
        raise GeometryError('wheels', f'rank {verdict.rank} of 3', verdict.text)
    return verdict


def visible_slip(wheels: Wheels) -> FloatArray:
    """Orthonormal rows (W - 3, W): combinations of wheel rates that encoders alone can check."""
    return parity_basis(wheels_from_body(wheels))
