"""Do the wheels follow their commands? An optional extra witness, in words.

    stray:  (a_1 - a_0) / (t_1 - t_0)  outside  [min c - tol, max c + tol]
    tol  =  LEAST + SHARE max |c| + 2 q / (t_1 - t_0)

a angle of the wheel [rad] in the first encoder frame of two windows of WINDOW, t its stamp, c the
commands [rad/s] in force from t_0 - LAG to t_1, q resolution of the encoder [rad]. Comparing over
windows that begin and end with a frame makes encoders slower than the commands no stray; the
range of commands forgives motors that lag or ramp. A wheel that strays for half a second is
named. The command is no evidence of motion, so it changes no estimate. Windows lie on multiples
of WINDOW of the stamps: how the data is cut into calls does not matter. Not modelled: torque, so
a jammed wheel and a dead encoder look alike.
"""

from __future__ import annotations

import numpy as np

from mecanum_base.core.parameter import FloatArray, IntArray

LEAST = 1.0  # rad/s
SHARE = 0.3
PATIENCE = 0.5  # s
LONGEST = 500_000_000  # ns between commands; older ones say nothing of now
WINDOW = 250_000_000  # ns
LAG = 200_000_000  # ns in which a wheel may still do what it was told before
HOLD = 300_000_000  # ns that commands may come later than the wheel angles
BACK = 1_000_000_000  # ns by which stamps go back where the clock starts anew
_LONGEST_STEP = 1.0  # s between two readings of a wheel that can still be compared
_MOST = 4096  # calls of commands kept while no wheel angles come


