"""A stretch of a recording at once: what :class:`.estimator.Estimator` does, by columns.

Merging by stamp, unwrapping and range checks are done for all samples of the stretch together;
then one kernel runs the filter over them. Anything out of the ordinary (doubtful stamps, a clock
that may have gone back, missing wheels, jumps, absurd readings) is left to the estimator's own
``handle``, sample by sample: :func:`take` then returns None and has changed nothing. Both ways
give the same numbers.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from mecanum_base.core.estimation.encoder import SLACK, TWO_PI
from mecanum_base.core.estimation.episodes import START
from mecanum_base.core.estimation.estimator import (
    FASTEST_TURN,
    HARDEST_PUSH,
    LONGEST_SILENCE,
    ORDER,
    Estimator,
    in_base,
)
from mecanum_base.core.estimation.layout import FRAME, IMU
from mecanum_base.core.estimation.ordering import BACK_NS, FAR_NS
from mecanum_base.core.estimation.output import (
    BODY,
    POSE_COV,
    TWIST,
    WHEELS,
    estimate_of_row,
    row_size,
)
from mecanum_base.core.estimation.run_kernel import (
    ARMED,
    BROKEN,
    DONE,
    PUBLISHED,
    STALE_IMU,
    STARTED,
    USED_FRAME,
    USED_IMU,
    run,
)
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.records import Estimate, ImuSample, Sample, TickSample, WheelSample


@dataclass(slots=True, eq=False)
class Stretch:
    """Samples in order of arrival: ``kind`` (N,) IMU or FRAME, ``index`` (N,) into the columns.

    ``gyro``, ``accel`` (I, 3) in sensor axes; ``angle`` (F, W) rad as WheelSample.position, or
    int64 counts if ``ticks``; ``imu_ns`` (I,) and ``frame_ns`` (F,) stamps.
    """

    kind: IntArray
    index: IntArray
    imu_ns: IntArray
    gyro: FloatArray
    accel: FloatArray
    frame_ns: IntArray
    angle: FloatArray | IntArray
    ticks: bool


@dataclass(slots=True, eq=False)
class Rows:
    """Estimates as rows of :mod:`.output`: ``stamp_ns`` (R,), ``predicted`` (R,), ``table``."""

    stamp_ns: IntArray
    predicted: IntArray
    table: FloatArray
    wheels: int
    rest: tuple[Estimate, ...] = ()  # estimates after the rows, where the run ended early

    def at(self, row: int) -> Estimate:
        """One row as a record."""
        source = 'predicted' if self.predicted[row] else 'encoder'
        return estimate_of_row(self.table[row].copy(), self.wheels, int(self.stamp_ns[row]),
                               source)

    def estimates(self) -> tuple[Estimate, ...]:
        """The rows as records, then the rest."""
        return (*map(self.at, range(len(self.stamp_ns))), *self.rest)

    def track(self) -> FloatArray:
        """x y yaw vx vy wz and the covariance xx xy yy xyaw yyaw yawyaw of each row (R, 12)."""
        cov = [POSE_COV + k for k in (0, 1, 4, 2, 5, 8)]
        found: FloatArray = self.table[:, [*range(3), *range(TWIST, TWIST + 3), *cov]]
        return found

    def slip(self) -> FloatArray:
        """Slip rate and probability of each wheel in turn, then of the body (R, 2 W + 1)."""
        found = np.empty((len(self.table), 2 * self.wheels + 1))
        found[:, 0:-1:2] = self.table[:, WHEELS:WHEELS + self.wheels]
        found[:, 1:-1:2] = self.table[:, WHEELS + 2 * self.wheels:WHEELS + 3 * self.wheels]
        found[:, -1] = self.table[:, BODY]
        return found


def take(estimator: Estimator, stretch: Stretch, last: bool = False) -> Rows | None:
    """Give the stretch to the estimator; None where it must go sample by sample.

    After the ``last`` one nothing waits for late samples any more.
    """
    order, angles, body = estimator._order, estimator._angles, estimator._filter
    waiting = sorted(order._queue, key=lambda item: item[:3])
    items = [item[3] for item in waiting]
    usual = (ImuSample, TickSample if stretch.ticks else WheelSample)
    if (body.armed != (angles._stamp is not None)
            or not all(isinstance(item, usual) for item in items)):
        return None
    stamp = np.where(stretch.kind == IMU, _at(stretch.imu_ns, stretch.index),
                     _at(stretch.frame_ns, stretch.index))
    first = int(stamp[0]) if order._newest is None else order._newest
    newest = np.maximum.accumulate(np.concatenate((np.array([first], dtype=np.int64), stamp)))
    if (stamp < newest[:-1] - BACK_NS).any() or (stamp > newest[:-1] + FAR_NS).any():
        return None
    late = stamp < newest[:-1] - order._wait
    whole = _merged(items, _some(stretch, np.flatnonzero(~late)), estimator._filter.model.wheels)
    kind = whole.kind
    stamp = np.where(kind == IMU, _at(whole.imu_ns, whole.index), _at(whole.frame_ns, whole.index))
    sequence = np.lexsort((kind, stamp))  # stable: equal ones stay in order of arrival
    settled = sequence[last | (stamp[sequence] < newest[-1] - order._wait)]
    frames = whole.index[settled[kind[settled] == FRAME]]
    imus = whole.index[settled[kind[settled] == IMU]]
    push = _push(estimator, whole.gyro[imus], whole.accel[imus])
    turned = _turned(estimator, whole.frame_ns[frames], whole.angle[frames], whole.ticks)
    if push is None or turned is None:
        return None
    order._newest = int(newest[-1])
    order._queue = []
    if not late.all():  # one in time: the clock has not gone back
        order._behind = []
    for place in sequence[len(settled):]:  # still waiting: back into the merge
        sample = _sample(whole, int(place))
        order._put(sample.stamp_ns, ORDER[type(sample)], sample)
    stream = 'wheel_ticks' if whole.ticks else 'joint_states'
    for name, ours in (('imu', stretch.kind == IMU), (stream, stretch.kind == FRAME)):
        if ours.any():
            estimator._counters.received[name] += int(np.sum(ours))
        if (ours & late).any():
            estimator._counters.rejected[name, 'late'] += int(np.sum(ours & late))
    return _run(estimator, whole, settled, stamp[settled], push, turned, stream)


def _run(estimator: Estimator, whole: Stretch, settled: IntArray, stamp: IntArray,
         push: FloatArray, turned: FloatArray, stream: str) -> Rows:
    body, angles, wheels = estimator._filter, estimator._angles, estimator._filter.model.wheels
    kind = np.ascontiguousarray(whole.kind[settled])
    value = np.zeros((len(kind), max(5, wheels)))
    value[kind == IMU, :5] = push
    value[kind == FRAME, :wheels] = turned * body.model.travel
    table = np.empty((len(kind), row_size(wheels)))
    row_stamp = np.zeros(len(kind), dtype=np.int64)
    predicted = np.zeros(len(kind), dtype=np.int64)
    marks = np.zeros((len(kind), 3, wheels))
    counts = np.zeros(3, dtype=np.int64)
    last_row = -1 if estimator._published is None else estimator._published
    progress = np.array([body.started, body.armed, last_row], dtype=np.int64)
    limits = np.array([LONGEST_SILENCE, estimator._period], dtype=np.int64)
    body.reserve(int(np.sum(kind == FRAME)))
    taken, rows, reason = run(body.model, body.memory, kind, np.ascontiguousarray(stamp), value,
                              limits, progress, table, row_stamp, predicted, marks, counts)
    body.started, body.armed = bool(progress[STARTED]), bool(progress[ARMED])
    estimator._published = None if progress[PUBLISHED] < 0 else int(progress[PUBLISHED])
    for name, count in (('imu', counts[USED_IMU]), (stream, counts[USED_FRAME])):
        if count:
            estimator._counters.used[name] += int(count)
    for _ in range(int(counts[STALE_IMU])):
        estimator._counters.reject('imu', 'duplicate stamp')
    done = int(np.sum(kind[:taken] == FRAME))
    if done:
        last = int(whole.index[settled[np.flatnonzero(kind[:taken] == FRAME)[-1]]])
        angles._angle = turned[done - 1].copy()
        angles._stamp = int(whole.frame_ns[last])
        angles._seen = [angles._stamp] * wheels
        if whole.ticks:
            angles._ticks = whole.angle[last].tolist()
        else:
            angles._last = np.array(whole.angle[last], dtype=np.float64)
    _episodes(estimator, table[:rows], row_stamp, predicted, marks, wheels)
    rest: list[Estimate] = []
    if reason == BROKEN:
        body.recover()
        now = int(stamp[taken - 1])
        if estimator._published is not None and now - estimator._published >= estimator._period:
            body.predict(now)
            rest.append(estimator._publish(now, 'predicted'))
    if reason != DONE:
        for place in settled[taken:]:
            estimator._process(_sample(whole, int(place)), rest)
    return Rows(row_stamp[:rows], predicted[:rows], table[:rows], wheels, tuple(rest))


def _episodes(estimator: Estimator, table: FloatArray, stamp: IntArray, predicted: IntArray,
              marks: FloatArray, wheels: int) -> None:
    """Tell the slip episodes of every row that concerns them."""
    episodes = estimator._episodes
    chance = slice(WHEELS + 2 * wheels, WHEELS + 3 * wheels)
    likely = (table[:, BODY] >= START) & (predicted[:len(table)] == 0)
    begins = np.flatnonzero(likely)
    row = 0
    while row < len(table):
        if not episodes.lasts:  # nothing to tell before the next one begins
            after = begins[np.searchsorted(begins, row):]
            if not len(after):
                return
            row = int(after[0])
        if not predicted[row]:
            episodes.take(int(stamp[row]), float(table[row, BODY]), table[row, chance],
                          marks[row, 0], marks[row, 1], marks[row, 2])
        row += 1


def _at(column: IntArray, index: IntArray) -> IntArray:
    """column[index] where index may point into the other column: clipped, or 0 if empty."""
    if not len(column):
        return np.zeros(len(index), dtype=np.int64)
    found: IntArray = column[np.minimum(index, len(column) - 1)]
    return found


def _some(stretch: Stretch, chosen: IntArray) -> Stretch:
    """The stretch with these of its samples only."""
    return dataclasses.replace(stretch, kind=stretch.kind[chosen], index=stretch.index[chosen])


def _merged(items: list[Sample], stretch: Stretch, wheels: int) -> Stretch:
    """The samples that still wait, then the new ones, as one stretch."""
    imu = [s for s in items if isinstance(s, ImuSample)]
    frame = [s for s in items if isinstance(s, (WheelSample, TickSample))]
    kind = np.array([IMU if isinstance(s, ImuSample) else FRAME for s in items], dtype=np.int64)
    index = np.where(kind == IMU, np.cumsum(kind == IMU), np.cumsum(kind == FRAME)) - 1
    shift = np.where(stretch.kind == IMU, len(imu), len(frame))
    old = [s.counts if isinstance(s, TickSample) else s.position for s in frame]
    return Stretch(
        np.concatenate([kind, stretch.kind]), np.concatenate([index, stretch.index + shift]),
        np.concatenate([np.array([s.stamp_ns for s in imu], dtype=np.int64), stretch.imu_ns]),
        np.concatenate([np.reshape([s.gyro for s in imu], (-1, 3)), stretch.gyro]),
        np.concatenate([np.reshape([s.accel for s in imu], (-1, 3)), stretch.accel]),
        np.concatenate([np.array([s.stamp_ns for s in frame], dtype=np.int64), stretch.frame_ns]),
        np.concatenate([np.array(old, dtype=stretch.angle.dtype).reshape(-1, wheels),
                        stretch.angle]), stretch.ticks)


def _sample(whole: Stretch, place: int) -> Sample:
    """One sample of the stretch as a record."""
    index = int(whole.index[place])
    if whole.kind[place] == IMU:
        return ImuSample(int(whole.imu_ns[index]), whole.gyro[index], whole.accel[index])
    stamp = int(whole.frame_ns[index])
    if whole.ticks:
        return TickSample(stamp, whole.angle[index])
    row = whole.angle[index]
    return WheelSample(stamp, row, np.full(len(row), math.nan))


def _push(estimator: Estimator, gyro: FloatArray, accel: FloatArray) -> FloatArray | None:
    """Gyro z, acceleration x, y, gyro x, y (I, 5) in base axes; None if one is out of range."""
    if estimator._gyro_scale != 1.0:
        gyro = gyro / estimator._gyro_scale
    roll, pitch, yaw = gyro.T
    ax, ay, az = accel.T
    if not estimator._straight:
        roll, pitch, yaw = in_base(estimator._turn, roll, pitch, yaw)
        ax, ay, _ = in_base(estimator._turn, ax, ay, az)
    found = np.column_stack([yaw, ax, ay, roll, pitch])
    wz = found[:, 0]
    wild = ~(np.abs(found[:, 1]) + np.abs(found[:, 2]) <= HARDEST_PUSH)
    found[wild, 1:3] = math.nan
    fast = ~(np.abs(wz) <= FASTEST_TURN) & ~np.isnan(wz)
    if fast.any() or (np.isnan(wz) & wild).any():
        return None
    return found


def _turned(estimator: Estimator, stamp: IntArray, reading: FloatArray | IntArray,
            ticks: bool) -> FloatArray | None:
    """Angle (F, W) rad of each frame since arming; None where a reading is out of range."""
    angles = estimator._angles
    if angles._stamp is None:  # the first frame only arms: its step is 0
        last = reading[:1].copy()
        before = stamp[:1] - 1
    elif ticks != (angles._ticks is not None):
        return None
    else:
        last = np.array([angles._ticks] if ticks else angles._last[None], dtype=reading.dtype)
        before = np.array([angles._stamp], dtype=np.int64)
    dt = np.diff(np.concatenate([before, stamp])) * 1e-9
    if (dt <= 0.0).any():
        return None
    step = np.diff(np.concatenate([last, reading]), axis=0)  # counts wrap at 64 bits by themselves
    if ticks:
        if angles._span < 1 << 63:
            half = angles._span // 2
            step = (step + half) % angles._span - half
        step = step.astype(np.float64) * angles._radian * angles._sign
    else:
        step = step * angles._sign
        if angles._two_pi:
            step = (step + math.pi) % TWO_PI - math.pi
    most = angles._fastest * (dt[:, None] + SLACK) + angles._slack
    if not (np.abs(step) <= most).all():  # also where something is not finite
        return None
    found: FloatArray = np.cumsum(np.concatenate([angles._angle[None], step]), axis=0)[1:]
    return found
