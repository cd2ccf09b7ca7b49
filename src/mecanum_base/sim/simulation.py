"""The simulated hardware: commands in, sensor readings and truth out, in order of publication.

Time is simulated time in whole nanoseconds; the same seed and the same commands at the same times
give the same readings. Nothing here waits, reads a clock or knows ROS.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.parameter import FloatArray
from mecanum_base.sim import layout as at
from mecanum_base.sim.body import Base, make_body
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.engine import choose
from mecanum_base.sim.faults import NANOSECONDS, Event
from mecanum_base.sim.injection import Injection
from mecanum_base.sim.plant import Plant
from mecanum_base.sim.records import Published, Reading, Truth
from mecanum_base.sim.sampling import Sampled, Sampling
from mecanum_base.sim.scenario import Scenario

_NEVER = 1 << 62


class Simulation:
    """One robot on one floor.

    ``base``, ``encoder`` and ``imu`` are blocks of the robot file, ``sim`` its block ``sim``;
    ``scenario`` gives floor, events and settings it replaces. Time starts at ``start_ns``.
    """

    def __init__(self, base: Base, encoder: EncoderConfig, imu: ImuConfig, sim: SimConfig,
                 scenario: Scenario | None = None, start_ns: int = 0) -> None:
        self.scenario = scenario or Scenario()
        sim = self.scenario.settings(sim)
        self.config, self.start_ns = sim, start_ns
        step_ns = round(NANOSECONDS / sim.physics_rate)
        self._step_ns = step_ns
        body = make_body(base, sim, imu.xyz)
        self._sampling = Sampling(
            sim, encoder, imu, float(np.mean(body.wheels[at.W_RADIUS::at.WHEEL])), body.count,
            getattr(base, 'hinge_joint', ()))
        if self._sampling.inertial.bandwidth > 0.0:
            lag = 2.0 * math.pi * self._sampling.inertial.bandwidth * step_ns / NANOSECONDS
            body.constants[at.IMU_FILTER] = 1.0 - math.exp(-lag)
        self.plant = Plant(body, self.scenario.floor, step=step_ns / NANOSECONDS,
                           engine=choose(sim.engine, prefer_numba=False), seed=sim.seed)
        self._injection = Injection(self.scenario.events, body.count)
        self._limit = [float(v) for v in body.max_speed]
        self._spacing = [NANOSECONDS / (rate * step_ns)  # physics steps between samples
                         for rate in (sim.imu_rate, sim.encoder_rate, sim.truth_rate)]
        self._begin()
        if sim.fault != 'none':
            self.set_fault(sim.fault, tuple(int(v) for v in sim.fault_wheels),
                           sim.fault_value or None)

    def _begin(self) -> None:
        self._steps = 0
        self._index = [0, 0, 0]  # number of the next IMU, encoder and truth sample
        self._next = [0, 0, 0]  # physics step at which it is taken
        self._quiet = _NEVER  # step at which the command times out
        self._change = 0  # step at which events begin or end
        self._queue: list[Sampled] = []
        self._sampling.restart(self.plant)

    @property
    def now_ns(self) -> int:
        """Simulated time reached (ns)."""
        return self.start_ns + self._steps * self._step_ns

    @property
    def joints(self) -> tuple[str, ...]:
        """Wheel joints in the order of all wheel arrays."""
        return self.plant.body.joints

    def command(self, rates: Sequence[float] | FloatArray) -> None:
        """Set wanted wheel rates (W,) rad/s, in the wheels' own positive sense.

        Rates beyond ``max_speed`` are cut, NaN or infinite ones keep the wheel's last command; the
        whole command is ignored while the fault command_loss is active.
        """
        if len(rates) != len(self._limit):
            raise ConfigError('rates', [float(v) for v in rates],
                              f'must have one entry a wheel ({len(self._limit)})', 'rad/s')
        if 'command_loss' in self._injection.active:
            return
        inputs = self.plant.inputs
        for i, (rate, limit) in enumerate(zip(map(float, rates), self._limit)):
            if math.isfinite(rate):
                inputs[i * at.INPUT + at.I_RATE] = min(max(rate, -limit), limit)
        self._quiet = self._steps + round(
            self.config.command_timeout * NANOSECONDS / self._step_ns)

    def inject(self, kind: str, duration: float, wheels: tuple[int, ...] = (),
               value: float | FloatArray | None = None) -> Event:
        """Let a fault or disturbance of :mod:`faults` act from now on for ``duration`` [s]."""
        event = self._injection.add(kind, self._elapsed(), duration, wheels, value)
        self._change = self._steps
        return event

    def set_fault(self, kind: str, wheels: tuple[int, ...] = (),
                  value: float | None = None) -> None:
        """Switch the one fault of the parameter ``sim.fault`` to ``kind`` ('none' = off)."""
        self._injection.hold(kind, self._elapsed(), wheels, value)
        self._change = self._steps

    def reset(self) -> None:
        """Put the robot back at its start, at rest, in the present of simulated time."""
        now = self.now_ns
        self._stop()
        self.plant.restart()
        self._injection.restart()
        self._begin()
        self.start_ns = now

    def advance(self, until_ns: int) -> tuple[Reading, ...]:
        """Run up to ``until_ns``; readings published meanwhile, in order of publication."""
        return tuple(item.reading for item in self.advance_published(until_ns))

    def advance_published(self, until_ns: int) -> tuple[Published, ...]:
        """As :meth:`advance`, with the time of publication of each reading."""
        self.move(until_ns)
        self._sample()
        queue, start = self._queue, self.start_ns
        out = []
        while queue and queue[0][0] + start <= until_ns:
            at_ns, _, _, reading = heapq.heappop(queue)
            out.append(Published(at_ns + start, reading))
        return tuple(out)

    def move(self, until_ns: int) -> None:
        """Run up to ``until_ns``; the readings are kept for the next advance (bulk runs)."""
        last = (until_ns - self.start_ns) // self._step_ns
        while True:
            if self._steps >= self._change:
                self._sample()  # before faults change
                change = self._injection.apply(self.plant, self._sampling.encoders,
                                               self._elapsed())
                self._change = -(-change // self._step_ns)
            if self._steps >= self._quiet:
                self._stop()
            self._note()
            if self._steps >= last:
                break
            stop = min(last, self._change, self._quiet, *self._next)
            self.plant.advance(stop - self._steps)
            self._steps = stop

    def truth(self) -> Truth:
        """The true motion now."""
        plant = self.plant
        return Truth(self.now_ns, np.array(plant.pose), np.array(plant.twist),
                     plant.column_array(at.T_SLIP_RATE), plant.column_array(at.T_SLIP_ANGLE))

    def _elapsed(self) -> int:
        return self._steps * self._step_ns

    def _stop(self) -> None:
        for row in range(0, len(self.plant.inputs), at.INPUT):
            self.plant.inputs[row + at.I_RATE] = 0.0
        self._quiet = _NEVER

    def _note(self) -> None:
        steps, due = self._steps, self._next
        for kind in (0, 1, 2):
            if due[kind] <= steps:
                self._sampling.note(kind, steps * self._step_ns, self._index[kind], self.plant)
                self._index[kind] += 1
                due[kind] = math.ceil(self._index[kind] * self._spacing[kind] - 1e-9)

    def _sample(self) -> None:
        for sampled in self._sampling.samples(self._injection, self.start_ns):
            heapq.heappush(self._queue, sampled)
