import io

import pytest

from mecanum_base.cli import replay
from mecanum_base.cli.compiling import CompileNotice
from mecanum_base.cli.progress import Progress

numba = pytest.importorskip('numba')


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_pipe_gets_one_line_when_something_compiles_and_none_otherwise():
    first, second = numba.njit(lambda a: a + 1), numba.njit(lambda a: a + 2)
    stream = io.StringIO()
    with CompileNotice('mecanum replay', stream):
        first(1)
        second(1)
    text = stream.getvalue()
    assert text.startswith('mecanum replay: compiling') and text.count('\n') == 1
    assert text.endswith('\n') and '\r' not in text and '\x1b' not in text
    stream = io.StringIO()
    with CompileNotice('mecanum replay', stream):
        first(1)
    assert stream.getvalue() == ''


def test_a_terminal_sees_seconds_and_a_clean_line_at_the_end():
    stream = Terminal()
    with CompileNotice('mecanum replay', stream) as notice:
        numba.njit(lambda a: a + 3)(1)
        notice.end()
        cleared = stream.getvalue()
        numba.njit(lambda a: a + 4)(1)  # later ones are rare and quick: not told
    assert 'minutes: 0 s' in cleared and cleared.endswith('\r\x1b[K')
    assert stream.getvalue() == cleared
    assert max(map(len, cleared.split('\r'))) < 80  # a longer line could not be drawn over


def test_remaining_time_leaves_out_what_came_before_the_mark(monkeypatch):
    from mecanum_base.cli import progress
    clock = iter([0.0, 100.0, 101.0])
    monkeypatch.setattr(progress.time, 'monotonic', lambda: next(clock))
    stream = Terminal()
    with Progress('replay', stream) as bar:
        bar.mark(0.2)  # 100 s of compiling
        bar.update(0.4)  # a fifth in 1 s: three more
    assert '40%' in stream.getvalue() and '   3 s left' in stream.getvalue()


@pytest.mark.parametrize('asked, there, seconds, expected', [
    (False, True, 60.0, 'hint: MECANUM_BASE_FAST=1'), (False, True, 1.0, ''),
    (False, False, 60.0, "hint: pip install 'mecanum_base[fast]', then MECANUM_BASE_FAST=1"),
    (True, False, 1.0, 'has no effect: numba is not installed'), (True, True, 60.0, '')])
def test_a_long_plain_replay_says_how_to_be_faster(monkeypatch, asked, there, seconds, expected):
    stream = Terminal()
    monkeypatch.setattr(replay.sys, 'stderr', stream)
    monkeypatch.setattr(replay.importlib.util, 'find_spec', lambda name: there or None)
    monkeypatch.setenv('MECANUM_BASE_FAST', '1' if asked else '0')
    replay._advise(seconds)
    assert expected in stream.getvalue() and bool(stream.getvalue()) == bool(expected)


def test_a_pipe_gets_no_hint(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(replay.sys, 'stderr', stream)
    monkeypatch.delenv('MECANUM_BASE_FAST', raising=False)
    replay._advise(1000.0)
    assert stream.getvalue() == ''
