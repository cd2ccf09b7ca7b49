"""Ctrl-C: one line, exit code 130, no traceback; what is left behind is named."""

import ctypes
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import threading
import time

import pytest

from mecanum_base.bag.analysis.fleet import _interrupts_held
from mecanum_base.cli import doctor
from mecanum_base.cli.interrupts import kept
from mecanum_base.cli.leftover import Leftover
from mecanum_base.cli.main import main


def usual_interrupt():
    """As in a foreground shell: what runs in the background of a script ignores SIGINT."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def interrupted(words, ready, seconds=30.0):
    """(exit code, stdout, stderr) of a verb that gets SIGINT, as a terminal sends it to all its
    processes, as soon as the path ``ready`` exists."""
    process = subprocess.Popen([sys.executable, '-m', 'mecanum_base', *map(str, words)],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               start_new_session=True, preexec_fn=usual_interrupt)
    try:
        until = time.monotonic() + seconds
        while not ready.exists() and process.poll() is None and time.monotonic() < until:
            time.sleep(0.02)
        assert process.poll() is None, process.communicate()
        os.killpg(process.pid, signal.SIGINT)
        out, error = process.communicate(timeout=seconds)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
    return process.returncode, out, error


@pytest.fixture(scope='module')
def broken_off(tmp_path_factory):
    """(folder, what :func:`interrupted` gives) of a simulation."""
    run = tmp_path_factory.mktemp('sim') / 'run'
    return run, interrupted(['sim', '--scenario', 'oil', '--out', run, '--duration', '9999'],
                            run / 'truth.csv')


def test_a_simulation_that_is_interrupted_names_its_files_and_they_are_complete(broken_off):
    run, (code, out, error) = broken_off
    assert (code, out) == (130, '')
    assert re.fullmatch(r'mecanum sim: interrupted; incomplete: [^\n]*bag_0\.mcap[^\n]*\n', error)
    assert (run / 'bag' / 'bag_0.mcap').read_bytes().endswith(b'\x89MCAP0\r\n')


def test_a_pool_of_processes_ends_without_a_word_of_its_own(tmp_path, broken_off):
    bags = [shutil.copy(broken_off[0] / 'bag' / 'bag_0.mcap', tmp_path / f'{i}.mcap')
            for i in range(3)]
    report = tmp_path / 'report'
    code, out, error = interrupted(['analyze', *bags, '--workers', '2', '--out', report], report)
    assert (code, out, error) == (130, '', 'mecanum analyze: interrupted\n')
    assert list(report.iterdir()) == []


@pytest.mark.parametrize('words', [['doctor', 'x', '--robot', 'y']])
def test_a_verb_that_writes_nothing_just_says_so(words, monkeypatch, capsys):
    def stop(_options):
        raise KeyboardInterrupt

    monkeypatch.setattr(doctor, 'run', stop)
    assert main(words) == 130
    assert capsys.readouterr() == ('', f'mecanum {words[0]}: interrupted\n')


IN_EXEC = """
import sys
from mecanum_base.cli import doctor
from mecanum_base.cli.main import main
doctor.run = lambda options: exec('raise KeyboardInterrupt')
sys.exit(main(['doctor', 'x', '--robot', 'y']))
"""


def test_an_interrupt_inside_an_exec_ends_with_130_too(tmp_path):
    (tmp_path / 'interrupted_in_exec.py').write_text(IN_EXEC)
    done = subprocess.run([sys.executable, '-m', 'interrupted_in_exec'], cwd=tmp_path,
                          capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (130, 'mecanum doctor: interrupted\n')


def test_only_new_and_changed_files_are_called_incomplete(tmp_path):
    for name in ('old', 'changed'):
        (tmp_path / name).write_text('before')
    leftover = Leftover(str(tmp_path))
    assert leftover.text() == ''
    (tmp_path / 'changed').write_text('longer than before')
    (tmp_path / 'deep').mkdir()
    for index in range(6):
        (tmp_path / 'deep' / f'{index}').write_text('')
    text = leftover.text()
    assert text.startswith(f'; incomplete: {tmp_path / "changed"}, {tmp_path / "deep" / "0"}, ')
    assert text.endswith(' and 2 more') and 'old' not in text
    assert Leftover(None).text() == Leftover(str(pathlib.Path('no', 'such'))).text() == ''


LOADING = """
import os, signal, sys
name = sys.argv.pop(1)

class Interrupting:
    def find_spec(self, wanted, path=None, target=None):
        if wanted == name:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupting())
from mecanum_base.cli.main import main
sys.exit(main())
"""


@pytest.mark.parametrize('loaded', ['mecanum_base.cli.beginning', 'mecanum_base.cli.verbs',
                                    'argparse', 'mecanum_base.cli.check', 'numpy', 'yaml'])
def test_an_interrupt_while_modules_are_loaded_ends_it_without_a_word(loaded):
    done = subprocess.run([sys.executable, '-c', LOADING, loaded, 'check', 'x'],
                          capture_output=True, text=True, preexec_fn=usual_interrupt)
    assert (done.returncode, done.stdout, done.stderr) == (130, '', '')


def test_an_interrupt_that_is_ignored_stays_ignored():
    """As of a process in the background of a script."""
    done = subprocess.run(
        [sys.executable, '-c', LOADING, 'numpy', 'check', 'no such file'], capture_output=True,
        text=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    assert done.returncode == 2 and 'no such file' in done.stderr


def test_processes_are_started_undisturbed_by_an_interrupt_that_another_thread_takes():
    """A thread of BLAS may take the signal: the mask of the main thread does not hold it."""
    begun, done = threading.Event(), threading.Event()

    def take():
        begun.wait(20.0)
        signal.pthread_kill(threading.get_ident(), signal.SIGINT)
        done.set()

    other = threading.Thread(target=take)
    other.start()
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    started = False
    try:
        with pytest.raises(KeyboardInterrupt), _interrupts_held():
            begun.set()
            assert done.wait(20.0)
            time.sleep(0.05)  # time for Python to run the handler
            started = True
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
        other.join()
    assert started


def test_an_interrupt_that_a_callback_of_c_swallows_comes_again(monkeypatch):
    kind = ctypes.CFUNCTYPE(ctypes.c_int)

    @kind
    def callback():
        raise KeyboardInterrupt

    def unexpected(_unraisable):
        raise AssertionError('told to the user')

    monkeypatch.setattr(sys, 'unraisablehook', unexpected)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), kept():
            callback()
            time.sleep(20.0)
    finally:
        signal.signal(signal.SIGINT, before)
    assert sys.unraisablehook is unexpected
