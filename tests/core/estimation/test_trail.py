"""Rows of the trail: final when handed out, rewritten before, room only where it is asked for."""

import numpy as np
import pytest
from staged_drive import RECTANGLE, estimator, frames, imu, merged, staged, summed, unloaded

from mecanum_base.core.estimation import trail
from mecanum_base.core.estimation.layout import REEL_ROWS

AHEAD = staged((0.7, (0.0, 0.0, 0.0)), (2.0, (0.5, 0.0, 0.0)))


@pytest.fixture(scope='module')
def samples():
    """All wheels slip, slowly: found late, so that a second of frames is taken again."""
    share = np.interp(AHEAD.t, [1.4, 2.4], [0.0, 0.25])
    angles = summed((AHEAD.twist + share[:, None] * np.array([1.0, 0.0, 0.0])) @ RECTANGLE.T)
    return merged(imu(AHEAD), frames(AHEAD, angles))


def test_rows_handed_out_are_those_that_stand_at_the_end_though_later_ones_are_rewritten():
    # a diagonal glides for 2 s, unseen until it grips: then 2.5 s of frames are taken again
    glide, turned, _, _ = unloaded(0.05, 0.1)
    samples = merged(imu(glide), frames(glide, turned))
    subject = estimator(smoothed=True)
    filtered, out, rewritten = subject._filter, [], 0
    seen = {}
    filtered._smoother.take = lambda stamp, rows: out.append((stamp, rows))
    for sample in samples:
        subject.handle(sample)
        memory = filtered.memory
        for row, stamp in zip(memory.trail, memory.trail_ns[:memory.reel[REEL_ROWS]].tolist()):
            rewritten += stamp in seen and seen[stamp] != row[trail.WHEELS]
            seen[stamp] = row[trail.WHEELS]
        subject.past()
    subject.flush()
    subject.past(last=True)
    whole = estimator(smoothed=True)
    kept = []
    whole._filter._smoother.take = lambda stamp, rows: kept.append((stamp, rows))
    for sample in samples:
        whole.handle(sample)
    whole.flush()
    whole.past(last=True)
    assert rewritten > 200
    assert len(out) > 10 > len(kept)
    for often, once in zip(zip(*out), zip(*kept)):
        assert np.array_equal(np.concatenate(often), np.concatenate(once))


def test_without_room_nothing_is_written_and_with_room_nothing_is_lost(samples):
    subject = estimator()
    for sample in samples[:90]:
        subject.handle(sample)
    assert subject._filter.memory.reel[REEL_ROWS] == 0
    memory = trail.with_room(subject._filter.memory, 3)
    for number in range(3):
        memory.x[0] = number
        trail.mark(memory)
    larger = trail.with_room(memory, 1000)
    assert trail.free(larger) >= 1000
    assert larger.trail[:3, 0].tolist() == [0.0, 1.0, 2.0]
    left, stamp, rows = trail.hand_out(larger, 2)
    assert left.trail[0, 0] == 2.0 and left.reel[REEL_ROWS] == 1
    assert left.trail.shape == larger.trail.shape
    left.trail[:] = 9.0  # what was handed out is not written to any more
    assert rows[:, 0].tolist() == [0.0, 1.0] and len(stamp) == 2
