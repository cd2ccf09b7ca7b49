"""One stretch of a recording that is loaded as a whole: an MCAP chunk or a window of a table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mecanum_base.bag.block import Block, Loss
from mecanum_base.core.errors import BagError


class DamagedPiece(BagError):
    """A piece that cannot be used; the text says why, without the file's name."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A stretch of a file: where it lies, the log times it says it spans, and how to load it.

    ``load`` returns the messages in log order or raises :class:`DamagedPiece`.
    """

    start_ns: int
    end_ns: int
    position: int
    size: int
    load: Callable[[], Block]


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """One file of a recording: its pieces in file order and what its index already lost.

    ``stated``: how many messages the file says it holds; None where it does not say.
    """

    name: str
    size: int
    pieces: tuple[Piece, ...]
    loss: Loss
    close: Callable[[], None]
    stated: int | None = None
