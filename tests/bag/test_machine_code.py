"""Kept machine code: what is in the file, and that calls from it are those numba would make."""

import os
import subprocess
import sys

import numpy as np
import pytest

from mecanum_base.bag import machine_code
from mecanum_base.bag.machine_code import Entry, file_name, read, remove_stale, words_of, write

KERNEL = '''
"""A kernel as those of the filter: a named tuple, arrays of all kinds, numbers, two results."""
from typing import NamedTuple
import numpy as np
from mecanum_base.core.estimation.acceleration import kernel

class Parts(NamedTuple):
    grid: np.ndarray
    gain: float
    count: int

@kernel
def summed(grid):
    own = np.empty(len(grid))  # memory of its own, which it must give back
    total = 0.0
    for i in range(len(grid)):
        own[i] = grid[i, 1] + 0.5
        total += own[i]
    return total

@kernel
def weigh(parts, column, stamp, out):
    for i in range(len(column)):
        out[i] = parts.gain * column[i] + summed(parts.grid)
    return int(stamp[0] + parts.count), len(column)
'''
CASE = '''
import importlib.util, os, pathlib, sys
os.environ['MECANUM_BASE_FAST'] = '1'
import numpy as np

def made_up():
    spec = importlib.util.spec_from_file_location('mecanum_base.made_up', sys.argv[1])
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module

def called(module):
    grid = np.arange(16.0).reshape(4, 4)
    column = np.arange(8.0)[::2]
    out = np.zeros(4)
    done = module.weigh(module.Parts(grid, 0.25, 7), column, np.array([10**18]), out)
    return [*done, *out.tolist()]

file = pathlib.Path(sys.argv[2])
'''
MAKE = CASE + '''
from mecanum_base.bag.machine_code import write
from mecanum_base.bag.machine_entry import entries_of
module = made_up()
print(called(module))
entries = entries_of(module.weigh, 'mecanum_base.made_up.weigh')
write(file, entries)
assert len(entries) == 1 and not entries_of(module.weigh, 'mecanum_base.made_up.weigh', entries)
'''
USE = CASE + '''
from mecanum_base.bag.machine_code import load
from mecanum_base.core.estimation.prepared import BEFORE, CODE
told = []
BEFORE.append(lambda: told.append('numba' in sys.modules))
assert load(file)
module = made_up()
print(called(module))
assert 'numba' not in sys.modules and not told
print(module.summed(np.ones((2, 2))))  # of this one there is no machine code
assert told == [False] and not CODE
assert type(module.weigh).__module__ == type(module.summed).__module__ == 'numba.core.registry'
'''


def process(code, *words, **environment):
    clean = {k: v for k, v in os.environ.items() if not k.startswith(('NUMBA_', 'MECANUM_BASE'))}
    done = subprocess.run([sys.executable, '-c', code, *map(str, words)], capture_output=True,
                          text=True, timeout=900, env={**clean, **environment})
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.skipif(sys.platform != 'linux', reason='machine code is kept on Linux')
def test_calls_of_kept_code_need_no_numba_until_another_kernel_is_called(tmp_path):
    pytest.importorskip('numba')
    source, file = tmp_path / 'made_up.py', tmp_path / 'kept'
    source.write_text(KERNEL)
    cache = {'NUMBA_CACHE_DIR': str(tmp_path / 'cache')}
    compiled, = process(MAKE, source, file, **cache)
    assert compiled == str([10**18 + 7, 4, *(0.25 * i + 30.0 for i in (0, 2, 4, 6))])
    assert process(USE, source, file, **cache) == [compiled, '3.0']


def test_words_tell_kinds_that_numba_tells_apart():
    grid = np.arange(6.0).reshape(2, 3)
    kinds, words = words_of((grid, (3, -0.0), grid[:, 1]))
    assert kinds == '<f82C tuple( i f ) <f81A'
    assert words[1:7] == [2, 3, 24, 8, 3, -2**63] and words[8:] == [2, 24]
    assert words[7] == words[0] + 8
    frozen = grid.copy()
    frozen.setflags(write=False)
    assert words_of((frozen,))[0] == '<f82Cr'
    assert words_of((grid.astype(np.float32),))[0] == '<f42C'
    assert words_of((True,)) is None and words_of(('text',)) is None


