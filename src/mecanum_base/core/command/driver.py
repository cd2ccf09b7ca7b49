"""From commands to wheel rates: stopping rules, limits, saturation, in this order.

    wanted twist -> velocity limit -> wheel limits -> acceleration and jerk -> H -> wheel rates

The wheel limits are applied to the wanted twist, so that the ramp ends at a twist the wheels can
serve; with roller wheels every twist on the way can then be served too. With hinged carriers H
changes on the way, so the result is checked again and the ramp goes on from what was told.

Ramps advance in whole periods of ``drive.rate``, as many as have passed (rounded, the rest is
carried over): a timer that comes a little early or late does not make the ramp uneven.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mecanum_base.core.command.drive import DriveConfig
from mecanum_base.core.command.geometry import Geometry
from mecanum_base.core.command.limiter import TwistLimiter, TwistLimits
from mecanum_base.core.command.stopping import Stopping
from mecanum_base.core.kinematics.saturation import desaturate
from mecanum_base.core.parameter import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """What the wheels are told: ``twist`` (3,) in base_link and the ``rates`` (W,) rad/s of it."""

    twist: FloatArray
    rates: FloatArray


class Driver:
    """Everything the drive node does, without ROS: commands and times in, wheel rates out."""

    def __init__(self, geometry: Geometry, drive: DriveConfig) -> None:
        self.geometry = geometry
        self.stopping = Stopping(drive.command_timeout, drive.start_enabled)
        self._limiter = TwistLimiter(TwistLimits.from_config(drive))
        self._last_ns: int | None = None
        self._owed = 0.0  # s that passed and that the ramp has not advanced yet
        self.wanted: FloatArray = np.zeros(3)
        self.configure(drive)

    def configure(self, drive: DriveConfig) -> None:
        """Take over changed limits and times; the base goes on from its present twist."""
        self._drive = drive
        self.stopping.timeout = drive.command_timeout
        self._limiter.limits = TwistLimits.from_config(drive)

    @property
    def longest_step(self) -> float:
        """Between two steps at most [s]; after a longer pause nobody knows what the base does."""
        return max(self._drive.command_timeout, 3.0 / self._drive.rate)

    def stop(self, reason: str) -> Told:
        """Zeros at once; the ramp starts again from zero."""
        self.stopping.stop(reason)
        return self._stand()

    def enable(self, on: bool, reason: str) -> Told | None:
        """Switch driving on or off; the zeros to send at once when it was switched off."""
        self.stopping.enable(on, reason)
        return self._stand() if self.stopping.at_once else None

    def step(self, now_ns: int) -> Told:
        """Wheel rates at ``now_ns`` (nanoseconds of a clock that the caller uses throughout).

        A clock that jumps back, or a pause that is too long, stops the base: zeros at once.
        """
        last, self._last_ns = self._last_ns, now_ns
        dt = 0.0 if last is None else (now_ns - last) * 1e-9
        if self.stopping.at_once:
            return self._stand()
        if dt < 0.0:
            return self.stop(f'the clock jumped back by {-dt:.3f} s')
        if dt > self.longest_step:
            return self.stop(f'{dt:.3f} s passed between two steps')
        self.wanted = self.stopping.wanted(now_ns)
        matrix, limits = self.geometry.matrix(), self.geometry.limits
        reachable = desaturate(matrix, self._limiter.limits.within_velocity(self.wanted),
                               limits, self._drive.keep_yaw)
        periods = self._periods(dt)
        for _ in range(periods):
            self._limiter.step(reachable, self._period)
        twist = self._limiter.twist
        served = desaturate(matrix, twist, limits, self._drive.keep_yaw)
        if not np.allclose(served, twist, rtol=1e-12, atol=0.0):
            self._limiter.reset(served)
        self.geometry.move(served, periods * self._period)
        return Told(served, matrix @ served)

    @property
    def _period(self) -> float:
        return 1.0 / self._drive.rate

    def _periods(self, dt: float) -> int:
        self._owed += dt
        periods = max(0, round(self._owed / self._period))
        self._owed -= periods * self._period
        return periods

    def _stand(self) -> Told:
        self._limiter.reset()
        self._owed = 0.0
        self.wanted = np.zeros(3)
        return Told(np.zeros(3), np.zeros(len(self.geometry.limits)))
