"""A progress line on a terminal: share done, rate and remaining time; nothing in a pipe."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TextIO

_PERIOD = 0.1  # s between two drawings
_WIDTH = 24


class Progress:
    """Draws one line on stderr while work goes on and clears it at the end."""

    def __init__(self, title: str, stream: TextIO | None = None) -> None:
        """``title`` stands before the bar."""
        self._title = title
        self._stream = stream or sys.stderr
        self._shown = self._stream.isatty()
        self._begin = time.monotonic()
        self._before = 0.0
        self._next = self._begin + _PERIOD

    def mark(self, share: float) -> None:
        """What is done so far (``share``) says nothing of the rest: remaining time from here."""
        self._begin, self._before = time.monotonic(), share

    def update(self, share: float, rate: str = '') -> None:
        """``share`` 0..1 of the work is done; ``rate`` is shown as given."""
        now = time.monotonic()
        if not self._shown or now < self._next:
            return
        self._next = now + _PERIOD
        share = min(max(share, 0.0), 1.0)
        done = share - self._before
        left = (now - self._begin) * (1.0 - share) / done if done > 0.0 else 0.0
        bar = '#' * int(_WIDTH * share)
        self._stream.write(f'\r{self._title} [{bar:<{_WIDTH}}] {share:4.0%}  {rate}  '
                           f'{left:4.0f} s left\x1b[K')
        self._stream.flush()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        if self._shown:
            self._stream.write('\r\x1b[K')
            self._stream.flush()
