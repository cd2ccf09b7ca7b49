"""Write estimates as files: odometry.tum, track.csv and slip.csv (one row per estimate), or those
with ``smoothed`` in their names.

Used by the odometry node and by ``mecanum replay`` alike, so that equal estimates give equal
bytes. Numbers are written exactly (:mod:`mecanum_base.bag.number_text`), stamps with all nine
decimals. Rows are gathered and written in groups; memory does not grow.
"""

from __future__ import annotations

import contextlib
import os
import pathlib
from collections.abc import Sequence
from types import TracebackType
from typing import Any, BinaryIO

import numpy as np

from mecanum_base.bag.row_text import texts_by_columns, texts_of
from mecanum_base.core.errors import BagError
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.records import Estimate

TRACK_COLUMNS = ('stamp', 'x', 'y', 'yaw', 'vx', 'vy', 'wz', 'cov_xx', 'cov_xy', 'cov_yy',
                 'cov_xyaw', 'cov_yyaw', 'cov_yawyaw', 'source')
SOURCES = ('encoder', 'predicted')
FILES = ('odometry.tum', 'track.csv', 'slip.csv')
SMOOTHED = ('track_smoothed.tum', 'track_smoothed.csv', 'slip_smoothed.csv')
_COVARIANCE = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
_ROWS = 2048
_NUMBERS = 12  # of one track row, between stamp and source


def slip_columns(joints: Sequence[str]) -> tuple[str, ...]:
    """Header of slip.csv."""
    columns = ['stamp']
    for joint in joints:
        columns += [f'{joint}.slip_rate', f'{joint}.probability']
    return (*columns, 'body.probability')


class TrackWriter:
    """Writes the three files into a folder; a context manager. BagError where it cannot write."""

    def __init__(self, folder: str | os.PathLike[str], joints: Sequence[str],
                 names: Sequence[str] = FILES, compiled: bool = False) -> None:
        """Create ``folder`` and the files; ``joints`` name the wheels in wheel order.

        ``names`` of the poses in TUM form, of the track and of the slip; ``compiled``: texts are
        made by a compiled kernel, which takes some seconds once; they are the same.
        """
        place = pathlib.Path(folder)
        self._files: list[BinaryIO] = []
        try:
            place.mkdir(parents=True, exist_ok=True)
            for name in names:
                self._files.append(open(place / name, 'wb'))
        except OSError as error:
            self._shut()
            raise BagError(f'{place}: cannot be written: {error.strerror}') from None
        self._place, self._compiled = place, compiled
        self._wheels = len(joints)
        self._files[1].write((','.join(TRACK_COLUMNS) + '\n').encode())
        self._files[2].write((_csv_row(slip_columns(joints)) + '\n').encode())
        self._stamp = np.zeros(_ROWS, dtype=np.int64)
        self._track = np.zeros((_ROWS, _NUMBERS))
        self._slip = np.zeros((_ROWS, 2 * self._wheels + 1))
        self._predicted = np.zeros(_ROWS, dtype=bool)
        self._count = 0
        self.rows = 0

    def write(self, estimate: Estimate) -> None:
        """Add one estimate."""
        index = self._count
        row, slip, covariance = self._track[index], self._slip[index], estimate.pose_covariance
        self._stamp[index] = estimate.stamp_ns
        row[0:3] = estimate.pose
        row[3:6] = estimate.twist
        for column, (i, j) in enumerate(_COVARIANCE, start=6):
            row[column] = covariance[i, j]
        slip[0:-1:2] = estimate.slip.rate
        slip[1:-1:2] = estimate.slip.probability
        slip[-1] = estimate.slip.body_probability
        self._predicted[index] = estimate.source != SOURCES[0]
        self._count += 1
        if self._count == _ROWS:
            self.flush()

    def write_rows(self, stamp_ns: IntArray, track: FloatArray, slip: FloatArray,
                   predicted: IntArray) -> None:
        """Add many rows at once: stamp (N,) ns, track (N, 12) and slip (N, 2W + 1) in the order
        of the columns, predicted (N,) flag."""
        done = 0
        while done < len(stamp_ns):
            part = slice(done, done + min(_ROWS - self._count, len(stamp_ns) - done))
            into = slice(self._count, self._count + part.stop - part.start)
            self._stamp[into], self._track[into] = stamp_ns[part], track[part]
            self._slip[into], self._predicted[into] = slip[part], predicted[part]
            self._count, done = into.stop, part.stop
            if self._count == _ROWS:
                self.flush()

    def flush(self) -> None:
        """Hand all rows gathered so far to the operating system."""
        count, self._count = self._count, 0
        if count:
            self.rows += count
            half = self._track[:count, 2] / 2.0
            turn = np.column_stack([np.sin(half), np.cos(half)])
            words = np.array(SOURCES, dtype='S')[self._predicted[:count].astype(int)]
            parts = (self._stamp[:count], self._track[:count], turn, self._slip[:count],
                     words.view(np.uint8).reshape(count, -1))
            self._put(*(self._compiled and texts_of(*parts) or texts_by_columns(*parts)))
        else:
            self._put(b'', b'', b'')

    def close(self) -> None:
        """Write what is left and close the files."""
        if self._files:
            try:
                self.flush()
            finally:
                self._shut()

    def __enter__(self) -> TrackWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    def _put(self, *texts: Any) -> None:
        try:
            for file, text in zip(self._files, texts):
                file.write(text)
                file.flush()
        except OSError as error:
            raise BagError(f'{self._place}: cannot be written: {error.strerror}') from None

    def _shut(self) -> None:
        files, self._files = self._files, []
        for file in files:
            with contextlib.suppress(OSError):  # all was flushed; a full disk is told by then
                file.close()


def _csv_row(words: Sequence[str]) -> str:
    """A CSV header; a joint name with a comma or quote is quoted (RFC 4180)."""
    return ','.join('"' + w.replace('"', '""') + '"' if set(w) & set(',"\r\n') else w
                    for w in words)
