"""What the simulated hardware gives out: samples, the truth, and when they are published."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Union

from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.records import ImuSample, TickSample, WheelSample


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """The true motion at one instant.

    ``pose`` (3,) of base_link where the run started at 0, 0, 0 (m, m, rad unwrapped); ``twist``
    (3,) in base_link (m/s, m/s, rad/s); ``slip_rate`` (W,) rad/s: wheel rate minus the rate at
    which its contact would not slide; ``slip_angle`` (W,) rad: the integral of slip_rate.
    """

    stamp_ns: int
    pose: FloatArray
    twist: FloatArray
    slip_rate: FloatArray
    slip_angle: FloatArray


Reading = Union[WheelSample, TickSample, ImuSample, Truth]


@dataclass(frozen=True, slots=True, eq=False)
class Published:
    """A reading and the simulated time at which the hardware hands it over (ns)."""

    at_ns: int
    reading: Reading
