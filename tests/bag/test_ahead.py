import threading
import time

import pytest

from mecanum_base.bag.ahead import Ahead, Behind


def threads():
    return {t.name for t in threading.enumerate()} & {'ahead', 'behind'}


def test_items_come_in_order_and_the_thread_ends():
    with Ahead(iter(range(100))) as items:
        assert list(items) == list(range(100))
    assert not threads()


def test_only_a_few_items_are_made_ahead():
    made = []

    def items():
        for index in range(1000):
            made.append(index)
            yield index

    with Ahead(items()) as found:
        assert next(iter(found)) == 0
        for _ in range(100):  # long enough for a thread that did not stop by itself
            time.sleep(0.001)
        assert len(made) <= 6
    assert not threads()


def test_an_error_comes_after_the_items_before_it():
    def items():
        yield 1
        yield 2
        raise ValueError('broken')

    seen = []
    with pytest.raises(ValueError, match='broken'), Ahead(items()) as found:
        for item in found:
            seen.append(item)
    assert seen == [1, 2] and not threads()


def test_leaving_early_ends_the_thread():
    def endless():
        while True:
            yield 0

    with pytest.raises(KeyError), Ahead(endless()) as found:
        for _ in found:
            raise KeyError('enough')
    assert not threads()


def test_jobs_are_done_in_order_before_close_returns():
    done = []
    behind = Behind()
    for index in range(50):
        behind.do(lambda index=index: done.append(index))
    behind.close()
    assert done == list(range(50)) and not threads()


def test_the_first_error_is_raised_later_jobs_are_left_out_and_nothing_hangs():
    done = []

    def broken():
        raise OSError('disk is full')

    behind = Behind()
    behind.do(broken)
    with pytest.raises(OSError, match='disk is full'):
        for index in range(50):  # the queue holds three; so many would block for ever
            behind.do(lambda index=index: done.append(index))
            time.sleep(0.001)
    assert not done
    with pytest.raises(OSError, match='disk is full'):
        behind.close()
    assert not threads()
