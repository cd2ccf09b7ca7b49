import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanum_base.bag.number_text import float_text, squeezed, stamp_text


def texts(rows):
    return [squeezed(row[None]).decode() for row in rows]


def same(values):
    back = np.array([float(text) for text in texts(float_text(values))])
    np.testing.assert_array_equal(back.view(np.int64)[values != 0], values.view(np.int64)[
        values != 0])


@settings(max_examples=200, deadline=None)
@given(st.lists(st.floats(allow_nan=False), min_size=1, max_size=20))
def test_reading_the_text_back_gives_the_same_number(values):
    same(np.array(values))


def test_numbers_of_every_size_survive_the_text():
    generator = np.random.default_rng(1)
    values = generator.normal(size=100_000) * 10.0 ** generator.integers(-250, 250, 100_000)
    same(values)
    near = np.array([10.0**k for k in range(-30, 30)])
    for step in range(3):  # neighbours of the powers of ten, where the digit count changes
        same(near)
        same(-near)
        near = np.nextafter(near, np.inf if step else 0.0)


def test_digits_are_those_of_a_correctly_rounded_conversion():
    """Against Python's own 17 digits; ties aside they are the same."""
    values = np.random.default_rng(2).normal(size=20_000) * 1e-3
    for text, value in zip(texts(float_text(values)), values):
        assert float(text) == value
        wanted = f'{abs(value):.16e}'.split('e')[0].replace('.', '')[:16]
        digits = text.split('e')[0].lstrip('-').replace('.', '').lstrip('0')
        assert digits.ljust(16, '0')[:16] == wanted


def test_whole_and_special_numbers_read_well():
    values = np.array([0.0, -0.0, 1.0, -2.0, 0.5, 100.0, 1e15, 1e22, 1.5e-9, np.nan, np.inf])
    assert texts(float_text(values)) == ['0.0', '0.0', '1.0', '-2.0', '0.5', '100.0',
                                         '1000000000000000.0', '1.0e+22', '1.5e-09', 'nan', 'inf']


def test_the_text_does_not_depend_on_the_neighbours():
    values = np.random.default_rng(4).normal(size=512) * 1e-5
    whole = texts(float_text(values))
    assert whole == [texts(float_text(values[i:i + 1]))[0] for i in range(512)]


@settings(max_examples=200, deadline=None)
@given(st.lists(st.integers(0, 10**20 - 1).map(lambda v: v % (9 * 10**18)), min_size=1,
                max_size=5))
def test_stamps_keep_every_nanosecond(stamps):
    for text, stamp in zip(texts(stamp_text(np.array(stamps, dtype=np.int64))), stamps):
        seconds, fraction = text.split('.')
        assert len(fraction) == 9
        assert int(seconds) * 10**9 + int(fraction) == stamp
