"""The moving robot: tables of one body on one floor, advanced by the kernel in whole steps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mecanum_base.core.parameter import FloatArray
from mecanum_base.sim import layout as at
from mecanum_base.sim.body import STANDARD_GRAVITY, Body
from mecanum_base.sim.engine import advance_function, table
from mecanum_base.sim.floor import Floor

_PLACE, _MIDDLE = slice(at.S_X, at.S_YAW + 1), slice(at.S_BVX, at.S_BVY + 1)
_SETTLE = 0.5  # s, for the body to come to rest on its supports before time starts


class Plant:
    """True motion of one robot. ``push`` and ``inputs`` may be written between advances."""

    def __init__(self, body: Body, floor: Floor, *, step: float, engine: str = 'plain',
                 seed: int = 1) -> None:
        self.body, self.floor, self.step, self.engine = body, floor, step, engine
        self._advance = advance_function(engine)
        constants = list(body.constants)
        constants[at.GRAVITY] = STANDARD_GRAVITY * math.cos(floor.slope)
        tangent = STANDARD_GRAVITY * math.sin(floor.slope)
        constants[at.GRAVITY_X] = -tangent * math.cos(floor.slope_direction)
        constants[at.GRAVITY_Y] = -tangent * math.sin(floor.slope_direction)
        self.constants: Any = table(constants, engine)
        self._cx, self._cy = constants[at.CX], constants[at.CY]
        self._wheels: Any = table(body.wheels, engine)
        self._patches: Any = table([v for p in floor.patches for v in p.row()], engine)
        self._waves: Any = table(floor.wave_rows(seed), engine)
        self._ramps: Any = table([v for r in floor.ramps for v in r.row()], engine)
        self._walls: Any = table([v for w in floor.walls for v in w.row()], engine)
        self._corners: Any = table(body.corners if floor.walls else [], engine)
        self._row: Any = table([0.0] * (body.count * at.ROW), engine)
        self.push: Any = table([0.0] * 5, engine)
        self.inputs: Any = table([0.0, 1.0, 0.0, 0.0, 0.0] * body.count, engine)
        self.state: Any = table([0.0] * at.STATE, engine)
        self.turn: Any = table([0.0] * (body.count * at.TURN), engine)
        self.hinges: Any = table(body.hinges, engine)
        self.restart()

    def restart(self) -> None:
        """Put the robot back at the origin, at rest and settled on its supports."""
        for values in (self.state, self.turn, self.push):
            for i in range(len(values)):
                values[i] = 0.0
        for i, value in enumerate(self.body.hinges):
            self.hinges[i] = value
        state, constants = self.state, self.constants
        state[at.S_X], state[at.S_Y] = constants[at.CX], constants[at.CY]
        state[at.S_HEAVE] = -constants[at.MASS] * constants[at.GRAVITY] / (
            constants[at.SUPPORT_K] * self.body.count)
        rest = self.inputs[0::at.INPUT]
        for i in range(self.body.count):
            self.inputs[i * at.INPUT] = 0.0
        self.advance(round(_SETTLE / self.step))
        for i in range(self.body.count):
            self.inputs[i * at.INPUT] = rest[i]
            self.turn[i * at.TURN + at.T_SLIP_ANGLE] = 0.0
            self.turn[i * at.TURN + at.T_ANGLE] = 0.0
            self.turn[i * at.TURN + at.T_RATE] = 0.0
        for place in (at.S_VX, at.S_VY, at.S_W):
            state[place] = 0.0
        state[at.S_X], state[at.S_Y], state[at.S_YAW] = constants[at.CX], constants[at.CY], 0.0

    def advance(self, steps: int) -> None:
        """Advance by ``steps`` physics steps."""
        self._advance(steps, self.step, self.constants, self._wheels, self._patches, self._waves,
                      self._ramps, self._walls, self._corners, self.push, self.inputs, self.state,
                      self.turn, self.hinges, self._row)

    def part(self, places: slice) -> list[float]:
        """Some of ``state`` as plain floats (quick to calculate with)."""
        values = self.state[places]
        return values if isinstance(values, list) else values.tolist()

    @property
    def pose(self) -> tuple[float, float, float]:
        """(x, y, yaw) of base_link [m, m, rad]."""
        x, y, yaw = self.part(_PLACE)
        c, s = math.cos(yaw), math.sin(yaw)
        return x - c * self._cx + s * self._cy, y - s * self._cx - c * self._cy, yaw

    @property
    def twist(self) -> tuple[float, float, float]:
        """(vx, vy, wz) of base_link in its own axes, at the middle of the last step."""
        vx, vy = self.part(_MIDDLE)
        w = float(self.state[at.S_W])
        return vx + w * self._cy, vy - w * self._cx, w

    def column(self, place: int) -> list[float]:
        """One number of every wheel, for instance ``column(layout.T_LOAD)``."""
        values = self.turn[place::at.TURN]
        return values if isinstance(values, list) else values.tolist()

    def column_array(self, place: int) -> FloatArray:
        """As :meth:`column`, as a new array (W,)."""
        return np.array(self.turn[place::at.TURN])

    @property
    def hinge_angles(self) -> FloatArray:
        """Angle of each carrier about its hinge (C,) rad; empty for a base with fixed wheels."""
        return np.array([float(v) for v in self.hinges[at.H_ANGLE::at.HINGE]])
