"""Do the wheels follow their commands? An optional extra witness, in words.

Between two commands the mean measured rate of each wheel is compared with the older command. A
wheel that has been off by more than 1 rad/s and 30 % for half a second is named. The command is
no evidence of motion, so it changes no estimate: a controller that ramps or saturates must not be
taken for slip.
"""

from __future__ import annotations

import math

from mecanum_base.core.parameter import FloatArray

LEAST = 1.0  # rad/s
SHARE = 0.3
PATIENCE = 0.5  # s
LONGEST = 0.5  # s between commands; older ones say nothing of now


class Following:
    """Watches W wheels; feed it every command with the wheel angles (W,) rad of that moment."""

    def __init__(self, wheels: int) -> None:
        self._wheels = wheels
        self.restart()

    def restart(self) -> None:
        """Forget the last command."""
        self._stray = [0.0] * self._wheels
        self._last: tuple[int, list[float], list[float]] | None = None

    def take(self, stamp_ns: int, rate: FloatArray, angle: FloatArray) -> bool:
        """One command (W,) rad/s; False if it has the wrong length or no finite number."""
        if len(rate) != self._wheels or not any(math.isfinite(r) for r in rate.tolist()):
            return False
        last, self._last = self._last, (stamp_ns, rate.tolist(), angle.tolist())
        if last is None or not 0 < stamp_ns - last[0] <= LONGEST * 1e9:
            return True
        dt = (stamp_ns - last[0]) * 1e-9
        for i, (old, new, wanted) in enumerate(zip(last[2], angle.tolist(), last[1])):
            off = abs((new - old) / dt - wanted)
            if off > LEAST + SHARE * abs(wanted):
                self._stray[i] += dt
            else:
                self._stray[i] = 0.0
        return True

    @property
    def strays(self) -> tuple[int, ...]:
        """Wheels that do not follow at the moment."""
        return tuple(i for i, t in enumerate(self._stray) if t >= PATIENCE)
