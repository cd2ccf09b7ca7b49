"""One switch between plain numpy and compiled kernels (optional extra ``fast``).

Every kernel of the filter is written in the part of numpy that numba compiles unchanged. Where
numba is importable, live node and replay both run the compiled kernels; elsewhere both run the
same source through numpy. The two agree to rounding (1e-9 m and rad over a run, tested).
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any, Literal, TypeVar, cast

from mecanum_base.core.estimation.prepared import BEFORE, CODE, sources
from mecanum_base.core.parameter import FloatArray, IntArray

Kernel = TypeVar('Kernel', bound=Callable[..., Any])
Cells = TypeVar('Cells', FloatArray, IntArray)
Whole = TypeVar('Whole')
Inline = Literal['never', 'always']

_ROOT = __name__.partition('.')[0]

try:
    if os.environ.get('MECANUM_BASE_FAST') != '1':
        raise ImportError('not asked for')
    if not CODE:
        import numba
except ImportError:
    COMPILED = False
else:  # numba's switch: NUMBA_DISABLE_JIT=1
    COMPILED = bool(CODE) or not getattr(numba.config, 'DISABLE_JIT', False)

_STATE = sources() if COMPILED else ''
_waiting: list[Later] = []


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


class Later:
    """Stands for a kernel: calls the machine code that was left of it, else compiles them all."""

    def __init__(self, function: Callable[..., Any], inline: Inline) -> None:
        self.function, self.inline = function, inline
        self.name = f'{function.__module__}.{function.__name__}'
        self.compiled: Callable[..., Any] | None = None
        _waiting.append(self)

    def __call__(self, *arguments: Any) -> Any:
        """What the kernel returns."""
        code = CODE.get(self.name)
        found = NotImplemented if code is None else code(*arguments)
        if found is not NotImplemented:
            return found
        if self.compiled is None:
            compile_all()
        assert self.compiled is not None
        return self.compiled(*arguments)


def compile_all() -> None:
    """Load numba; everywhere compiled kernels take the place of what stood for them."""
    for call in BEFORE:
        call()
    from numba.extending import intrinsic
    new: dict[int, Any] = {id(unowned): intrinsic(_unowned)}
    for item in _waiting:
        item.compiled = new[id(item)] = _dispatcher(item.function, item.inline)
    for module in [m for name, m in sys.modules.items() if name.partition('.')[0] == _ROOT]:
        for name, value in list(vars(module).items()):
            if id(value) in new:
                setattr(module, name, new[id(value)])
    CODE.clear()  # kernels of modules that are imported from here on are compiled at once


def _compiled(function: Kernel, inline: Inline) -> Kernel:
    if not COMPILED:
        return function
    return cast(Kernel, (Later if CODE else _dispatcher)(function, inline))


def _dispatcher(function: Callable[..., Any], inline: Inline) -> Callable[..., Any]:
    from numba import njit
    function.__qualname__ = f'{function.__qualname__}_{_STATE}'
    found: Callable[..., Any] = njit(cache=True, nogil=True, error_model='numpy',
                                     inline=inline)(function)
    return found


def _unowned(context: Any, whole: Any) -> Any:
    """Typing and code of :func:`unowned`: the tuple as it is, its arrays without their owners."""
    from numba.core import types

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


if COMPILED and not CODE:
    unowned = numba.extending.intrinsic(_unowned)  # type: ignore[assignment]
