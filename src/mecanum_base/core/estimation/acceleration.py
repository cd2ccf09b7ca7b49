"""One switch between plain numpy and compiled kernels (optional extra ``fast``).

Every kernel of the filter is written in the part of numpy that numba compiles unchanged. Where
numba is importable, live node and replay both run the compiled kernels; elsewhere both run the
same source through numpy. The two agree to rounding (1e-9 m and rad over a run, tested).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, TypeVar, cast

Kernel = TypeVar('Kernel', bound=Callable[..., Any])

try:
    if os.environ.get('MECANUM_BASE_FAST') != '1':
        raise ImportError('not asked for')
    from numba import config, njit
except ImportError:
    COMPILED = False
else:
    COMPILED = not getattr(config, 'DISABLE_JIT', False)  # numba's switch: NUMBA_DISABLE_JIT=1


def kernel(function: Kernel) -> Kernel:
    """``function`` compiled where possible; the compiled code is cached between processes."""
    if not COMPILED:
        return function
    return cast(Kernel, njit(cache=True, nogil=True, error_model='numpy')(function))
