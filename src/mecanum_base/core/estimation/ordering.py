"""Merge of all streams by stamp, with bounded patience measured in data time.

A sample waits until a stamp newer by ``wait`` has been seen on any stream, then leaves in the
order of (stamp, kind, arrival). A sample older than newest - wait on arrival is late and refused.
Acceptance depends on stamps alone, so any arrival order within ``wait`` gives the same sequence.
One stamp far ahead of all others is held until a second one confirms it: a single wrong stamp
must not make everything else late.
"""

from __future__ import annotations

import heapq
from typing import Generic, TypeVar

Item = TypeVar('Item')

FAR_NS = 2_000_000_000  # a step of the newest stamp beyond this needs a second witness
BACK_NS = 1_000_000_000  # samples this late in a row mean that the clock has gone back
WITNESSES = 8  # how many


class StampOrder(Generic[Item]):
    """Samples in, samples in the order of their stamps out."""

    def __init__(self, wait_ns: int) -> None:
        self._wait = wait_ns
        self._queue: list[tuple[int, int, int, Item]] = []
        self._count = 0
        self._newest: int | None = None
        self._held: list[tuple[int, int, Item]] = []
        self._behind: list[int] = []

    @property
    def newest(self) -> int | None:
        """Newest stamp seen on any stream, None before the first."""
        return self._newest

    def went_back(self) -> bool:
        """True if the last samples in a row were all far behind and near one another."""
        return len(self._behind) >= WITNESSES

    def is_late(self, stamp_ns: int) -> bool:
        """True where this stamp comes too late to be merged."""
        return self._newest is not None and stamp_ns < self._newest - self._wait

    def push(self, stamp_ns: int, kind: int, item: Item) -> tuple[str, list[Item]]:
        """Take one sample; returns ('', 'late' or 'stamp far ahead' for dropped ones, ready).

        ``kind`` orders samples of equal stamps.
        """
        newest = self._newest
        refused = ''
        if newest is None:
            newest = stamp_ns
        elif not newest - self._wait <= stamp_ns <= newest + FAR_NS:
            if stamp_ns < newest:
                self._count_behind(stamp_ns, newest)
                return 'late', []
            refused, enough = self._hold(stamp_ns, kind, item)
            if not enough:
                return refused, []
            newest = self._newest or newest  # the one held before may be newer still
        if self._behind:
            self._behind = []
        queue = self._queue
        heapq.heappush(queue, (stamp_ns, kind, self._count, item))
        self._count += 1
        self._newest = max(newest, stamp_ns)
        limit, ready = self._newest - self._wait, []
        while queue and queue[0][0] < limit:
            ready.append(heapq.heappop(queue)[3])
        return refused, ready

    def _hold(self, stamp_ns: int, kind: int, item: Item) -> tuple[str, bool]:
        """A stamp far ahead: is it the second one? Then the first is taken back into the merge."""
        lone = len(self._held)
        self._held = [h for h in self._held if abs(h[0] - stamp_ns) <= FAR_NS]
        refused = 'stamp far ahead' if len(self._held) < lone else ''
        if not self._held:
            self._held.append((stamp_ns, kind, item))
            return refused, False
        for held_stamp, held_kind, held in self._held:
            self._put(held_stamp, held_kind, held)
        self._held = []
        return refused, True

    def _count_behind(self, stamp_ns: int, newest_ns: int) -> None:
        """A late stamp: does the clock seem to have gone back?"""
        if stamp_ns < newest_ns - BACK_NS:
            near = self._behind and abs(stamp_ns - self._behind[-1]) < BACK_NS
            self._behind = [*self._behind, stamp_ns] if near else [stamp_ns]

    @property
    def doubtful(self) -> tuple[Item, ...]:
        """Samples whose stamps lie far ahead and that no second one has confirmed yet."""
        return tuple(item for _, _, item in self._held)

    def flush(self) -> list[Item]:
        """Everything that still waits, in order; a stamp held as doubtful is dropped."""
        self._held = []
        return [heapq.heappop(self._queue)[3] for _ in range(len(self._queue))]

    def clear(self) -> None:
        """Forget everything, stamps included: the clock starts anew."""
        self._queue, self._held, self._behind, self._newest = [], [], [], None

    def _put(self, stamp_ns: int, kind: int, item: Item) -> None:
        heapq.heappush(self._queue, (stamp_ns, kind, self._count, item))
        self._count += 1
        if self._newest is None or stamp_ns > self._newest:
            self._newest = stamp_ns
