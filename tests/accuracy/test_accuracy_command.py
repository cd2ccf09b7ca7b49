"""The Monte Carlo command end to end, and its tables."""

import dataclasses
import json

import pytest

from mecanum_base.accuracy.command import main
from mecanum_base.accuracy.drift import Drift
from mecanum_base.accuracy.slip_score import SlipScore
from mecanum_base.accuracy.summary import figures_of, overall
from mecanum_base.accuracy.table import aligned, tables
from mecanum_base.accuracy.trial import METHODS, Trial

SHORT = """
title: two steps of speed on a smooth floor
robot: mecanum4.yaml
duration: 3.0
sim: {friction: 0.2}
driver:
  accel: [0.0, 0.0, 0.0]
  script:
    - {seconds: 1.0, twist: [0.0, 0.0, 0.0]}
    - {seconds: 1.0, twist: [0.9, 0.0, 0.0]}
    - {seconds: 1.0, twist: [0.0, 0.0, 1.0]}
"""


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / 'short.yaml'
    path.write_text(SHORT)
    return str(path)


def test_one_or_two_processes_write_the_same_figures(scenario, tmp_path, capsys):
    for workers in ('1', '2'):
        assert main(['--out', str(tmp_path / workers), '--scenarios', scenario, '--seeds', '2',
                     '--workers', workers, '--json', str(tmp_path / f'{workers}.json')]) == 0
    first = (tmp_path / '1' / 'accuracy.json').read_bytes()
    assert first == (tmp_path / '2' / 'accuracy.json').read_bytes()
    assert first == (tmp_path / '2.json').read_bytes()
    out = capsys.readouterr()
    text = (tmp_path / '1' / 'accuracy.md').read_text()
    assert out.out == text + text
    assert out.err == ''  # no progress where nobody looks
    figures = json.loads(first)['scenarios'][0]
    assert figures['name'] == 'short' and figures['seeds'] == 2
    assert set(figures['errors']) == set(METHODS)
    assert figures['slip_share'] > 0.1  # an unlimited step on mu 0.2 spins the wheels
    assert figures['errors']['ours']['drift'] is None  # less than 5 m
    # knows the slip: within 1 cm after 0.8 m, where spinning wheels are decimetres off
    assert figures['errors']['oracle']['ate'] < 0.01 < figures['errors']['wheels']['ate']


def test_other_seeds_give_other_figures(scenario, tmp_path):
    for seed in ('1', '2'):
        main(['--out', str(tmp_path / seed), '--scenarios', scenario, '--seeds', '1',
              '--first-seed', seed, '--workers', '1'])
    one, two = (json.loads((tmp_path / s / 'accuracy.json').read_text())['scenarios'][0]
                for s in '12')
    assert one['errors']['wheels']['ate'] != two['errors']['wheels']['ate']


def test_beside_its_nees_stands_that_of_an_estimator_told_how_the_robots_are_built(
        scenario, tmp_path):
    found = []
    for words in ([], ['--told']):
        main(['--out', str(tmp_path), '--scenarios', scenario, '--seeds', '1', '--workers', '1',
              *words])
        found.append(json.loads((tmp_path / 'accuracy.json').read_text())['scenarios'][0])
    assert found[0]['nees_told'] is None
    assert found[1].pop('nees_told') > found[1]['nees_position']  # they are built better
    found[0].pop('nees_told')
    assert found[0] == found[1]  # nothing else changes


def test_wrong_input_is_refused_before_anything_runs(tmp_path, capsys):
    for words, message in ((['--scenarios', 'oill'], 'did you mean'),
                           (['--seeds', '0'], 'must be >= 1'),
                           (['--workers', '0'], 'must be >= 1'),
                           (['--first-seed', '-1'], 'must be >= 0')):
        assert main(['--out', str(tmp_path / 'out'), *words]) == 2
        assert message in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()


def test_a_base_without_fixed_wheels_is_refused(tmp_path, capsys):
    assert main(['--out', str(tmp_path), '--scenarios', 'carriers', '--seeds', '1',
                 '--workers', '1']) == 2
    assert 'must have fixed wheels' in capsys.readouterr().err


def trial(seed, share, segments, slipping=50):
    """A trial whose methods drift by ``share``, ours by half of it."""
    drift = Drift(segments * share**2, segments, 4.0, 4, 0.02, 0.1)
    ours = dataclasses.replace(drift, segment_squares=segments * (share / 2.0)**2)
    slip = SlipScore(8, 2, 2, (0.02, 0.04), 1, 1, 0.5, 3, 4, slipping, 1000)
    return Trial('made up', seed, 10.0, dict.fromkeys(METHODS, drift) | {'ours': ours},
                 (1.0, 2.0, 9.0), (), slip)


def test_seeds_are_pooled_by_segment_and_by_count():
    found = figures_of([trial(1, 0.01, 10), trial(2, 0.03, 30)])
    # sqrt((10 x 1 + 30 x 9)/40) %
    assert found.errors['wheels'].drift == pytest.approx(7.0**0.5)
    assert found.errors['wheels'].drift_median == pytest.approx(2.0)
    assert found.errors['wheels'].ate == pytest.approx(1.0)
    assert found.f1 == pytest.approx(0.8)
    assert found.latency == pytest.approx(0.03)
    assert found.missed_share == pytest.approx(2 / 6)
    assert found.false_per_hour == pytest.approx(2.0)
    assert found.diagonal == pytest.approx(0.75)
    assert found.nees_position == pytest.approx(2.0)
    assert found.coverage_position == pytest.approx(2 / 3)
    assert found.nees_velocity is None
    assert found.slips and found.ratio('wheels', 'ours') == pytest.approx(2.0)


def test_ratios_are_meant_geometrically_over_slip_scenarios_only():
    slippery = figures_of([trial(1, 0.01, 10)])
    calm = figures_of([trial(1, 0.01, 10, slipping=0)])
    short = figures_of([trial(1, 0.01, 0)])  # no segment, no figure
    found = overall([slippery, calm, short])
    assert found['rl_over_ours']['geometric_mean'] == pytest.approx(2.0)
    assert found['ours_over_oracle']['least'] == (pytest.approx(0.5), 'made up')
    assert found['ours_over_oracle_times_calm']['most'] == (pytest.approx(0.5), 'made up')
    assert overall([calm])['rl_over_ours'] is None


def test_a_single_run_that_is_worse_than_wheels_and_gyro_is_named():
    good, bad = trial(1, 0.01, 10), trial(2, 0.01, 10)
    wheels = bad.drift['wheels + gyro']
    # 2 % against 1 %; run 3: 0.15 % against 0.05 %, which is 5 mm in 5 m and no matter
    bad.drift['ours'] = dataclasses.replace(wheels, segment_squares=10 * 0.02**2)
    small = trial(3, 0.0005, 10)
    small.drift['ours'] = dataclasses.replace(wheels, segment_squares=10 * 0.0015**2)
    found = overall([figures_of([good, bad, small])])['worse_than_wheels_gyro']
    assert found == {'runs': 3, 'worse': [(pytest.approx(2.0), 'made up', 2)]}
    assert '1 of 3 (made up 2: 2.00 times)' in tables([figures_of([good, bad, small])])


def test_a_table_is_aligned_for_plain_reading():
    lines = aligned(['name', 'x'], [['a', '1.00'], ['longer', '-']]).splitlines()
    assert lines == ['| name   |    x |', '|--------|-----:|', '| a      | 1.00 |',
                     '| longer |    - |']
