"""What lets a process that uses compiled kernels begin sooner."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import types

_PACKAGE = 'scipy.linalg'
_TABLES = ('scipy.linalg.cython_blas', 'scipy.linalg.cython_lapack')


def load_numba() -> None:
    """Load numba as quickly as it can be, if it is there.

    Two things it loads take long and are not used here: the package around the modules of
    :func:`load_blas`, and coverage, through which it tells a measurement that it has compiled.
    """
    if 'numba' in sys.modules or importlib.util.find_spec('numba') is None:
        return
    load_blas()
    without = 'coverage' not in sys.modules
    if without:
        sys.modules['coverage'] = None  # type: ignore[assignment]
    try:
        importlib.import_module('numba')
    except ImportError:
        pass  # said where the kernels are asked for
    finally:
        if without:
            del sys.modules['coverage']


def load_blas() -> None:
    """Load the two modules through which numba calls BLAS and LAPACK, not the package around them.

    The package scipy.linalg takes longer to import than many a recording to replay. It is
    imported as ever when somebody asks for it; so it is where the two do not load alone.
    """
    if _PACKAGE in sys.modules or importlib.util.find_spec('scipy') is None:
        return
    spec = importlib.util.find_spec(_PACKAGE)
    if spec is None:
        return
    bare = types.ModuleType(_PACKAGE)
    bare.__path__ = list(spec.submodule_search_locations or ())
    sys.modules[_PACKAGE] = bare
    try:
        for name in _TABLES:
            importlib.import_module(name)
    except ImportError:
        pass
    finally:
        if sys.modules.get(_PACKAGE) is bare:
            del sys.modules[_PACKAGE]
            vars(sys.modules['scipy']).pop('linalg', None)