def test_arguments_of_other_kinds_are_not_taken():
    call = machine_code._choice({'i f': lambda words: words})
    assert call(1, 2.0) == [1, 2**62]
    assert call(1, 2) is call(1) is call('1', 2.0) is NotImplemented


def test_a_file_gives_back_its_entries_and_keeps_shared_code_once(tmp_path):
    shared = os.urandom(5000)
    entries = [Entry('a.b', 'i f', 2, 'entry_a', (shared, b'own')),
               Entry('a.c', '', 0, 'entry_c', (shared, b''))]
    file = tmp_path / 'new' / 'kept'
    write(file, entries)
    assert read(file) == entries
    assert len(list(file.parent.iterdir())) == 1 and file.stat().st_size < 6000


def test_a_damaged_file_is_as_good_as_none(tmp_path):
    file = tmp_path / 'kept'
    assert read(file) == []
    write(file, [Entry('a.b', 'i', 1, 'entry', (os.urandom(300),))])
    whole = file.read_bytes()
    for cut in range(0, len(whole), 7):
        file.write_bytes(whole[:cut])
        assert read(file) == []
    for place in range(0, len(whole), 3):
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1:])
        assert read(file) == []
    assert not machine_code.load(file)


def test_a_new_file_replaces_those_of_older_kernels_and_no_others(tmp_path, monkeypatch):
    pytest.importorskip('llvmlite')
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path))

    def named():
        path = file_name()
        write(path, [Entry('a.b', 'i', 1, 'entry', (b'code',))])
        return path

    old = named()
    monkeypatch.setattr(machine_code.prepared, 'sources', lambda: 'other kernels')
    new = named()
    monkeypatch.setattr(sys, 'prefix', 'another environment')
    foreign = named()
    assert len({old, new, foreign}) == 3 and old.name.split('.')[:2] == new.name.split('.')[:2]
    begun = [tmp_path / f'{old.name}.{ending}' for ending in ('4711', 'trial')]
    left = [tmp_path / f'{new.name}.{ending}' for ending in ('4712', 'trial')]
    others = [tmp_path / name for name in ('kernels.nbi', 'kernels.12345678.machine_code',
                                           f'my_{old.name}')]
    folder = tmp_path / f'{new.name}.folder'
    for path in (*begun, *left, *others):
        path.write_bytes(b'')
    folder.mkdir()
    for path in (*left, folder):
        os.utime(path, (1e9, 1e9))
    remove_stale(new)
    assert set(tmp_path.iterdir()) == {new, foreign, *begun, *others, folder}
    remove_stale(new)  # another process has been here
    assert set(tmp_path.iterdir()) == {new, foreign, *begun, *others, folder}


@pytest.mark.slow
@pytest.mark.skipif(os.environ.get('COMPILED_TESTS') != '1',
                    reason='compiling takes minutes: make compiled')
def test_a_replay_from_kept_code_writes_the_bytes_of_the_one_that_compiled(tmp_path, make):
    from driving import YAML
    path = make.write_mcap(tmp_path / 'a.mcap', make.drive(30.0))
    (tmp_path / 'robot.yaml').write_text(YAML)
    code = '''
import pathlib, sys
from mecanum_base.cli.main import main
out = pathlib.Path(sys.argv[3])
assert main(['replay', sys.argv[1], '--robot', sys.argv[2], '--out', str(out)]) == 0
print('numba' in sys.modules)
'''
    words = [path, tmp_path / 'robot.yaml']
    environment = {'MECANUM_BASE_FAST': '1', 'NUMBA_CACHE_DIR': str(tmp_path / 'cache')}
    first = process(code, *words, tmp_path / 'first', **environment)
    second = process(code, *words, tmp_path / 'second', **environment)
    assert first[-1] == 'True' and second[-1] == 'False'
    for file in sorted((tmp_path / 'first').iterdir()):
        if file.suffix != '.json':
            assert (tmp_path / 'second' / file.name).read_bytes() == file.read_bytes()
