"""Wheel commands beside the encoder readings: who follows, whatever the rates, wraps and cuts."""

import numpy as np
import pytest

from mecanum_base.core.command.command_watch import CommandWatch
from mecanum_base.core.estimation.sensors import EncoderConfig

JOINTS = ('left', 'right', 'rear')
T0 = 1_700_000_000_000_000_000
SECOND = 1_000_000_000


def encoder(**more):
    return EncoderConfig(counts_per_revolution=1000.0, **more)


def stamps(seconds, rate):
    return T0 + np.arange(round(seconds * rate)) * round(SECOND / rate)


def told(watch, seconds=3.0, rates=(6.0, -4.0, 8.0)):
    """Commands at 50 Hz."""
    at = stamps(seconds, 50)
    assert watch.commands(at, np.tile(np.array(rates), (len(at), 1))) == 0


def turned(at, rates):
    """Angles (N, 3) of wheels that turn at constant rates."""
    return ((at - T0) * 1e-9)[:, None] * np.array(rates)


@pytest.mark.parametrize('rate', [3, 7, 13, 50, 97, 400])
def test_encoders_slower_or_faster_than_the_commands_are_no_stray(rate):
    watch = CommandWatch(JOINTS, encoder())
    told(watch)
    at = stamps(3.0, rate)
    watch.readings(at, turned(at, (6.2, -3.9, 8.0)))
    watch.flush()
    assert watch.strayed == () and watch.notes == ()


@pytest.mark.parametrize('rate', [3, 7, 13, 50, 97, 400])
def test_a_wheel_that_stands_is_named_at_any_rate(rate):
    watch = CommandWatch(JOINTS, encoder())
    told(watch)
    at = stamps(3.0, rate)
    watch.readings(at, turned(at, (6.0, 0.0, 8.0)))
    watch.flush()
    assert watch.notes == ('wheel right does not follow its command',)
    (joint, first, seconds), = watch.strayed
    # all of the time but the window of the first command and the rest behind the last frame
    assert joint == 'right' and first - T0 <= 0.7 * SECOND and 1.9 <= seconds <= 3.0


def test_motors_that_lag_behind_a_ramp_and_wheels_told_nothing_are_no_strays():
    """Time constant 0.15 s behind a ramp of 20 rad/s^2, forth and back; the third wheel: NaN."""
    at = stamps(4.0, 200)
    seconds = (at - T0) * 1e-9
    wanted = 10.0 * np.clip(2.0 * np.sin(1.6 * seconds), -1.0, 1.0)
    speed, angle = np.zeros(len(at)), np.zeros(len(at))
    for k in range(1, len(at)):
        speed[k] = speed[k - 1] + 0.005 / 0.15 * (wanted[k] - speed[k - 1])
        angle[k] = angle[k - 1] + 0.005 * speed[k]
    watch = CommandWatch(JOINTS, encoder())
    watch.commands(at[::4], np.column_stack([wanted, -wanted, np.full(len(at), np.nan)])[::4])
    watch.readings(at, np.column_stack([angle, -angle, 30.0 * seconds]))
    watch.flush()
    assert watch.strayed == ()


@pytest.mark.parametrize('kind', ['ticks16', 'ticks64', 'two_pi'])
def test_wraps_and_signs_do_not_show(kind):
    """The third wheel is mounted the other way round and jammed, the others pass many wraps."""
    more = {'position_wrap': 'two_pi'} if kind == 'two_pi' else {'counter_bits': int(kind[5:])}
    watch = CommandWatch(JOINTS, encoder(sign=np.array([1, 1, -1]), **more))
    told(watch, 25.0, (60.0, -60.0, -60.0))
    at = stamps(25.0, 50)
    angle = turned(at, (60.0, -60.0, 0.0))
    if kind == 'two_pi':
        value = np.mod(angle + np.pi, 2 * np.pi) - np.pi
    else:
        value = np.round(angle * 1000.0 / (2 * np.pi)).astype(np.int64)
        if kind == 'ticks16':
            value = (value + 2 ** 15) % 2 ** 16 - 2 ** 15
        else:
            value += (2 ** 63 - 100_000) * np.array([1, -1, 0], dtype=np.int64)
    watch.readings(at, value)
    watch.flush()
    assert watch.notes == ('wheel rear does not follow its command',)


