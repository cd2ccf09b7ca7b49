"""From the moving plant to readings: rows are noted quickly, and turned into samples in blocks.

Within a block the same faults act; the caller asks for the samples (:meth:`Sampling.samples`)
before faults change. Every sample comes with the time of its publication.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.records import ImuSample, TickSample, WheelSample
from mecanum_base.sim import layout as at
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.encoder import Encoders
from mecanum_base.sim.faults import NANOSECONDS
from mecanum_base.sim.inertial import Inertial
from mecanum_base.sim.injection import Injection
from mecanum_base.sim.plant import Plant
from mecanum_base.sim.records import Reading, Truth
from mecanum_base.sim.transport import Transport

IMU, ENCODER, TRUTH = range(3)
_NOW, _SUM = slice(at.S_GX, at.S_AZ + 1), slice(at.S_SUM_GX, at.S_SUM_AZ + 1)
_HINGE_STEP = 2.0 * math.pi / 4096.0  # rad, resolution of a measured hinge angle

# published, taken (ns since the start), order among equals, reading
Sampled = tuple[int, int, int, Reading]


class Sampling:
    """Sensors of one robot and the way of their messages."""

    def __init__(self, config: SimConfig, encoder: EncoderConfig, imu: ImuConfig,
                 radius: float, joints: int, hinges: Sequence[str]) -> None:
        self.inertial, self._radius = Inertial(imu, config), radius
        self.encoders = Encoders(encoder, joints, config.seed)
        self._transport = Transport(config)
        self._period, self._imu_rate = 1.0 / config.encoder_rate, config.imu_rate
        self._late_ns = imu.late_ns
        self._hinges = np.array([name != '' for name in hinges]) if any(hinges) else None
        self._rows: tuple[list[tuple[int, int, list[float]]], ...] = ([], [], [])
        self._frozen: tuple[FloatArray, FloatArray] | None = None

    def restart(self, plant: Plant) -> None:
        """Switch all sensors off and on."""
        self.inertial.restart()
        self.encoders.restart(plant.column_array(at.T_ANGLE))
        self._transport.restart()
        self._frozen = None
        # before the first sample the base has stood for one period
        self._taken = -round(NANOSECONDS / self._imu_rate)
        self._sum = np.array([plant.part(_SUM)]) - np.array([plant.part(_NOW)]) / self._imu_rate
        for rows in self._rows:
            rows.clear()

    def note(self, kind: int, elapsed_ns: int, index: int, plant: Plant) -> None:
        """Note what sample ``index`` of one kind needs of the plant, as it is now."""
        if kind == IMU:
            row = plant.part(_SUM) + plant.column(at.T_RATE)
        elif kind == ENCODER:
            row = plant.column(at.T_ANGLE)
            if self._hinges is not None:
                row = row + plant.hinge_angles.tolist()
        else:
            row = [*plant.pose, *plant.twist, *plant.column(at.T_SLIP_RATE),
                   *plant.column(at.T_SLIP_ANGLE)]
        self._rows[kind].append((elapsed_ns, index, row))

    def samples(self, injection: Injection, start_ns: int) -> list[Sampled]:
        """Samples of everything noted, while the faults of ``injection`` act."""
        out: list[Sampled] = []
        stamped_ns = start_ns + injection.clock_offset_ns
        for rows, make, origin in ((self._rows[IMU], self._imu, stamped_ns),
                                   (self._rows[ENCODER], self._encoder, stamped_ns),
                                   (self._rows[TRUTH], self._truth, start_ns)):
            if rows:
                table = np.array([row for _, _, row in rows])
                make(out, [(taken, index) for taken, index, _ in rows], table, injection, origin)
                rows.clear()
        return out

    def _imu(self, out: list[Sampled], when: list[tuple[int, int]], table: FloatArray,
             injection: Injection, origin_ns: int) -> None:
        active = injection.active
        rate = np.abs(table[:, 6])
        for wheel in range(7, table.shape[1]):  # summed one by one: the same in every block
            rate = rate + np.abs(table[:, wheel])
        speed = self._radius * rate / (table.shape[1] - 6)
        felt = np.diff(table[:, :6], axis=0, prepend=self._sum) / self._spacing_of(when)
        self._sum, self._taken = table[-1:, :6], when[-1][0]
        gyro, accel = self.inertial.read(felt[:, :3], felt[:, 3:], speed)
        if 'imu_frozen' in active:
            self._frozen = self._frozen or (gyro[:1], accel[:1])
            gyro, accel = (np.repeat(v, len(when), axis=0) for v in self._frozen)
        else:
            self._frozen = None
        if 'imu_rotated' in active:
            gyro, accel = (_turned(v, active['imu_rotated'].value) for v in (gyro, accel))
        if 'imu_nan' in active:
            gyro, accel = np.full_like(gyro, np.nan), np.full_like(accel, np.nan)
        for k, (taken, index) in enumerate(when):
            stamp, published = self._transport.imu(taken, index, active)
            if published is not None:  # no sensor publishes before the time it stamps
                stamp += self._late_ns
                out.append((max(published, taken + self._late_ns), taken, 0,
                            ImuSample(stamp + origin_ns, gyro[k], accel[k])))

    def _spacing_of(self, when: list[tuple[int, int]]) -> FloatArray:
        taken = np.array([self._taken, *(ns for ns, _ in when)], dtype=np.int64)
        seconds: FloatArray = np.diff(taken)[:, None] / NANOSECONDS
        return seconds

    def _encoder(self, out: list[Sampled], when: list[tuple[int, int]], table: FloatArray,
                 injection: Injection, origin_ns: int) -> None:
        encoders, gains = self.encoders, np.array(injection.gains)
        counts, before = encoders.count(table[:, :len(gains)], gains)
        position, ticks = encoders.position(counts), encoders.ticks(counts)
        velocity = encoders.velocity(counts, before, self._period)
        hinge: list[FloatArray | None] = [None] * len(when)
        if self._hinges is not None:
            angles = np.round(table[:, len(gains):] / _HINGE_STEP) * _HINGE_STEP
            hinge = list(np.where(self._hinges, angles, np.nan))
        for k, (taken, index) in enumerate(when):
            stamp, published = self._transport.encoder(taken, index, injection.active)
            if published is not None:
                out.append((published, taken, 1, WheelSample(
                    stamp + origin_ns, position[k], velocity[k], hinge[k])))
                out.append((published, taken, 2, TickSample(published + origin_ns, ticks[k])))

    def _truth(self, out: list[Sampled], when: list[tuple[int, int]], table: FloatArray,
               injection: Injection, origin_ns: int) -> None:
        wheels = (table.shape[1] - 6) // 2
        for row, (taken, _) in zip(table, when):
            out.append((taken, taken, 3, Truth(taken + origin_ns, row[:3], row[3:6],
                                               row[6:6 + wheels], row[6 + wheels:])))


def _turned(vectors: FloatArray, angle: float) -> FloatArray:
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = vectors.T
    return np.column_stack([c * x - s * y, s * x + c * y, z])
