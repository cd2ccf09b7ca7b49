"""The kernel as plain Python or compiled by numba: the same source, tables of the same content."""

from __future__ import annotations

import importlib.util
import inspect
import types
import zlib
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.sim import ground, kernel, layout, lean

Advance = Callable[..., None]


def numba_installed() -> bool:
    """Whether the extra ``fast`` is installed (found without importing it)."""
    return importlib.util.find_spec('numba') is not None


def choose(engine: str, *, prefer_numba: bool) -> str:
    """'plain' or 'numba' for the configured engine; ConfigError where numba is missing."""
    if engine == 'numba' and not numba_installed():
        raise ConfigError('sim.engine', engine, "needs numba: pip install 'mecanum_base[fast]'")
    if engine == 'auto':
        return 'numba' if prefer_numba and numba_installed() else 'plain'
    return engine


@cache
def _compiled() -> Advance:
    import numba

    digest = _digest()
    jit = numba.njit(cache=digest is not None, error_model='numpy')
    scope = dict(vars(kernel))
    for part in (ground.ground, lean.lean):
        scope[part.__name__] = jit(_named(part, digest, dict(part.__globals__)))
    compiled: Advance = jit(_named(kernel.advance, digest, scope))
    return compiled


def _named(source: Any, digest: str | None, scope: dict[str, Any]) -> Any:
    """A copy of a function that sees ``scope`` and whose name tells the state of the sources."""
    copy = types.FunctionType(source.__code__, scope, source.__name__, source.__defaults__)
    copy.__module__ = source.__module__
    copy.__qualname__ = f'{source.__qualname__}_{digest}'
    return copy


def _digest() -> str | None:
    """Checksum of all sources of the kernel; None where they cannot be read (then no cache).

    numba's own cache looks at the file of a function only, not at those of what it calls.
    """
    try:
        text = ''.join(inspect.getsource(part) for part in (kernel, ground, lean, layout))
    except OSError:
        return None
    return f'{zlib.crc32(text.encode()):08x}'


def advance_function(engine: str) -> Advance:
    """``kernel.advance`` for the chosen engine."""
    return _compiled() if engine == 'numba' else kernel.advance


def table(values: Sequence[float], engine: str) -> Any:
    """A table of numbers as the engine wants it: a list, or a float64 array."""
    floats = [float(v) for v in values]
    return np.array(floats, dtype=np.float64) if engine == 'numba' else floats
