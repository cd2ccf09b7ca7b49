"""Machine code of kernels that an earlier process has left, for those who need no compiler.

Loading numba and what it has cached takes longer than replaying a recording of minutes. Whoever
keeps the machine code itself puts it here, by kernel, before the kernels are imported; then
numba is only loaded when a kernel is called that is not here, or with other kinds of arguments.
"""

from __future__ import annotations

import pathlib
import zlib
from collections.abc import Callable
from typing import Any

# 'module.kernel' -> the same call; NotImplemented where the code is for other kinds of arguments
CODE: dict[str, Callable[..., Any]] = {}
BEFORE: list[Callable[[], None]] = []  # to be called before numba is loaded


def sources() -> str:
    """Checksum of all sources of this package: kernels call each other across its files.

    numba's own cache looks at the file of a function only, not at those of what it calls.
    """
    parts = sorted(pathlib.Path(__file__).parent.glob('*.py'))
    return f'{zlib.crc32(b"".join(p.read_bytes() for p in parts)):08x}'
