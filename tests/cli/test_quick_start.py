import subprocess
import sys

import pytest

pytest.importorskip('scipy')
pytest.importorskip('numba')

CODE = '''
import sys
from mecanum_base.cli.quick_start import load_blas
load_blas()
assert 'scipy.linalg.cython_blas' in sys.modules and 'scipy.linalg' not in sys.modules
from numba.np.linalg import ensure_blas, ensure_lapack
ensure_blas(), ensure_lapack()
assert 'scipy.linalg' not in sys.modules
import numpy, scipy.linalg
from scipy.linalg import cython_blas
assert cython_blas is sys.modules['scipy.linalg.cython_blas']
assert numpy.allclose(scipy.linalg.inv(numpy.eye(3) * 2), numpy.eye(3) / 2)
load_blas()
assert scipy.linalg.inv is sys.modules['scipy.linalg'].inv
'''


def test_numba_finds_blas_and_scipy_is_whole_for_whoever_asks_later():
    done = subprocess.run([sys.executable, '-c', CODE], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


NUMBA = '''
import sys
from mecanum_base.cli.quick_start import load_numba
load_numba()
import numba
assert 'coverage' not in sys.modules and 'scipy.linalg' not in sys.modules
import coverage
load_numba()
assert sys.modules['coverage'] is coverage
'''


def test_numba_loads_without_coverage_and_whoever_measures_still_can():
    pytest.importorskip('coverage')
    done = subprocess.run([sys.executable, '-c', NUMBA], capture_output=True, text=True,
                          timeout=60)
    assert done.returncode == 0, done.stderr
