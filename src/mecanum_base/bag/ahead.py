"""Work beside the main thread: make items ahead of their use, do jobs behind their order.

Unpacking, decoding and writing spend their time in numpy and in libraries that let other threads
run meanwhile; so does the compiled filter. Order is kept, only a few items are held, and an error
of the thread is raised where its item would have been taken or its next job is given.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Generic, TypeVar

Item = TypeVar('Item')
_DEPTH = 3  # items held between the threads
_POLL = 0.05  # s between two looks at whether the other side has given up


class Ahead(Generic[Item]):
    """Iterates ``items`` in a thread, up to three items ahead; a context manager.

    ``items`` is only touched by that thread, which has ended when the context is left.
    """

    def __init__(self, items: Iterator[Item]) -> None:
        self._items = items
        self._made: queue.Queue[tuple[Item | None, BaseException | None]] = queue.Queue(_DEPTH)
        self._given_up = threading.Event()
        self._thread = threading.Thread(target=self._run, name='ahead', daemon=True)
        self._thread.start()

    def __iter__(self) -> Iterator[Item]:
        while True:
            item, error = self._made.get()
            if error is not None:
                raise error
            if item is None:
                return
            yield item

    def __enter__(self) -> Ahead[Item]:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._given_up.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            for item in self._items:
                if not self._put((item, None)):
                    return
            self._put((None, None))
        except BaseException as error:
            self._put((None, error))

    def _put(self, entry: tuple[Item | None, BaseException | None]) -> bool:
        while not self._given_up.is_set():
            try:
                self._made.put(entry, timeout=_POLL)
                return True
            except queue.Full:
                continue
        return False


class Behind:
    """Does jobs in a thread, in the order they were given, at most three behind."""

    def __init__(self) -> None:
        self._jobs: queue.Queue[Callable[[], None] | None] = queue.Queue(_DEPTH)
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name='behind', daemon=True)
        self._thread.start()

    def do(self, job: Callable[[], None]) -> None:
        """Do ``job`` after all others; raises what an earlier one has raised."""
        if self._error is not None:
            raise self._error
        self._jobs.put(job)

    def close(self) -> None:
        """Wait until everything is done; raises what a job has raised."""
        if self._thread.is_alive():
            self._jobs.put(None)
            self._thread.join()
        if self._error is not None:
            raise self._error

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            if self._error is None:
                try:
                    job()
                except BaseException as error:
                    self._error = error
