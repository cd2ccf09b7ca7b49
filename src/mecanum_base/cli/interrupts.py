"""Ctrl-C that is not lost: Python drops a KeyboardInterrupt inside callbacks of C libraries.

(numba loads compiled code through such callbacks.) It is sent again a moment later.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator
from typing import Any

_LATER = 0.05  # s, until the callback has returned


@contextlib.contextmanager
def kept() -> Iterator[None]:
    """Send an interrupt again that a callback swallowed."""
    usual, main = sys.unraisablehook, threading.main_thread().ident or 0

    def hook(unraisable: Any) -> None:
        if not issubclass(unraisable.exc_type, KeyboardInterrupt):
            usual(unraisable)
            return
        again = threading.Timer(_LATER, signal.pthread_kill, [main, signal.SIGINT])
        again.daemon = True
        again.start()

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = usual
