"""The floor under one point: friction, drag, height and gradient (plain scalars, compilable).

    height   h(x, y) = sum_k A_k sin(kx_k x + ky_k y + p_k) + ramps          [m]
    ramp     grade g between two lines along its direction, edges rounded over ~5 cm

Patches are rectangles or discs that replace the friction of the floor; the last one that covers
the point counts. Not modelled: soft floors (sinkage), anisotropic friction (brushed carpet).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

PATCH, WAVE, RAMP = 8, 4, 6  # numbers per entry in the flat lists
RAMP_EDGE = 0.05  # m, over which the grade of a ramp sets in

Ground = tuple[float, float, float, float, float, float]


def ground(x: float, y: float, static: float, kinetic: float, patches: Sequence[float],
           waves: Sequence[float], ramps: Sequence[float]) -> Ground:
    """(static, kinetic friction, drag factor, height [m], dh/dx, dh/dy) at (x, y) [m]."""
    drag = 1.0
    for j in range(0, len(patches), PATCH):
        if patches[j] == 0.0:  # rectangle x0 x1 y0 y1
            inside = (patches[j + 1] <= x <= patches[j + 2]
                      and patches[j + 3] <= y <= patches[j + 4])
        else:  # disc: centre x y, radius
            dx, dy = x - patches[j + 1], y - patches[j + 2]
            inside = dx * dx + dy * dy <= patches[j + 3] * patches[j + 3]
        if inside:
            static, kinetic, drag = patches[j + 5], patches[j + 6], patches[j + 7]
    height = 0.0
    slope_x = 0.0
    slope_y = 0.0
    for j in range(0, len(waves), WAVE):
        phase = waves[j + 1] * x + waves[j + 2] * y + waves[j + 3]
        height += waves[j] * math.sin(phase)
        lean = waves[j] * math.cos(phase)
        slope_x += waves[j + 1] * lean
        slope_y += waves[j + 2] * lean
    for j in range(0, len(ramps), RAMP):  # direction cx cy, from, to, grade, spare
        along = ramps[j] * x + ramps[j + 1] * y
        for k in range(2):
            sign = 1.0 - 2.0 * k
            t = (along - ramps[j + 2 + k]) / RAMP_EDGE
            if t > 30.0:
                rise, share = t, 1.0
            elif t < -30.0:
                rise, share = 0.0, 0.0
            else:
                rise = math.log1p(math.exp(t))
                share = 1.0 / (1.0 + math.exp(-t))
            height += sign * ramps[j + 4] * RAMP_EDGE * rise
            slope_x += sign * ramps[j + 4] * share * ramps[j]
            slope_y += sign * ramps[j + 4] * share * ramps[j + 1]
    return static, kinetic, drag, height, slope_x, slope_y
