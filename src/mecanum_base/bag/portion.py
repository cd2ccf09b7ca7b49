"""A recording in portions for the estimator, and each portion handed to it in as few calls as can.

What is plain goes in by columns, one call for thousands of samples; what may need care (doubtful
stamps, missing wheels, poses given from outside) goes in one by one, and so does what
the estimator does not take by columns. The estimates are the same either way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mecanum_base.bag.reader import Bag
from mecanum_base.bag.stream import Batch, SampleReader, joined_batches
from mecanum_base.bag.topics import Topics
from mecanum_base.core.estimation.acceleration import COMPILED
from mecanum_base.core.estimation.ordering import BACK_NS, FAR_NS
from mecanum_base.core.estimation.stretch import Rows, take
from mecanum_base.core.parameter import IntArray
from mecanum_base.core.records import Estimate
from mecanum_base.intake import Intake

# Inputs at least in a portion. Compiled, a call is short, and a longer one costs fewer waits for
# the other threads; plain, a short portion keeps the progress line alive. The first portions are
# shorter, so that the threads begin soon, each is twice the one before.
SIZE = 12288 if COMPILED else 1
FIRST = 1024
_FEW = 64  # inputs that are not worth a second try by columns


@dataclass(frozen=True, slots=True, eq=False)
class Portion:
    """Consecutive inputs, malformed messages, and the share (0..1) of the bytes read with them."""

    batch: Batch
    rejected: tuple[tuple[str, str], ...]
    share: float
    last: bool


def portions(bag: Bag, reader: SampleReader, topics: Topics,
             rejected: list[tuple[str, str]]) -> Iterator[Portion]:
    """The recording in portions of at least SIZE inputs; the last one is marked.

    ``rejected`` is what ``reader`` fills with malformed messages.
    """

    def portion(last: bool) -> Portion:
        whole = Portion(joined_batches(held), tuple(rejected),
                        bag.read_bytes / max(bag.piece_bytes, 1), last)
        held.clear()
        rejected.clear()
        return whole

    held: list[Batch] = []
    size = min(FIRST, SIZE)
    for block in bag.blocks(lambda channel: topics.stream(channel) is not None):
        if sum(map(len, held)) >= size:
            yield portion(False)
            size = min(2 * size, SIZE)
        held.append(reader.batch(block))
    if held:
        yield portion(True)


def feed(portion: Portion, intake: Intake) -> Iterator[Rows | tuple[Estimate, ...]]:
    """Hand a portion to the intake; yields what becomes due, in order."""
    for stream, reason in portion.rejected:
        intake.estimator.reject(stream, reason)
    portion.batch.tell_commands(intake)
    batch, at = portion.batch, 0
    while at < len(batch):
        odd, stop = _odd(batch, at, intake.estimator.newest_ns)
        for index in odd.tolist():
            yield from _by_columns(batch.part(at, index), intake, False)
            yield from batch.part(index, index + 1).feed(intake)
            at = index + 1
        yield from _by_columns(batch.part(at, stop), intake,
                               portion.last and stop == len(batch))
        at = stop


def _by_columns(part: Batch, intake: Intake, last: bool) -> Iterator[Rows | tuple[Estimate, ...]]:
    """By columns where the estimator takes them, else in halves, in the end one by one."""
    if not len(part):
        return
    columns = part.stretch() if intake.direct else None
    rows = None if columns is None else take(intake.estimator, columns, last)
    if rows is not None:
        yield rows
    elif len(part) <= _FEW:
        yield from part.feed(intake)
    else:
        half = len(part) // 2
        yield from _by_columns(part.part(0, half), intake, False)
        yield from _by_columns(part.part(half, len(part)), intake, last)


def _odd(batch: Batch, at: int, newest: int | None) -> tuple[IntArray, int]:
    """Inputs from ``at`` on that need care, and how far that can be said: to the first stamp far
    ahead, which may be wrong, else to the end."""
    stamp, care = batch.stamp_ns[at:], batch.care[at:]
    first = int(stamp[0]) if newest is None else newest
    newest_before = np.maximum.accumulate(np.concatenate(([first], stamp)))[:-1]
    far = np.flatnonzero(stamp > newest_before + FAR_NS)
    stop = int(far[0]) + 1 if len(far) else len(stamp)
    odd = care[:stop] | (stamp[:stop] < newest_before[:stop] - BACK_NS)
    if len(far):
        odd[-1] = True
    found: IntArray = at + np.flatnonzero(odd)
    return found, at + stop
