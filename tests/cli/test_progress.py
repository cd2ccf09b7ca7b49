import io
import re

from mecanum_base.cli import progress
from mecanum_base.cli.progress import Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_terminal_sees_share_rate_and_remaining_time_and_a_clean_line_at_the_end(monkeypatch):
    clock = iter([0.0, 1.0, 2.0, 2.01, 10.0])
    monkeypatch.setattr(progress.time, 'monotonic', lambda: next(clock))
    stream = Terminal()
    with Progress('replay', stream) as bar:
        bar.update(0.25, '300 x real time')  # at 1 s: three more seconds
        bar.update(0.5, '310 x real time')
        bar.update(0.51, 'too soon after the last')
        bar.update(1.0)
    text = stream.getvalue()
    assert re.search(r'25%  300 x real time +3 s left', text)
    assert re.search(r'50%  310 x real time +2 s left', text)
    assert 'too soon' not in text
    assert text.endswith('\r\x1b[K')


def test_a_pipe_sees_nothing():
    stream = io.StringIO()
    with Progress('replay', stream) as bar:
        bar.update(0.5, '300 x')
    assert stream.getvalue() == ''
