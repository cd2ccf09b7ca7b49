"""Named streams of random numbers: one seed, and a stream of its own for every purpose.

A stream depends on the seed and its name only, so that one more noise source or one more wheel
does not change the numbers of all others.
"""

from __future__ import annotations

import zlib

import numpy as np

_BLOCK = 512


def stream(seed: int, name: str) -> np.random.Generator:
    """The generator of one purpose, for instance ``stream(7, 'imu noise')``."""
    return np.random.Generator(np.random.PCG64([seed, zlib.crc32(name.encode())]))


class Normals:
    """Standard normal numbers one by one, drawn in blocks because single draws are slow."""

    def __init__(self, seed: int, name: str) -> None:
        self._generator = stream(seed, name)
        self._block: list[float] = []

    def __call__(self) -> float:
        """The next number."""
        if not self._block:
            self._block = self._generator.standard_normal(_BLOCK).tolist()
            self._block.reverse()
        return self._block.pop()


class Uniforms(Normals):
    """Numbers between 0 and 1, in the same manner."""

    def __call__(self) -> float:
        """The next number."""
        if not self._block:
            self._block = self._generator.random(_BLOCK).tolist()
            self._block.reverse()
        return self._block.pop()
