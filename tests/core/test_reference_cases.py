"""Every case of a reference file, by kind, through the public API.

The file is tests/data/reference_cases.json or the one named by REFERENCE_CASES, of the same shape
(meta, cases). An unknown kind fails, and so does an output no adapter gives.
"""

import json
import os
import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import reference_adapters

OWN = pathlib.Path(__file__).parents[1] / 'data' / 'reference_cases.json'
FILE = pathlib.Path(os.environ.get('REFERENCE_CASES') or OWN)
CASES = json.loads(FILE.read_text(encoding='utf-8'))['cases']


def differences(want, got, rtol, atol, path=''):
    """Where ``got`` misses ``want``; empty if it fits: abs(got-want) <= atol + rtol*abs(want)."""
    if isinstance(want, dict):
        if not isinstance(got, dict):
            return [f'{path}: {got!r} is no mapping']
        found = []
        for key, value in want.items():
            where = f'{path}.{key}' if path else key
            if key not in got:
                found.append(f'{where}: the adapter gives no such output')
            elif key == 'direction_up_to_sign':
                found += min((differences(value, sign * np.asarray(got[key]), rtol, atol, where)
                              for sign in (1.0, -1.0)), key=len)
            elif key == 'yaw_lever':  # a lever has a size; its sign depends on the wheel
                found += differences(np.abs(value).tolist(), got[key], rtol, atol, where)
            else:
                found += differences(value, got[key], rtol, atol, where)
        return found
    if isinstance(want, (bool, str)):
        return [] if want == got and type(got) is type(want) else [f'{path}: {got!r} != {want!r}']
    wanted, given = np.asarray(want, dtype=float), np.asarray(got, dtype=float)
    if wanted.shape != given.shape:
        return [f'{path}: shape {given.shape}, not {wanted.shape}']
    close = np.abs(given - wanted) <= atol + rtol * np.abs(wanted)
    return [] if np.all(close) else [f'{path}: {given} != {wanted}']


@pytest.mark.parametrize('case', CASES, ids=[case['id'] for case in CASES])
def test_the_package_gives_the_reference_result(case):
    adapter = reference_adapters.ADAPTERS.get(case['kind'])
    assert adapter is not None, f'no adapter for kind {case["kind"]!r}'
    got = adapter(case['inputs'])
    tol = case['tol']
    assert differences(case['outputs'], got, tol['rtol'], tol['atol']) == []


@pytest.mark.skipif('REFERENCE_CASES' in os.environ, reason='another file was asked for')
def test_the_shipped_file_covers_every_adapter():
    assert {case['kind'] for case in CASES} == set(reference_adapters.ADAPTERS)


def test_a_wrong_number_a_missing_output_and_a_wrong_word_are_noticed():
    assert differences({'a': [1.0, 2.0]}, {'a': [1.0, 2.1]}, 1e-9, 1e-9)
    assert differences({'a': 1.0}, {}, 1e-9, 1e-9)
    assert differences({'a': 'slip'}, {'a': 'unique'}, 1e-9, 1e-9)
    assert differences({'a': True}, {'a': 1}, 1e-9, 1e-9)
    assert differences({'a': 1.0}, {'a': float('nan')}, 1e-9, 1e-9)
    assert not differences({'a': [1.0]}, {'a': np.array([1.0 + 1e-12])}, 1e-9, 1e-9)
