"""The kernel as plain Python or compiled by numba: the same source, tables of the same content."""

from __future__ import annotations

import importlib.util
import types
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.sim import ground, kernel, lean

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

    jit = numba.njit(cache=True, error_model='numpy')
    scope = {**vars(kernel), 'ground': jit(ground.ground), 'lean': jit(lean.lean)}
    source = kernel.advance
    copy = types.FunctionType(source.__code__, scope, source.__name__, source.__defaults__)
    copy.__module__ = source.__module__
    copy.__qualname__ = source.__qualname__
    compiled: Advance = jit(copy)
    return compiled


def advance_function(engine: str) -> Advance:
    """``kernel.advance`` for the chosen engine."""
    return _compiled() if engine == 'numba' else kernel.advance


def table(values: Sequence[float], engine: str) -> Any:
    """A table of numbers as the engine wants it: a list, or a float64 array."""
    floats = [float(v) for v in values]
    return np.array(floats, dtype=np.float64) if engine == 'numba' else floats
