"""Tells a clock that was set back from single samples with a wrong or late stamp.

    set back  <=>  no stamp newer than (newest - 1 s) for 0.2 s of data, measured on old stamps

A bag played in a loop, a simulation started again or a real clock put right sends every stream
back at once; a driver with a wrong clock or one corrupt stamp does not. Stamps are in ns. Not
modelled: steps of less than a second, which the estimator sees as late samples.
"""

from __future__ import annotations

BACK = 1_000_000_000  # ns; farther back than any sample may be late
CONFIRM = 200_000_000  # ns of data without a newer stamp


class ClockWatch:
    """Looks at the stamp of every sensor sample in the order of arrival."""

    def __init__(self) -> None:
        self.newest_ns: int | None = None
        self._old_since: int | None = None

    def set_back(self, stamp_ns: int) -> bool:
        """True once when the clock of the data turns out to have been set back."""
        if self.newest_ns is None or stamp_ns >= self.newest_ns - BACK:
            self.newest_ns = max(stamp_ns, self.newest_ns or stamp_ns)
            self._old_since = None
            return False
        if self._old_since is None or stamp_ns < self._old_since:
            self._old_since = stamp_ns
        if stamp_ns - self._old_since < CONFIRM:
            return False
        self.newest_ns, self._old_since = stamp_ns, None
        return True
