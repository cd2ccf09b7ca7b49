"""Episodes: connected times of slip with the wheels concerned, their kind and what was lost.

An episode starts when the body slips with probability 1/2 or more, and ends when that has not
been so for 0.15 s. Its wheels are those that were more likely slipping than not in a third of
its frames, or the likeliest one.
"""

from __future__ import annotations

from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.records import SlipEpisode

START = 0.5
QUIET_NS = 150_000_000
JAMMED = 0.05  # m/s: a wheel that hardly turns while it should
DRIVEN = 0.1  # m/s
DRAGGED = 0.15  # share of the stuck wheel's slip that others show if it is really jammed


class Episodes:
    """Collects episodes from estimates in the order of their stamps."""

    def __init__(self, rows: FloatArray, travel: FloatArray, positions: FloatArray) -> None:
        self._rows, self._travel = rows, travel
        self._positions = positions
        self._groups = _pairs(rows, positions)
        self.done: list[SlipEpisode] = []
        self._open: _Open | None = None

    def take(self, stamp_ns: int, body: float, probability: FloatArray, slip: FloatArray,
             speed: FloatArray, frozen: FloatArray) -> None:
        """One estimate: probabilities, slip speed (W,) m/s, wheel speed (W,) m/s,

        ``frozen`` (W,) s for which a wheel has not moved though the base does.
        """
        if body < START:
            if self._open is not None and stamp_ns - self._open.last > QUIET_NS:
                self.done.append(self._close(self._open))
                self._open = None
            return
        if self._open is None:
            self._open = _Open(stamp_ns, len(slip))
        self._open.add(stamp_ns, body, probability.tolist(), slip.tolist(), speed.tolist(),
                       frozen.tolist())

    @property
    def lasts(self) -> bool:
        """True while an episode has begun and not ended."""
        return self._open is not None

    def all(self) -> tuple[SlipEpisode, ...]:
        """Finished episodes, and the one that still lasts."""
        if self._open is None:
            return tuple(self.done)
        return (*self.done, self._close(self._open))

    def _close(self, found: _Open) -> SlipEpisode:
        count = max(found.frames, 1)
        wheels = tuple(i for i, n in enumerate(found.votes) if n * 3 >= count)
        if not wheels:
            wheels = (max(range(len(found.likely)), key=found.likely.__getitem__),)
        return SlipEpisode(found.start, found.last, wheels, self._kind(wheels, found),
                           found.probability, max(found.lost), found.peak)

    def _kind(self, wheels: tuple[int, ...], found: _Open) -> str:
        size = len(self._rows)
        worst = max(range(size), key=found.lost.__getitem__)
        if found.frozen[worst] > 0.2 and len(wheels) < size:
            # the encoder says the same of both; only a wheel that really stands drags the others
            others = max((lost for i, lost in enumerate(found.creep) if i != worst), default=0.0)
            return 'wheel jammed' if others > DRAGGED * found.creep[worst] else 'encoder dead'
        if found.standing > found.frames // 2:
            return 'pushed'
        if len(wheels) == 1:
            return 'single'
        if len(wheels) == size:
            return 'all'
        return self._groups.get(frozenset(wheels), 'several')


class _Open:
    """An episode that still lasts."""

    def __init__(self, stamp_ns: int, wheels: int) -> None:
        self.start = self.last = stamp_ns
        self.frames = 0
        self.votes = [0] * wheels
        self.likely = [0.0] * wheels
        self.lost = [0.0] * wheels
        self.creep = [0.0] * wheels
        self.frozen = [0.0] * wheels
        self.peak = self.probability = 0.0
        self.standing = 0

    def add(self, stamp_ns: int, body: float, probability: list[float], slip: list[float],
            speed: list[float], frozen: list[float]) -> None:
        dt = (stamp_ns - self.last) * 1e-9
        self.last = stamp_ns
        self.frames += 1
        self.probability = max(self.probability, body)
        for i, p in enumerate(probability):
            self.votes[i] += p > 0.5
            self.likely[i] += p
            self.lost[i] += abs(slip[i]) * dt * p
            self.creep[i] += abs(slip[i]) * dt
            self.frozen[i] = max(self.frozen[i], frozen[i])
            if p > 0.3:
                self.peak = max(self.peak, abs(slip[i]))
        if max(abs(v) for v in speed) < JAMMED and max(abs(v) for v in slip) > DRIVEN:
            self.standing += 1


def _pairs(rows: FloatArray, positions: FloatArray) -> dict[frozenset[int], str]:
    """Names of the two-wheel sets: diagonal (parallel rollers), axle (same x), side (same y)."""
    names: dict[frozenset[int], str] = {}
    size = len(rows)
    for i in range(size):
        for j in range(i + 1, size):
            cross = rows[i, 0] * rows[j, 1] - rows[i, 1] * rows[j, 0]
            same_x = abs(positions[i, 0] - positions[j, 0]) < 1e-3
            same_y = abs(positions[i, 1] - positions[j, 1]) < 1e-3
            if abs(cross) < 0.1 and not (same_x or same_y):
                names[frozenset((i, j))] = 'diagonal'
            elif same_x:
                names[frozenset((i, j))] = 'axle'
            elif same_y:
                names[frozenset((i, j))] = 'side'
    return names
