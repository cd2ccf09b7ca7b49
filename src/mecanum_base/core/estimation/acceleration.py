"""One switch between plain numpy and compiled kernels (optional extra ``fast``).

Every kernel of the filter is written in the part of numpy that numba compiles unchanged. Where
numba is importable, live node and replay both run the compiled kernels; elsewhere both run the
same source through numpy. The two agree to rounding (1e-9 m and rad over a run, tested).
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable
from importlib import resources
from typing import Any, Literal, TypeVar, cast

from mecanum_base.core.parameter import FloatArray, IntArray

Kernel = TypeVar('Kernel', bound=Callable[..., Any])
Cells = TypeVar('Cells', FloatArray, IntArray)
Whole = TypeVar('Whole')

try:
    if os.environ.get('MECANUM_BASE_FAST') != '1':
        raise ImportError('not asked for')
    from numba import config, njit
    from numba.core import types
    from numba.extending import intrinsic
except ImportError:
    COMPILED = False
else:
    COMPILED = not getattr(config, 'DISABLE_JIT', False)  # numba's switch: NUMBA_DISABLE_JIT=1


def _sources() -> str:
    """Checksum of all sources of this package: kernels call each other across its files.

    numba's own cache looks at the file of a function only, not at those of what it calls.
    """
    folder = resources.files(__package__)
    parts = sorted((p for p in folder.iterdir() if p.name.endswith('.py')), key=lambda p: p.name)
    return f'{zlib.crc32(b"".join(p.read_bytes() for p in parts)):08x}'


_STATE = _sources() if COMPILED else ''


def cells(array: Cells) -> Cells:
    """``array`` for kernels that take it number by number, sharing its memory.

    Plain Python reads and writes a memoryview in half the time that an array takes.
    """
    return array if COMPILED else cast(Cells, memoryview(array))  # type: ignore[arg-type]


def kernel(function: Kernel) -> Kernel:
    """``function`` compiled where possible; the compiled code is cached between processes.

    What is cached carries the state of the sources in its name: changed sources compile anew.
    """
    return _compiled(function, 'never')


def part(function: Kernel) -> Kernel:
    """A kernel that is taken whole into those that call it.

    For what every reading passes through: handing over the tuples costs more than it does.
    """
    return _compiled(function, 'always')


def _compiled(function: Kernel, inline: Literal['never', 'always']) -> Kernel:
    if not COMPILED:
        return function
    function.__qualname__ = f'{function.__qualname__}_{_STATE}'
    return cast(Kernel, njit(cache=True, nogil=True, error_model='numpy',
                             inline=inline)(function))


def _unowned(context: Any, whole: Any) -> Any:
    """Typing and code of :func:`unowned`: the tuple as it is, its arrays without their owners."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value = arguments[0]
        for place, kind in enumerate(whole.types):
            if isinstance(kind, types.Array):
                part = builder.extract_value(value, place)
                array = context.make_array(kind)(context, builder, part)
                array.meminfo = array.meminfo.type(None)
                value = builder.insert_value(value, array._getvalue(), place)
        return value

    return whole(whole), code


def unowned(whole: Whole) -> Whole:
    """The same named tuple, to whose arrays compiled code counts no references.

    It counts one to each array wherever a tuple is passed on, and that took more time than all
    the arithmetic. The arrays must live as long as the call, as those of a caller do.
    """
    return whole


if COMPILED:
    unowned = intrinsic(_unowned)  # type: ignore[assignment]
