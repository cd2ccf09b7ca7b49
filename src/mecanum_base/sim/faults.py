"""Faults and disturbances by name: what they concern, the unit and the usual size of their value.

The same names are used by the parameter ``sim.fault``, by ``Simulation.inject`` (which a service
can call) and by the ``events`` of a scenario file.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray, frozen_floats, nearest

NANOSECONDS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of fault: meaning, unit and usual value, whether it names wheels."""

    meaning: str
    unit: str = ''
    usual: float = 0.0
    wheels: bool = False
    vector: int = 0  # length of a vector value, 0 = a single number


FAULTS: dict[str, Kind] = {
    'encoder_stuck': Kind('counter stands still and loses what it misses', wheels=True),
    'encoder_dropped': Kind('encoder messages never arrive'),
    'encoder_reversed': Kind('counts with the wrong sign', wheels=True),
    'encoder_reset': Kind('counter starts again from zero', wheels=True),
    'encoder_late': Kind('encoder messages arrive late', 's', 0.05),
    'imu_dropped': Kind('IMU messages never arrive'),
    'imu_frozen': Kind('IMU repeats its last values'),
    'imu_nan': Kind('IMU reports NaN'),
    'imu_rotated': Kind('IMU turned about z on its mount', 'rad', 1.5708),
    'imu_clock_offset': Kind('IMU stamps are off', 's', 0.02),
    'reorder': Kind('neighbouring messages change places'),
    'time_jump': Kind('the clock of all stamps jumps, for good', 's', -5.0),
    'command_loss': Kind('wheel commands do not arrive'),
}

DISTURBANCES: dict[str, Kind] = {
    'jam': Kind('wheel is blocked', wheels=True),
    'free': Kind('wheel has lost its motor (clutch or shaft broken)', wheels=True),
    'lift': Kind('floor below the wheel is lower by this', 'm', 0.004, wheels=True),
    'grip': Kind('friction below the wheel times this', '', 0.15, wheels=True),
    'push': Kind('force x, y on the mass centre and torque z, body axes', 'N, N, N m', vector=3),
    'shove': Kind('as push, force in floor axes', 'N, N, N m', vector=3),
}

KINDS: dict[str, Kind] = {**FAULTS, **DISTURBANCES}


@dataclass(frozen=True, slots=True, eq=False)
class Event:
    """One fault or disturbance between two times (ns of simulated time since the start)."""

    kind: str
    start_ns: int
    end_ns: int
    wheels: tuple[int, ...] = ()  # empty = all
    value: float = 0.0
    vector: FloatArray = field(default_factory=lambda: frozen_floats(np.zeros(3)))

    def concerns(self, wheel: int) -> bool:
        """Whether the event acts on this wheel."""
        return not self.wheels or wheel in self.wheels


def make_event(kind: str, start_ns: int, end_ns: int, wheels: tuple[int, ...] = (),
               value: float | FloatArray | None = None, *, count: int | None = None) -> Event:
    """An event with the usual value filled in; ConfigError where kind, wheels or value are bad.

    ``count`` is the number of wheels, where known.
    """
    if kind not in KINDS:
        raise ConfigError('kind', kind, f'unknown kind of event, {nearest(kind, list(KINDS))}')
    known = KINDS[kind]
    if wheels and not known.wheels:
        raise ConfigError('wheels', list(wheels), f'{kind} does not concern single wheels')
    for index, wheel in enumerate(wheels):
        if wheel < 0 or (count is not None and wheel >= count):
            limit = f' and < {count}' if count is not None else ''
            raise ConfigError(f'wheels[{index}]', wheel, f'must be >= 0{limit}')
    if end_ns < start_ns:
        raise ConfigError('for', (end_ns - start_ns) / NANOSECONDS, 'must be >= 0', 's')
    if known.vector:
        array = np.asarray(np.zeros(3) if value is None else value, dtype=np.float64)
        if array.shape != (known.vector,):
            raise ConfigError('value', np.asarray(value).tolist(),
                              f'must have {known.vector} entries', known.unit)
        return Event(kind, start_ns, end_ns, wheels, 0.0, frozen_floats(array))
    if value is not None and np.ndim(value) != 0:
        raise ConfigError('value', np.asarray(value).tolist(), 'must be a number', known.unit)
    number = known.usual if value is None else float(np.asarray(value))
    return Event(kind, start_ns, end_ns, wheels, number)