def test_how_the_data_is_cut_does_not_matter():
    """One call, one message at a time, and random pieces with commands up to 0.2 s late."""
    rng = np.random.default_rng(5)
    at, sent = stamps(6.0, 90), stamps(6.0, 40)
    angle = turned(at, (6.0, -4.0, 8.0))
    angle[200:420, 1] = angle[200, 1]  # jammed for 2.4 s
    angle[rng.random(angle.shape) < 0.2] = np.nan  # partial messages
    rate = np.tile([6.0, -4.0, 8.0], (len(sent), 1))
    found = []
    for way in range(3):
        watch = CommandWatch(JOINTS, encoder())
        arrivals = sent + (rng.integers(0, SECOND // 5, len(sent)) if way == 2 else 0)
        if way == 0:
            watch.commands(sent, rate)
            watch.readings(at, angle)
        else:
            events = sorted([(int(t), 0, k) for k, t in enumerate(arrivals)]
                            + [(int(t), 1, k) for k, t in enumerate(at)])
            for _, is_reading, k in events:
                if not is_reading:
                    watch.commands(sent[k:k + 1], rate[k:k + 1])
                elif way == 1:
                    watch.reading(int(at[k]), angle[k])
                elif k % 7 == 6:
                    watch.readings(at[k - 6:k + 1], angle[k - 6:k + 1])
        watch.flush()
        found.append(watch.strayed)
    (joint, first, seconds), = found[0]
    assert joint == 'right' and abs((first - T0) / SECOND - 200 / 90) < 0.3
    assert seconds == pytest.approx(220 / 90, abs=0.3)  # within a window
    for other in found[1:]:
        assert [(w[0], w[1]) for w in other] == [(joint, first)]
        assert other[0][2] == pytest.approx(seconds, abs=1e-9)


def test_without_commands_or_once_they_cease_nothing_is_said():
    watch = CommandWatch(JOINTS, encoder())
    at = stamps(6.0, 50)
    watch.readings(at[:50], turned(at, (0.0, 0.0, 0.0))[:50])
    assert watch.used == 0
    told(watch, 2.0)
    watch.readings(at, turned(at, (6.0, -4.0, 0.0)))
    watch.flush()
    assert watch.notes == ()  # the last 4 s are without commands
    (joint, _, seconds), = watch.strayed
    assert joint == 'rear' and seconds < 2.6


def test_a_clock_that_goes_back_begins_anew_and_is_no_stray():
    watch = CommandWatch(JOINTS, encoder())
    at = stamps(3.0, 50)
    for _ in range(3):  # a bag played in a loop: angles jump back as well
        for k in range(len(at)):
            watch.commands(at[k:k + 1], np.array([[6.0, -4.0, 8.0]]))
            watch.reading(int(at[k]), turned(at, (6.0, -4.0, 0.0))[k])
    watch.flush()
    assert [joint for joint, _, _ in watch.strayed] == ['rear']
    assert 6.0 <= watch.strayed[0][2] <= 9.0


def test_absurd_numbers_neither_raise_nor_stick():
    watch = CommandWatch(JOINTS, encoder())
    told(watch, 6.0)
    assert watch.commands(stamps(0.1, 50), np.full((5, 3), np.nan)) == 5
    at = stamps(6.0, 50)
    angle = turned(at, (6.0, -4.0, 8.0))
    angle[20, 0], angle[30, 1], angle[40] = 1e300, -np.inf, np.nan
    at[25] += 3600 * SECOND
    for k in range(len(at)):
        watch.reading(int(at[k]), angle[k])
    watch.flush()
    assert watch.notes == ()
