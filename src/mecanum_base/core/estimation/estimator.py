"""Samples in, estimates out: the one estimator behind the live node and the replay of bags."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np

from mecanum_base.core.estimation.encoder import WheelAngles
from mecanum_base.core.estimation.episodes import START, Episodes
from mecanum_base.core.estimation.filter import BodyFilter
from mecanum_base.core.estimation.following import Following
from mecanum_base.core.estimation.geometry import Base
from mecanum_base.core.estimation.health import Counters, Health
from mecanum_base.core.estimation.layout import (
    BAX,
    BAY,
    BG,
    FROZEN_FOR,
    HAVE_ACCEL,
    HAVE_GYRO,
    JITTER,
    NOW,
    PX,
    SLIP,
    STEP,
    STILL,
    YAW,
)
from mecanum_base.core.estimation.notes import unobservable
from mecanum_base.core.estimation.ordering import StampOrder
from mecanum_base.core.estimation.output import estimate_of_row
from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.estimation.smoother import Piece
from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.records import (
    CommandSample,
    Estimate,
    ImuSample,
    PoseSample,
    ResetSample,
    Sample,
    SlipEpisode,
    TickSample,
    WheelSample,
)

NANOSECONDS = 1_000_000_000
FASTEST_TURN = 80.0  # rad/s: no gyro reads more (4000 deg/s is 70 rad/s)
HARDEST_PUSH = 400.0  # m/s^2
FARTHEST = 1e7  # m or rad, no pose of a robot lies farther out
LONGEST_SILENCE = 5 * NANOSECONDS  # beyond it what was driven is unknown: 1 m, 1 rad of doubt
# samples of equal stamps are taken in this order
ORDER = {ResetSample: 0, PoseSample: 1, ImuSample: 2, CommandSample: 3, WheelSample: 4,
         TickSample: 5}
STREAM = {ResetSample: 'odometry_reset', PoseSample: 'set_pose', ImuSample: 'imu',
          CommandSample: 'wheel_commands', WheelSample: 'joint_states',
          TickSample: 'wheel_ticks'}
Number = TypeVar('Number', float, FloatArray)


class Estimator:
    """Odometry and slip of one base; no clock, no files, no threads: time is in the samples.

    ``handle`` takes any sample in order of arrival and returns the estimates that are due,
    ``flush`` what still waits at the end of a recording. ``restart`` answers a clock that went
    back. Data never raises: a bad sample is rejected, counted in ``health`` and forgotten.
    """

    def __init__(self, base: Base, encoder: EncoderConfig, imu: ImuConfig,
                 tuning: EstimatorConfig, smoothed: bool = False) -> None:
        """``smoothed``: also keep what is learnt later about every frame, for :meth:`past`."""
        self._filter = BodyFilter(base, encoder, imu, tuning, smoothed)
        top = np.repeat(base.max_speed, 2) if isinstance(base, Carriers) else base.max_speed
        self._angles = WheelAngles(encoder, base.count, top)
        self._order: StampOrder[Sample] = StampOrder(round(tuning.reorder_wait * NANOSECONDS))
        self._turn: list[list[float]] = imu.base_from_sensor().tolist()
        self._straight = self._turn == np.eye(3).tolist()
        self._gyro_scale = float(imu.gyro_scale)
        self._period = round(NANOSECONDS / tuning.min_rate)
        self._counters = Counters()
        self._notes = unobservable(base)
        self._following = Following(base.count)
        self._published: int | None = None
        self._restarts = 0
        self._integrated = False
        self._base = base
        model = self._filter.model
        place = (np.column_stack([np.repeat(base.x, 2), np.repeat(base.y, 2)])
                 if isinstance(base, Carriers) else np.column_stack([base.x, base.y]))
        self._episodes = Episodes(self._filter.memory.rows, model.travel, place)

    def handle(self, sample: Sample) -> tuple[Estimate, ...]:
        """Take one sample; the estimates (0 or more) whose stamps are now settled."""
        kind = type(sample)
        stream = STREAM[kind]
        self._counters.received[stream] += 1
        refused, ready = self._order.push(sample.stamp_ns, ORDER[kind], sample)
        if refused:
            self._counters.reject(stream, refused)
            if self._order.went_back():
                self.restart()
                return ()
        if not ready:
            return ()
        found: list[Estimate] = []
        for item in ready:
            self._process(item, found)
        return tuple(found)

    def flush(self) -> tuple[Estimate, ...]:
        """Process what still waits: the recording has ended."""
        found: list[Estimate] = []
        for doubtful in self._order.doubtful:
            self._counters.reject(STREAM[type(doubtful)], 'stamp far ahead')
        for item in self._order.flush():
            self._process(item, found)
        return tuple(found)

    def past(self, last: bool = False) -> tuple[Piece, ...]:
        """Frames whose estimate no later reading can change, as they look by now; each is told
        once, in order. After the ``last`` sample of all, the rest."""
        return self._filter.past(last)

    def reject(self, stream: str, reason: str) -> None:
        """Count a message of ``stream`` that never became a sample."""
        self._counters.receive(stream)
        self._counters.reject(stream, reason)

    def restart(self) -> None:
        """Start again at the last pose with start-up covariance: the clock went back."""
        self._order.clear()
        self._angles.restart()
        self._following.restart()
        self._filter.restart()
        self._published = None
        self._restarts += 1

    @property
    def newest_ns(self) -> int | None:
        """Newest stamp of any sample since the start or restart."""
        return self._order.newest

    @property
    def episodes(self) -> tuple[SlipEpisode, ...]:
        """Slip episodes so far, the one that still lasts included."""
        return self._episodes.all()

    @property
    def health(self) -> Health:
        """Counters, biases, standstill and notes on what cannot be seen."""
        memory = self._filter.memory
        x, P, m = memory.x, memory.P, memory.m
        return Health(
            received=dict(self._counters.received), used=dict(self._counters.used),
            rejected=dict(self._counters.rejected), imu=self._imu_state(),
            gyro_bias=float(x[BG]), gyro_bias_sigma=math.sqrt(float(P[BG, BG])),
            accel_bias=(float(x[BAX]), float(x[BAY])),
            accel_bias_sigma=(math.sqrt(float(P[BAX, BAX])), math.sqrt(float(P[BAY, BAY]))),
            standstill=bool(m[STILL] > 0.0), stamp_jitter=math.sqrt(float(m[JITTER])),
            restarts=self._restarts, notes=self._all_notes())

    def _imu_state(self) -> str:
        if not self._counters.used.get('imu'):
            return 'none'
        m = self._filter.memory.m
        if m[HAVE_GYRO] > 0.0:
            return 'gyro + accelerometer' if m[HAVE_ACCEL] > 0.0 else 'gyro'
        return 'lost'

    def _all_notes(self) -> tuple[str, ...]:
        notes = list(self._notes)
        state = self._imu_state()
        if state == 'none':
            notes.append('no IMU: yaw and slip come from the wheels alone')
        elif state == 'gyro':
            notes.append('no accelerometer: slip of a whole diagonal cannot be seen')
        elif state == 'lost':
            notes.append('the IMU has fallen silent: yaw and slip come from the wheels alone')
        if self._integrated:
            notes.append('wheel speeds stand in for positions: drift is larger than it need be')
        for i in self._following.strays:
            notes.append(f'wheel {self._base.joint[i]} does not follow its command')
        for i in self._angles.absent():
            notes.append(f'wheel {self._base.joint[i]} has never sent an angle: is the joint '
                         'name right?')
        return tuple(notes)

    def _resume(self) -> None:
        """After a silence of all streams too long to be bridged: last pose, with doubt added."""
        memory = self._filter.memory
        pose, covariance = memory.x[PX:YAW + 1].copy(), memory.P[PX:YAW + 1, PX:YAW + 1].copy()
        self._filter.restart()
        self._angles.restart()
        self._filter.place(pose, covariance + np.eye(3))
        self._restarts += 1

    def _process(self, sample: Sample, found: list[Estimate]) -> None:
        stamp_ns = sample.stamp_ns
        body = self._filter
        if body.started and stamp_ns - body.memory.clock[NOW] > LONGEST_SILENCE:
            self._resume()
        if isinstance(sample, ImuSample):
            self._imu(sample)
        elif isinstance(sample, (WheelSample, TickSample)):
            if self._wheels(sample):
                found.append(self._publish(stamp_ns, 'encoder'))
                return
        elif isinstance(sample, PoseSample):
            self._pose(sample)
        elif isinstance(sample, ResetSample):
            self._filter.predict(stamp_ns)
            self._filter.reset()
            self._counters.use('odometry_reset')
        elif self._following.take(stamp_ns, sample.rate, self._angles.angle):
            self._counters.use('wheel_commands')
        else:
            self._counters.reject('wheel_commands', 'not one number a wheel')
        if self._published is not None and stamp_ns - self._published >= self._period:
            self._filter.predict(stamp_ns)
            found.append(self._publish(stamp_ns, 'predicted'))

    def _imu(self, sample: ImuSample) -> None:
        gyro, accel = sample.gyro, sample.accel
        if self._gyro_scale != 1.0:
            gyro = gyro / self._gyro_scale
        roll, pitch, wz = gyro.tolist()
        ax, ay, az = accel.tolist()
        if not self._straight:
            roll, pitch, wz = in_base(self._turn, roll, pitch, wz)
            ax, ay, _ = in_base(self._turn, ax, ay, az)
        if not abs(wz) <= FASTEST_TURN:
            if not math.isnan(wz):
                self._counters.reject('imu', 'gyro out of range')
                return
            wz = math.nan
        if not abs(ax) + abs(ay) <= HARDEST_PUSH:
            ax = ay = math.nan
        if math.isnan(wz) and math.isnan(ax):
            self._counters.reject('imu', 'not a number')
        elif self._filter.imu(sample.stamp_ns, wz, ax, ay, roll, pitch):
            self._counters.used['imu'] += 1
        else:
            self._counters.reject('imu', 'duplicate stamp')

    def _wheels(self, sample: WheelSample | TickSample) -> bool:
        stream = STREAM[type(sample)]
        reading = self._angles.read(sample)
        if isinstance(reading, str):
            self._counters.reject(stream, reading)
            return False
        self._counters.used[stream] += 1
        if reading.jumped:
            self._counters.reject(stream, 'implausible wheel jump')
        self._integrated = self._integrated or reading.integrated
        travel = reading.angle * self._filter.model.travel
        ready = self._filter.wheels(sample.stamp_ns, travel, reading.valid, reading.jumped,
                                    reading.integrated)
        if not ready and self._published is None and self._filter.armed:
            self._published = sample.stamp_ns
        return ready

    def _pose(self, sample: PoseSample) -> None:
        pose, covariance = sample.pose, sample.covariance
        if not (np.all(np.isfinite(pose)) and np.all(np.isfinite(covariance))):
            self._counters.reject('set_pose', 'not a number')
            return
        if np.max(np.abs(pose)) > FARTHEST or np.max(np.abs(covariance)) > FARTHEST ** 2:
            self._counters.reject('set_pose', 'out of range')
            return
        if np.min(np.linalg.eigvalsh(0.5 * (covariance + covariance.T))) < -1e-9:
            self._counters.reject('set_pose', 'covariance not positive')
            return
        self._counters.use('set_pose')
        self._filter.predict(sample.stamp_ns)
        self._filter.place(pose, covariance + 1e-10 * np.eye(3))

    def _publish(self, stamp_ns: int, source: str) -> Estimate:
        self._published = stamp_ns
        estimate = estimate_of_row(self._filter.row(), self._filter.model.wheels, stamp_ns, source)
        slip = estimate.slip
        if source == 'encoder' and (slip.body_probability >= START or self._episodes.lasts):
            wheel = self._filter.memory.wheel
            self._episodes.take(stamp_ns, slip.body_probability, slip.probability, wheel[SLIP],
                                wheel[STEP], wheel[FROZEN_FOR])
        return estimate


def in_base(rotation: list[list[float]], x: Number, y: Number,
            z: Number) -> tuple[Number, Number, Number]:
    """A rotation (3, 3) of one vector, or of columns of them: the same to the last bit."""
    a, b, c = rotation
    return (a[0] * x + a[1] * y + a[2] * z, b[0] * x + b[1] * y + b[2] * z,
            c[0] * x + c[1] * y + c[2] * z)
