"""What a verb that was interrupted leaves behind: files below ``--out`` begun or changed by it."""

from __future__ import annotations

import pathlib

_NAMED = 5

State = dict[pathlib.Path, tuple[int, int]]


class Leftover:
    """Looks before and after: nothing is said of files that were there and are as they were."""

    def __init__(self, place: str | None) -> None:
        """``place``: file or folder that the verb was told to write, None = it writes nothing."""
        self._place = None if place is None else pathlib.Path(place)
        self._before = self._state()

    def text(self) -> str:
        """``; incomplete: FILE, FILE and 2 more``, or nothing."""
        names = [str(path) for path, seen in sorted(self._state().items())
                 if self._before.get(path) != seen]
        if not names:
            return ''
        more = f' and {len(names) - _NAMED} more' if len(names) > _NAMED else ''
        return f'; incomplete: {", ".join(names[:_NAMED])}{more}'

    def _state(self) -> State:
        if self._place is None:
            return {}
        found: State = {}
        for path in [self._place, *self._place.rglob('*')]:
            try:
                status = path.stat()
            except OSError:  # not there, or gone meanwhile
                continue
            if path.is_file():
                found[path] = status.st_mtime_ns, status.st_size
        return found
