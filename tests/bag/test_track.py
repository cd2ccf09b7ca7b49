import csv
import pathlib

import numpy as np
import pytest

from mecanum_base.bag.track import TRACK_COLUMNS, TrackWriter, slip_columns
from mecanum_base.core.errors import BagError
from mecanum_base.core.records import Estimate, SlipEstimate

JOINTS = ('a_joint', 'b_joint', 'c_joint')


def estimates(count, seed=1):
    generator = np.random.default_rng(seed)
    for i in range(count):
        grid = generator.normal(size=(3, 3)) * 1e-3
        slip = SlipEstimate(generator.normal(size=3), generator.normal(size=3),
                            generator.random(3), float(generator.random()),
                            generator.normal(size=4), generator.normal(size=3), np.eye(3))
        yield Estimate(1_700_000_000_000_000_000 + i * 10_000_001,
                       'encoder' if i % 3 else 'predicted', generator.normal(size=3),
                       grid @ grid.T, generator.normal(size=3), np.eye(3), slip)


def rows_of(path):
    with open(path, newline='') as file:
        return list(csv.reader(file))


def test_files_hold_exactly_the_numbers_of_the_estimates(tmp_path):
    given = list(estimates(50))
    with TrackWriter(tmp_path, JOINTS) as writer:
        for estimate in given:
            writer.write(estimate)
    track, slip = rows_of(tmp_path / 'track.csv'), rows_of(tmp_path / 'slip.csv')
    assert tuple(track[0]) == TRACK_COLUMNS and track[0][-1] == 'source'
    assert tuple(slip[0]) == slip_columns(JOINTS) == (
        'stamp', 'a_joint.slip_rate', 'a_joint.probability', 'b_joint.slip_rate',
        'b_joint.probability', 'c_joint.slip_rate', 'c_joint.probability', 'body.probability')
    assert len(track) == len(slip) == 51
    for line, slips, estimate in zip(track[1:], slip[1:], given):
        assert line[0] == slips[0] == (f'{estimate.stamp_ns // 10**9}.'
                                       f'{estimate.stamp_ns % 10**9:09d}')
        c = estimate.pose_covariance
        assert [float(v) for v in line[1:-1]] == [
            *estimate.pose, *estimate.twist, c[0, 0], c[0, 1], c[1, 1], c[0, 2], c[1, 2], c[2, 2]]
        assert line[-1] == estimate.source
        assert [float(v) for v in slips[1:-1:2]] == estimate.slip.rate.tolist()
        assert [float(v) for v in slips[2:-1:2]] == estimate.slip.probability.tolist()
        assert float(slips[-1]) == estimate.slip.body_probability


def test_the_tum_file_holds_eight_numbers_a_line_and_a_unit_quaternion(tmp_path):
    given = list(estimates(10))
    with TrackWriter(tmp_path, JOINTS) as writer:
        for estimate in given:
            writer.write(estimate)
    lines = (tmp_path / 'odometry.tum').read_text().splitlines()
    for line, estimate in zip(lines, given):
        _, x, y, z, qx, qy, qz, qw = (float(v) for v in line.split(' '))
        assert (x, y, z, qx, qy) == (*estimate.pose[:2], 0.0, 0.0, 0.0)
        assert np.exp(2j * np.arctan2(qz, qw)) == pytest.approx(np.exp(1j * estimate.pose[2]))


def test_bytes_do_not_depend_on_when_rows_are_flushed(tmp_path):
    for name, period in (('a', 0), ('b', 97), ('c', 11)):
        with TrackWriter(tmp_path / name, JOINTS) as writer:
            for index, estimate in enumerate(estimates(2300)):
                writer.write(estimate)
                if period and index % period == 0:
                    writer.flush()
    for file in ('track.csv', 'slip.csv', 'odometry.tum'):
        first = (tmp_path / 'a' / file).read_bytes()
        assert first == (tmp_path / 'b' / file).read_bytes()
        assert first == (tmp_path / 'c' / file).read_bytes()


def test_rows_written_at_once_equal_estimates_written_one_by_one(tmp_path):
    given = list(estimates(5000))
    with TrackWriter(tmp_path / 'a', JOINTS) as writer:
        for estimate in given:
            writer.write(estimate)
    covariance = [e.pose_covariance[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]] for e in given]
    slip = np.zeros((5000, 7))
    slip[:, 0:-1:2] = [e.slip.rate for e in given]
    slip[:, 1:-1:2] = [e.slip.probability for e in given]
    slip[:, -1] = [e.slip.body_probability for e in given]
    with TrackWriter(tmp_path / 'b', JOINTS) as writer:
        writer.write(given[0])
        writer.write_rows(
            np.array([e.stamp_ns for e in given])[1:],
            np.column_stack([[e.pose for e in given], [e.twist for e in given], covariance])[1:],
            slip[1:], np.array([e.source == 'predicted' for e in given])[1:])
    for file in ('track.csv', 'slip.csv', 'odometry.tum'):
        assert (tmp_path / 'a' / file).read_bytes() == (tmp_path / 'b' / file).read_bytes()


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path):
    (tmp_path / 'file').write_text('')
    with pytest.raises(BagError, match='cannot be written'):
        TrackWriter(tmp_path / 'file' / 'inside', JOINTS)


def test_joint_names_with_commas_keep_the_header_readable(tmp_path):
    with TrackWriter(tmp_path, ('a,b', 'c"d', 'e')):
        pass
    assert rows_of(tmp_path / 'slip.csv')[0][1] == 'a,b.slip_rate'
    assert rows_of(tmp_path / 'slip.csv')[0][3] == 'c"d.slip_rate'


@pytest.mark.skipif(not pathlib.Path('/dev/full').exists(), reason='needs /dev/full')
def test_a_full_disk_is_an_error_in_one_line_and_closes_the_files(tmp_path):
    (tmp_path / 'track.csv').symlink_to('/dev/full')
    writer = TrackWriter(tmp_path, JOINTS)
    with pytest.raises(BagError, match='cannot be written: No space left'):
        writer.flush()
    with pytest.raises(BagError, match='cannot be written: No space left'):
        writer.close()
    writer.close()