class Following:
    """Watches W wheels; ``resolution`` [rad] of their encoders, a number or (W,).

    Feed it commands and wheel angles as they come, in any cut; it compares them once the angles
    are HOLD further, or with :meth:`flush`.
    """

    def __init__(self, wheels: int, resolution: FloatArray | float = 0.0) -> None:
        self._wheels, self._resolution = wheels, resolution
        self.seconds = np.zeros(wheels)  # s each wheel strayed in all
        self.first_ns = [0] * wheels  # where it strayed first, if it did
        self.restart()

    def restart(self) -> None:
        """Forget commands and angles; what is counted stays."""
        self._stray = [0.0] * self._wheels
        self._commands: list[tuple[IntArray, FloatArray]] = []
        self._frames: list[tuple[IntArray, FloatArray]] = []
        self._edge_ns: int | None = None  # the frame up to which all is compared
        self._edge_stamp = np.zeros(self._wheels, dtype=np.int64)
        self._edge_angle = np.full(self._wheels, np.nan)
        self._newest_ns: int | None = None
        self._window: int | None = None

    @property
    def strays(self) -> tuple[int, ...]:
        """Wheels that do not follow at the moment."""
        return tuple(i for i, t in enumerate(self._stray) if t >= PATIENCE)

    def take(self, stamp_ns: int, rate: FloatArray, angle: FloatArray) -> bool:
        """One command (W,) rad/s with the wheel angles (W,) rad of that moment.

        False if the command has the wrong length or no finite number.
        """
        if len(rate) != self._wheels or not np.isfinite(rate).any():
            return False
        stamp = np.array([stamp_ns], dtype=np.int64)
        self.angles(stamp, angle[None].copy())
        self.commands(stamp, rate[None])
        return True

    def commands(self, stamp_ns: IntArray, rate: FloatArray) -> None:
        """Commands (N, W) rad/s with stamps (N,); NaN where a wheel has none."""
        self._commands.append((stamp_ns, rate))
        if len(self._commands) > _MOST:
            self._commands = self._commands[-_MOST // 2:]

    def angles(self, stamp_ns: IntArray, angle: FloatArray) -> None:
        """Unwrapped angles (N, W) rad in order of arrival; NaN where a wheel was not read."""
        if not len(stamp_ns):
            return
        before = int(stamp_ns[0]) if self._newest_ns is None else self._newest_ns
        back = np.flatnonzero(np.diff(stamp_ns, prepend=before) < -BACK)
        if len(back):  # the clock went back: only what comes behind that counts
            stamp_ns, angle = stamp_ns[back[-1]:], angle[back[-1]:]
            new = [(c[near], rate[near]) for c, rate in self._commands
                   if (near := c < stamp_ns[0] + BACK).any()]
            self.restart()
            self._commands = new
        self._newest_ns = int(stamp_ns[-1])
        self._frames.append((stamp_ns, angle))
        window = int(stamp_ns[-1]) // WINDOW
        if window != self._window:
            self._window = window
            self._compare(int(stamp_ns.max()) - HOLD)

    def flush(self) -> None:
        """The end of the data: compare what still waits."""
        self._compare(None)

    def _compare(self, until_ns: int | None) -> None:
        """Compare all windows that end until then."""
        if not self._frames:
            return
        stamp, angle = _sorted(self._frames)
        if self._edge_ns is not None:
            fresh = stamp > self._edge_ns
            stamp, angle = stamp[fresh], angle[fresh]
        self._frames = [(stamp, angle)] if len(stamp) else []
        window = stamp // WINDOW
        before = -1 if self._edge_ns is None else self._edge_ns // WINDOW
        edges = np.flatnonzero(np.diff(window, prepend=before) != 0)
        if until_ns is not None:
            edges = edges[stamp[edges] <= until_ns]
        if not len(edges):
            return
        at, ends = self._read_last(stamp, angle, edges)
        if self._edge_ns is None:
            found_ns = stamp[edges]
        else:
            found_ns = np.concatenate(([self._edge_ns], stamp[edges]))
            at = np.concatenate((self._edge_stamp[None], at))
            ends = np.concatenate((self._edge_angle[None], ends))
        if len(found_ns) > 1 and self._commands:
            self._judge(found_ns, at, ends)
        self._edge_ns, self._edge_stamp, self._edge_angle = int(found_ns[-1]), at[-1], ends[-1]
        rest = stamp > self._edge_ns
        self._frames = [(stamp[rest], angle[rest])] if rest.any() else []

    def _read_last(self, stamp: IntArray, angle: FloatArray,
                   edges: IntArray) -> tuple[IntArray, FloatArray]:
        """Stamp and angle (E, W) of each wheel's last reading up to each frame of ``edges``."""
        good = np.isfinite(angle)
        row = np.maximum.accumulate(
            np.where(good, np.arange(len(stamp))[:, None], -1), axis=0)[edges]
        column = np.arange(self._wheels)
        return (np.where(row < 0, self._edge_stamp, stamp[row]),
                np.where(row < 0, self._edge_angle, angle[row, column]))

    def _judge(self, edge_ns: IntArray, at: IntArray, angle: FloatArray) -> None:
        """Compare the stretches between consecutive frames of ``edge_ns`` (E,)."""
        stamp, rate = _sorted(self._commands)
        begin, end = edge_ns[:-1], edge_ns[1:]
        first = np.maximum(np.searchsorted(stamp, begin - LAG, side='right') - 1, 0)
        stop = np.searchsorted(stamp, end, side='right')
        pauses = np.concatenate(([0], np.cumsum(np.diff(stamp) > LONGEST)))
        last = np.maximum(stop - 1, 0)
        known = ((stamp[first] <= begin) & (stop > first) & (pauses[last] == pauses[first])
                 & (end - stamp[last] <= LONGEST))
        pairs = np.column_stack([first, np.maximum(stop, first + 1)]).ravel()
        padded = np.concatenate([rate, rate[-1:]])
        low = np.minimum.reduceat(padded, pairs, axis=0)[::2]
        high = np.maximum.reduceat(padded, pairs, axis=0)[::2]
        with np.errstate(all='ignore'):  # NaN compares False: what is not known is no stray
            dt = np.diff(at, axis=0) * 1e-9
            dt[~((dt > 0.0) & (dt <= _LONGEST_STEP))] = np.nan
            turned = np.diff(angle, axis=0) / dt
            spare = (LEAST + SHARE * np.maximum(np.abs(low), np.abs(high))
                     + 2.0 * self._resolution / dt)
            off = ((turned < low - spare) | (turned > high + spare)) & known[:, None]
        if off.any() or any(self._stray):
            self._count(off, begin, ((end - begin) * 1e-9).tolist())
        keep = max(int(np.searchsorted(stamp, edge_ns[-1] - LAG, side='right')) - 1, 0)
        self._commands = [(stamp[keep:], rate[keep:])]

    def _count(self, off: FloatArray, begin: IntArray, seconds: list[float]) -> None:
        for astray, begin_ns, dt in zip(off.tolist(), begin.tolist(), seconds):
            for i, is_off in enumerate(astray):
                before = self._stray[i]
                self._stray[i] = before + dt if is_off else 0.0
                if self._stray[i] < PATIENCE:
                    continue
                if self.seconds[i] == 0.0:
                    self.first_ns[i] = begin_ns - round(before * 1e9)
                self.seconds[i] += dt if before >= PATIENCE else self._stray[i]


def _sorted(parts: list[tuple[IntArray, FloatArray]]) -> tuple[IntArray, FloatArray]:
    """Parts as one, in the order of their stamps."""
    if len(parts) == 1:
        stamp, value = parts[0]
    else:
        stamp = np.concatenate([part[0] for part in parts])
        value = np.concatenate([part[1] for part in parts])
    if (stamp[1:] >= stamp[:-1]).all():
        return stamp, value
    order = np.argsort(stamp, kind='stable')
    return stamp[order], value[order]
