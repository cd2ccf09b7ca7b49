"""The time before a verb runs, in which nothing is written: an interrupt ends the process at once.

A KeyboardInterrupt would not do: imports drop it where it comes in a callback of theirs.
"""

from __future__ import annotations

import os
import signal
from typing import Any


class _End:
    """A handler of SIGINT that ends the process."""

    def __init__(self, code: int) -> None:
        self._code = code

    def __call__(self, _number: int, _frame: Any) -> None:
        os._exit(self._code)


def interrupts_end_it(code: int) -> None:
    """From now on Ctrl-C ends the process with ``code``; not where somebody ignores it or has
    other plans."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _End(code))


def interrupts_are_raised() -> None:
    """The verb runs: Ctrl-C is a KeyboardInterrupt again."""
    if isinstance(signal.getsignal(signal.SIGINT), _End):
        signal.signal(signal.SIGINT, signal.default_int_handler)
