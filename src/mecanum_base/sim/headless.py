"""Run a scenario without ROS, as fast as the machine allows, whole or section by section.

The driver asks for a twist at the true pose; it is turned into wheel rates by the geometry of the
robot file (the true one differs by its errors), as the drive node does, and sent at 50 Hz.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.kinematics import matrix
from mecanum_base.core.kinematics.saturation import scale_to_limits
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.platform import differential
from mecanum_base.core.records import CommandSample, Sample
from mecanum_base.sim.body import Base
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.engine import choose
from mecanum_base.sim.faults import NANOSECONDS
from mecanum_base.sim.records import Published, Truth
from mecanum_base.sim.scenario import Scenario
from mecanum_base.sim.simulation import Simulation

COMMAND_RATE = 50.0  # Hz
_BULK = 100  # commands between two collections of readings (faster than one by one)
START_NS = 1_000 * NANOSECONDS  # stamps start here, because 0 means "no time" to many tools


@dataclass(frozen=True, slots=True, eq=False)
class Command:
    """What was sent at one instant: wanted twist (3,), wheel rates (W,) rad/s."""

    stamp_ns: int
    twist: FloatArray
    rate: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """What a part of a run gave: ``commands`` before ``until_ns`` and what was ``published`` up
    to then, both in order of time and since the section before."""

    until_ns: int
    commands: tuple[Command, ...]
    published: tuple[Published, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Everything one run gave.

    ``published``: sensor readings and truth in order of publication; ``commands`` in order of
    time. The truth again as arrays: ``stamp_ns`` (N,), ``pose`` (N, 3) from 0, 0, 0, ``twist``
    (N, 3) in base_link, ``slip_rate`` and ``slip_angle`` (N, W).
    """

    joints: tuple[str, ...]
    seed: int
    start_ns: int
    end_ns: int
    published: tuple[Published, ...]
    commands: tuple[Command, ...]
    stamp_ns: IntArray
    pose: FloatArray
    twist: FloatArray
    slip_rate: FloatArray
    slip_angle: FloatArray

    def samples(self, *, commands: bool = True) -> list[Sample]:
        """What an estimator would get, in order of arrival: wheels, ticks, IMU, commands."""
        timed: list[tuple[int, int, Sample]] = [
            (item.at_ns, 1, item.reading) for item in self.published
            if not isinstance(item.reading, Truth)]
        if commands:
            timed += [(c.stamp_ns, 0, CommandSample(c.stamp_ns, c.rate)) for c in self.commands]
        timed.sort(key=lambda entry: entry[:2])  # stable: order of publication within a time
        return [sample for _, _, sample in timed]


class Headless:
    """One run of ``scenario`` with the robot of these blocks of a robot file.

    ``sim`` is the block of the robot file; the scenario's own ``sim`` values replace it, and
    ``seed`` (default: that of the scenario) replaces its seed. ``duration`` [s] replaces that of
    the scenario. With ``sim.engine`` auto the compiled engine is used where numba is installed.
    The result depends on the arguments only.
    """

    def __init__(self, scenario: Scenario, base: Base, encoder: EncoderConfig, imu: ImuConfig,
                 sim: SimConfig, *, seed: int | None = None, duration: float | None = None,
                 start_ns: int = START_NS) -> None:
        self.seed = scenario.seed if seed is None else seed
        self.start_ns = start_ns
        self.end_ns = start_ns + round(
            (scenario.duration if duration is None else duration) * NANOSECONDS)
        engine = choose(scenario.settings(sim).engine, prefer_numba=True)
        config = dataclasses.replace(sim, seed=self.seed, engine=engine)
        own = {k: v for k, v in scenario.sim.items() if k not in ('seed', 'engine')}
        self._simulation = Simulation(base, encoder, imu, config, scenario.replace(sim=own),
                                      start_ns)
        self._driver = scenario.driver(self.seed)
        self._rates = _RatesFromTwist(base, self._simulation)

    @property
    def joints(self) -> tuple[str, ...]:
        """Wheel joints in the order of all wheel arrays."""
        return self._simulation.joints

    def sections(self, progress: Callable[[float], None] | None = None) -> Iterator[Section]:
        """Drive (once); a section is two seconds, so memory does not grow with the run.

        ``progress`` is called with the share done, 0..1.
        """
        simulation, start, end = self._simulation, self.start_ns, self.end_ns
        period = round(NANOSECONDS / COMMAND_RATE)
        commands: list[Command] = []
        now = start
        while now < end:
            twist = np.array(self._driver.twist((now - start) / NANOSECONDS,
                                                simulation.plant.pose))
            commands.append(Command(now, twist, self._rates(twist)))
            simulation.command(commands[-1].rate)
            now = min(now + period, end)
            if len(commands) < _BULK and now < end:
                simulation.move(now)
            else:
                yield Section(now, tuple(commands), simulation.advance_published(now))
                commands = []
            if progress is not None:
                progress((now - start) / (end - start))


def run(scenario: Scenario, base: Base, encoder: EncoderConfig, imu: ImuConfig, sim: SimConfig, *,
        seed: int | None = None, duration: float | None = None, start_ns: int = START_NS,
        progress: Callable[[float], None] | None = None) -> Run:
    """All that a run of :class:`Headless` gives, in memory."""
    headless = Headless(scenario, base, encoder, imu, sim, seed=seed, duration=duration,
                        start_ns=start_ns)
    published: list[Published] = []
    commands: list[Command] = []
    for section in headless.sections(progress):
        published += section.published
        commands += section.commands
    truth = [item.reading for item in published if isinstance(item.reading, Truth)]
    return Run(headless.joints, headless.seed, start_ns, headless.end_ns, tuple(published),
               tuple(commands), np.array([t.stamp_ns for t in truth], dtype=np.int64),
               np.array([t.pose for t in truth]), np.array([t.twist for t in truth]),
               np.array([t.slip_rate for t in truth]), np.array([t.slip_angle for t in truth]))


class _RatesFromTwist:
    """Wheel rates (W,) that serve a twist, all scaled together where one would be too fast."""

    def __init__(self, base: Base, simulation: Simulation) -> None:
        self._base, self._simulation = base, simulation
        self._limits = simulation.plant.body.max_speed
        self._least = float(np.min(self._limits))
        if isinstance(base, Wheels):
            self._fixed = matrix.wheels_from_body(base)

    def __call__(self, twist: FloatArray) -> FloatArray:
        if isinstance(self._base, Wheels):
            rates: FloatArray = self._fixed @ twist
        else:
            angles = self._simulation.plant.hinge_angles
            rates = differential.wheels_from_body(self._base, angles) @ twist
        if max(map(abs, rates.tolist())) > self._least:
            rates = rates * scale_to_limits(rates, self._limits)
        return rates
