"""The estimator's track as analyze keeps it: by rows where they come so, the same numbers."""

import numpy as np
import pytest

import mecanum_base.bag.portion as portion
from mecanum_base.bag.analysis.estimate import Columns, estimated
from mecanum_base.bag.topics import Topics
from mecanum_base.robot_file import load_robot, shipped


def test_by_rows_and_one_by_one_give_the_same_bits(tmp_path, make, monkeypatch):
    path = make.write_mcap(tmp_path / 'a.mcap', make.drive(3.0))
    robot = load_robot(shipped() / 'mecanum4.yaml')
    written = []
    original = Columns.write_rows

    def counted(self, stamp_ns, *columns):
        written.append(len(stamp_ns))
        original(self, stamp_ns, *columns)

    monkeypatch.setattr(Columns, 'write_rows', counted)
    rows = estimated([path], robot, Topics.of(robot))
    assert sum(written) == len(rows.stamp_ns) > 5 * len(written)
    monkeypatch.setattr(portion, 'take', lambda *_: None)
    single = estimated([path], robot, Topics.of(robot))
    assert sum(written) == len(single.stamp_ns)  # no more rows
    for name in ('stamp_ns', 'sigma', 'slip', 'probability', 'body'):
        assert getattr(rows, name).tobytes() == getattr(single, name).tobytes(), name
    assert rows.track.pose.tobytes() == single.track.pose.tobytes()
    assert rows.slip.shape == rows.probability.shape == (len(rows.stamp_ns), 4)
    assert rows.path == pytest.approx(single.path, rel=1e-12)
    # straight at 4 rad/s and 0.05 m: the pose and its spread are those of the estimates
    assert rows.track.pose[-1, 0] == pytest.approx(3.0 * 0.2, rel=0.02)
    assert np.all(rows.sigma[1:] > 0.0) and rows.sigma[-1, 0] < 0.1


def test_a_recording_without_estimates_gives_none(tmp_path, make):
    path = make.write_mcap(tmp_path / 'a.mcap', make.drive(3.0)[:2])
    robot = load_robot(shipped() / 'mecanum4.yaml')
    assert estimated([path], robot, Topics.of(robot)) is None
