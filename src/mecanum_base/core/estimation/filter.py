"""Array face of the filter: model, memory and the kernels that act on them."""

from __future__ import annotations

import numpy as np

from mecanum_base.core.estimation.acceleration import cells
from mecanum_base.core.estimation.assembly import memory_of, model_of
from mecanum_base.core.estimation.frame import anchor, arm, predict, sound
from mecanum_base.core.estimation.geometry import Base
from mecanum_base.core.estimation.hindsight import forget
from mecanum_base.core.estimation.layout import (
    ANGLE,
    BG,
    CARRIED,
    EXTRA,
    GAP_X,
    GAP_Y,
    GAP_YAW,
    JITTER,
    LAST_FRAME,
    LAST_IMU,
    LAST_YAW,
    NOW,
    PAST,
    PX,
    REEL_ROWS,
    YAW,
    K,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.output import describe, row_size
from mecanum_base.core.estimation.reading import take_frame, take_imu
from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.estimation.smoother import Piece, Smoother
from mecanum_base.core.estimation.trail import free, hand_out, intact, settled, with_room
from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.parameter import FloatArray

POSE_SIGMA = 1e-4  # m, pose at a start or reset: it is exact by definition
YAW_SIGMA = 1e-5  # rad
SPEED_NOISE = 0.1  # share of a step that may be wrong where speed stands for position


class BodyFilter:
    """Filter of one base. Stamps in ns must not go back; readings are in base axes and m."""

    def __init__(self, base: Base, encoder: EncoderConfig, imu: ImuConfig,
                 tuning: EstimatorConfig, smoothed: bool = False) -> None:
        """``smoothed``: keep what becomes of every frame, for :meth:`past`."""
        self._base, self._tuning, self._smoothed = base, tuning, smoothed
        self.model: Model = model_of(base, encoder, imu, tuning)
        self.memory: Memory = memory_of(base, self.model, tuning)
        self._smoother = Smoother(self.model.travel)
        self._size = row_size(self.model.wheels)
        self.armed = False
        self.started = False

    @property
    def now_ns(self) -> int:
        """Stamp of the state."""
        return int(self.memory.clock[NOW])

    def imu(self, stamp_ns: int, gyro: float, accel_x: float, accel_y: float, roll: float,
            pitch: float) -> bool:
        """One IMU reading; False where it is older than the state."""
        if not self.started:
            self._start(stamp_ns)
        elif stamp_ns <= self.memory.clock[LAST_IMU] or stamp_ns < self.memory.clock[NOW]:
            return False
        take_imu(self.model, self.memory, stamp_ns, gyro, accel_x, accel_y, roll, pitch)
        return True

    def wheels(self, stamp_ns: int, travel: FloatArray, valid: FloatArray,
               jumped: tuple[int, ...], integrated: bool) -> bool:
        """One encoder frame, travel (W,) m; False for the first one, which only arms."""
        memory, model = self.memory, self.model
        if not self.started:
            self._start(stamp_ns)
        if not self.armed:
            predict(model, memory, stamp_ns)
            arm(model, memory, stamp_ns, travel)
            self.armed = True
            return False
        if integrated:
            dt = (stamp_ns - int(memory.clock[LAST_FRAME])) * 1e-9
            memory.wheel[EXTRA] += (SPEED_NOISE * dt) ** 2
            forget(memory)
        if jumped:  # this frame says nothing of such a wheel; from here on it counts anew
            valid = valid.copy()
            valid[list(jumped)] = 0.0
        self.reserve(1)
        memory = self.memory
        take_frame(model, memory, stamp_ns, cells(travel), cells(valid))
        for i in jumped:
            anchor(model, memory, i, float(travel[i]))
            forget(memory)
        return self.check()

    def predict(self, stamp_ns: int) -> None:
        """Carry state and covariance to ``stamp_ns`` without a reading."""
        now = self.memory.clock[NOW]
        behind = self.memory.m[CARRIED] > 0.0  # calm frames leave the covariance for later
        if self.started and (stamp_ns > now or (stamp_ns == now and behind)):
            predict(self.model, self.memory, stamp_ns)

    def reserve(self, frames: int) -> None:
        """Make room for what becomes of so many more frames, if that is kept at all."""
        if not self._smoothed or free(self.memory) >= frames:
            return
        self._settle(settled(self.memory))
        self.memory = with_room(self.memory, max(frames, len(self.memory.trail) // 2))

    def past(self, last: bool = False) -> tuple[Piece, ...]:
        """Frames as later ones show them, those not told before; ``last``: no frame follows."""
        if last:
            self._part(int(self.memory.reel[REEL_ROWS]))
        else:
            self._settle(settled(self.memory))
        return self._smoother.taken()

    def _settle(self, rows: int) -> None:
        if rows:
            self.memory, stamp, found = hand_out(self.memory, rows)
            self._smoother.take(stamp, found)

    def _part(self, rows: int) -> None:
        """What comes after the first ``rows`` frames has nothing to say of them."""
        self._settle(rows)
        self._smoother.end()

    def row(self) -> FloatArray:
        """Output row of this moment, a fresh array laid out as in :mod:`.output`."""
        row = np.empty(self._size)
        describe(self.model, self.memory, row)
        return row

    def place(self, pose: FloatArray, covariance: FloatArray) -> None:
        """Put the base at ``pose`` (3,) with ``covariance`` (3, 3); all else is kept."""
        self._part(int(self.memory.reel[REEL_ROWS]))
        self.predict(self.now_ns)
        x, P = self.memory.x, self.memory.P
        x[PX:YAW + 1] = pose
        P[PX:YAW + 1, :] = 0.0
        P[:, PX:YAW + 1] = 0.0
        P[PX:YAW + 1, PX:YAW + 1] = 0.5 * (covariance + covariance.T)
        self.memory.m[LAST_YAW] = x[YAW]
        for k in (GAP_X, GAP_Y, GAP_YAW):
            self.memory.m[k] = 0.0
        forget(self.memory)
        self.row()  # kept: calm frames repeat it

    def reset(self) -> None:
        """Pose 0, 0, 0 and slip angles 0; biases and calibration are kept."""
        self.memory.wheel[ANGLE] = 0.0
        for slot in range(PAST):
            for k in range(1 + 2 * self.model.wheels):
                self.memory.past[slot, k] = 0.0
        self.place(np.zeros(3), np.diag([POSE_SIGMA ** 2, POSE_SIGMA ** 2, YAW_SIGMA ** 2]))

    def restart(self) -> None:
        """Last pose and learnt values, start-up covariance, all stamps and anchors forgotten."""
        self._part(int(self.memory.reel[REEL_ROWS]))
        old = self.memory.x.copy()
        jitter = float(self.memory.m[JITTER])
        self.memory = memory_of(self._base, self.model, self._tuning)
        keep = [*range(PX, YAW + 1), *range(BG, K + self.model.wheels)]
        if np.all(np.isfinite(old[keep])):
            self.memory.x[keep] = old[keep]
            self.memory.m[JITTER] = jitter
        self.armed = self.started = False

    def check(self) -> bool:
        """True while every number is finite and every variance positive; else roll back, widen."""
        memory = self.memory
        if memory.m[CARRIED] > 0.0:
            return True
        if sound(memory):
            return True
        self.recover()
        return False

    def recover(self) -> None:
        """Last known pose, start-up covariance with a metre of doubt on the pose."""
        self._part(intact(self.memory))
        fresh = memory_of(self._base, self.model, self._tuning)
        for i in range(PX, YAW + 1):
            if np.isfinite(self.memory.x[i]):
                fresh.x[i] = self.memory.x[i]
        fresh.P[0, 0] = fresh.P[1, 1] = fresh.P[2, 2] = 1.0
        fresh.clock[:] = self.memory.clock
        self.memory = fresh
        self.armed = False

    def _start(self, stamp_ns: int) -> None:
        for k in (NOW, LAST_IMU, LAST_FRAME):
            self.memory.clock[k] = stamp_ns
        self.started = True
