"""The compiled way to the text of rows, run as plain Python, against the one by columns."""

import numpy as np
import pytest

from mecanum_base.bag.row_text import texts_by_columns, texts_of


def rows(values, wheels=2):
    """Rows that hold these numbers and their neighbours, in every column some."""
    values = np.asarray(values, dtype=float)
    near = np.concatenate([values, np.nextafter(values, np.inf), -np.nextafter(values, -np.inf)])
    near = near[(near == 0.0) | (np.abs(near) > 1e-200)]
    width = 12 + 2 + 2 * wheels + 1
    count = max(-(-len(near) // width), 4)
    grid = np.resize(near, (count, width))
    stamp = np.arange(count) * 10**10 + 1_700_000_000_000_000_001
    stamp[:4] = [0, -5, 999_999_999, 10**9]
    word = np.array([b'encoder', b'predicted'])[np.arange(count) % 2]
    return (stamp, grid[:, :12].copy(), grid[:, 12:14].copy(), grid[:, 14:].copy(),
            word.view(np.uint8).reshape(count, -1))


@pytest.mark.parametrize('values', [
    [0.0, 1.0, -2.0, 0.5, 100.0, 0.1, 1 / 3, 2 / 3, 123456.789, 9.5, 1e15, 1e16, 1e-6,
     9.9e-7],
    [10.0**k for k in range(-30, 31)], [10.0**k for k in (-199, -150, -100, -99, 99, 100, 199)],
    np.random.default_rng(3).normal(size=150)
    * 10.0 ** np.random.default_rng(4).integers(-40, 40, 150)])
def test_both_ways_give_the_same_bytes(values):
    parts = rows(values)
    for text, wanted in zip(texts_of(*parts), texts_by_columns(*parts)):
        assert text.tobytes() == wanted


@pytest.mark.parametrize('value', [np.nan, np.inf, -np.inf, 1e-310, 1e300])
@pytest.mark.parametrize('part', [1, 2, 3])
def test_what_is_no_usual_number_is_left_to_the_other_way(value, part):
    parts = rows(np.arange(1.0, 20.0))
    parts[part][1, -1] = value
    assert texts_of(*parts) is None
    assert repr(value).encode() in b''.join(texts_by_columns(*parts))
