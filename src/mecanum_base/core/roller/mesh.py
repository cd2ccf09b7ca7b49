"""Triangle mesh of one roller and of the set of rollers of a wheel (G eq. 4).

A roller is the meridian turned about its axis, closed by flat ends; with a bore it is a tube. The
set is k copies turned about the wheel axle by 2 pi / k. Vertices in m, faces counter-clockwise
seen from outside, every edge shared by two faces: watertight.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.roller.shape import RollerShape, meridian, wheel_from_roller
from mecanum_base.core.roller.sizing import reach_of_length


def roller_mesh(shape: RollerShape, length: float, *, bore: float = 0.0, rings: int = 64,
                sectors: int = 96) -> tuple[FloatArray, IntArray]:
    """(vertices (N, 3) m in S*, faces (M, 3)) of one roller of ``length`` m.

    ``bore`` m is the radius of the hole for the pin, 0 = solid. Raises ConfigError for a length
    no roller can have or a bore that leaves no wall at the ends.
    """
    reach = reach_of_length(shape, length)
    along, radius = meridian(shape, np.linspace(-reach, reach, rings))
    if not 0.0 <= bore < float(radius[-1]):
        raise ConfigError('bore', bore, 'must be >= 0 and below the end radius of the roller '
                          f'{float(radius[-1]):.6g}', 'm')
    if along[0] > along[-1]:
        along = along[::-1]
    if bore > 0.0:  # closed profile: out along the meridian, back through the bore
        return _revolve(np.concatenate([along, along[[-1, 0]]]),
                        np.concatenate([radius, [bore, bore]]), sectors, closed=True)
    vertices, faces = _revolve(along, radius, sectors, closed=False)
    ends = np.array([[along[0], 0.0, 0.0], [along[-1], 0.0, 0.0]])
    first = np.arange(sectors)
    following = (first + 1) % sectors
    base, last = len(vertices), (rings - 1) * sectors
    caps = [np.column_stack([np.full(sectors, base), following, first]),
            np.column_stack([np.full(sectors, base + 1), last + first, last + following])]
    return np.vstack([vertices, ends]), np.vstack([faces, *caps])


def _revolve(along: FloatArray, radius: FloatArray, sectors: int,
             *, closed: bool) -> tuple[FloatArray, IntArray]:
    """Surface of the profile (along, radius) turned about x; closed joins last ring to first."""
    turn = 2.0 * math.pi * np.arange(sectors) / sectors
    vertices = np.column_stack([
        np.repeat(along, sectors), np.outer(radius, np.cos(turn)).ravel(),
        np.outer(radius, np.sin(turn)).ravel()])
    rings = len(along)
    ring, sector = np.meshgrid(np.arange(rings if closed else rings - 1), np.arange(sectors),
                               indexing='ij')
    here, there = ring.ravel() * sectors, (ring.ravel() + 1) % rings * sectors
    first, following = sector.ravel(), (sector.ravel() + 1) % sectors
    faces: IntArray = np.vstack([
        np.column_stack([here + first, here + following, there + first]),
        np.column_stack([there + first, here + following, there + following])]).astype(np.int64)
    return vertices, faces


def wheel_mesh(shape: RollerShape, count: int, length: float, *, bore: float = 0.0,
               rings: int = 64, sectors: int = 96) -> tuple[FloatArray, IntArray]:
    """(vertices (N, 3) m in S, faces (M, 3)) of all ``count`` rollers around the wheel axle x."""
    roller, faces = roller_mesh(shape, length, bore=bore, rings=rings, sectors=sectors)
    x, y, z = wheel_from_roller(shape, roller).T
    turns = 2.0 * math.pi * np.arange(count) / count
    sets = [np.column_stack([x, math.cos(t) * y - math.sin(t) * z, math.sin(t) * y
                             + math.cos(t) * z]) for t in turns]
    return np.vstack(sets), np.vstack([faces + i * len(roller) for i in range(count)])
