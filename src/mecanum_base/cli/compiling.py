"""What a user is told while the kernels of the estimator are compiled: a line that counts time.

Numba compiles at the first call after an installation or a change; that takes minutes, and a
command that says nothing for minutes looks dead. Numba tells when it begins; what is loaded from
its cache begins nothing.
"""

from __future__ import annotations

import importlib
import sys
import threading
import time
from types import TracebackType
from typing import Any, TextIO

_PERIOD = 1.0  # s between two drawings


class CompileNotice:
    """One line on stderr as soon as numba compiles something; a context manager.

    On a terminal the line counts the seconds and is cleared at the end.
    """

    def __init__(self, title: str, stream: TextIO | None = None) -> None:
        """``title`` is the command that waits."""
        self._text = f'{title}: compiling, once for this computer, 2 to 5 minutes'  # < 80 columns
        self._stream = stream or sys.stderr
        self._begin: float | None = None
        self._over = threading.Event()
        self._thread: threading.Thread | None = None
        self._watch: Any = None

    def begin(self) -> None:
        """Compiling begins; said once."""
        if self._begin is not None or self._over.is_set():
            return
        self._begin = time.monotonic()
        if self._stream.isatty():
            self._thread = threading.Thread(target=self._count, name='compiling', daemon=True)
            self._thread.start()
        else:
            print(self._text, file=self._stream, flush=True)

    def end(self) -> None:
        """Nothing compiles any more, or nobody waits for it."""
        self._over.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
            self._stream.write('\r\x1b[K')
            self._stream.flush()

    def __enter__(self) -> CompileNotice:
        event: Any = importlib.import_module('numba.core.event')

        class Watch(event.Listener):  # type: ignore[misc,name-defined,unused-ignore]
            """Passes on the beginning of a compilation."""

            def on_start(self, event: Any) -> None:
                """Something compiles."""
                notice.begin()

            def on_end(self, event: Any) -> None:
                """One function is done; others follow."""

        notice = self
        self._watch = Watch()
        event.register('numba:compile', self._watch)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        event: Any = importlib.import_module('numba.core.event')
        event.unregister('numba:compile', self._watch)
        self.end()

    def _count(self) -> None:
        assert self._begin is not None
        while True:
            seconds = time.monotonic() - self._begin
            self._stream.write(f'\r{self._text}: {seconds:.0f} s\x1b[K')
            self._stream.flush()
            if self._over.wait(_PERIOD):
                return
