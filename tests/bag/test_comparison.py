"""Difference tables of `mecanum analyze --compare`, from results made by hand."""

import json

import driving
import pytest

from mecanum_base.bag.analysis.comparison import (
    compare,
    constants,
    figures,
    listed,
    over_all,
    table_of,
    verdict,
)
from mecanum_base.cli.comparison_text import comparison_lines
from mecanum_base.robot import Robot
from mecanum_base.robot_file import parse_parameters


def result(name, ate=0.1, warnings=0, findings=()):
    drift = {'name': 'estimator', 'ate': ate, 'ate_best': None, 'final': 0.2, 'yaw_final': -0.1,
             'yaw_rms': None, 'rpe': {'1': {'share': 0.05}}}
    return {'name': name, 'robot_file': None, 'counts': {'blocker': 0, 'warning': warnings},
            'drift': [drift], 'findings': list(findings)}


def finding(code, severity='warning', topic='', **numbers):
    return {'code': code, 'severity': severity, 'topic': topic, 'title': f'{code} {topic}',
            'numbers': numbers}


@pytest.mark.parametrize('first, second, rule, wanted', [
    (0.2, 0.1, 'less', 'better'), (0.1, 0.2, 'less', 'worse'), (0.1, 0.1005, 'less', 'same'),
    (0.0, 0.0, 'less', 'same'), (0.9, 1.02, 'one', 'better'), (1.02, 0.9, 'one', 'worse'),
    (-0.3, 0.2, 'zero', 'better'), (0.1, -0.2, 'zero', 'worse'), (1.0, 2.0, '', ''),
    (None, 1.0, 'less', ''), (1.0, None, 'less', '')])
def test_better_is_smaller_nearer_to_one_or_nearer_to_zero(first, second, rule, wanted):
    assert verdict(first, second, rule) == wanted


def test_constants_that_differ_come_with_unit_and_change():
    first = Robot.from_mapping(parse_parameters(driving.YAML, 'a'))
    text = driving.YAML.replace('radius: [0.05, 0.05, 0.05, 0.05]',
                                'radius: [0.05, 0.05, 0.05, 0.06]')
    text += '    imu: {rpy: [0.0, 0.0, 0.1]}\n'
    second = Robot.from_mapping(parse_parameters(text, 'b'))
    rows = {row['key']: row for row in constants(first, second)}
    assert set(rows) == {'wheels.radius', 'imu.rpy'}
    assert rows['wheels.radius']['unit'] == 'm'
    assert rows['wheels.radius']['change'] == '+0.00 to +20.00 %'
    assert rows['imu.rpy']['change'] == 'by up to 0.1'
    assert constants(first, first) == []


def test_figures_of_findings_and_drift_are_set_side_by_side():
    first = result('a', 0.1, 1, [finding('scales_off', forward=0.9), finding('gaps', topic='/a',
                                                                             share=0.1)])
    second = result('b', 0.05, 0, [finding('scales_agree', 'note', forward=1.01)])
    rows = {row['figure']: row for row in figures(first, second)}
    assert rows['estimator: ATE']['change'] == pytest.approx(-0.05)
    assert rows['estimator: final yaw error']['first'] == pytest.approx(5.73, abs=0.01)  # deg
    assert rows['truth over wheels, forward']['verdict'] == 'better'
    assert rows['messages missing (/a)']['second'] is None
    found, = compare([first, second], by_file=False)
    assert first['comparison'] is found
    assert [f['title'] for f in found['gone']] == ['scales_off ', 'gaps /a'] and not found['new']
    assert ['estimator: ATE [m]', '0.1', '0.05', '-0.05', 'better'] in table_of(found)
    json.dumps(found, allow_nan=False)


def test_several_recordings_are_also_counted_together():
    results = [{**result(f'{bag}', ate), 'robot_file': None}
               for bag in 'abc' for ate in (0.2, 0.1 if bag != 'c' else 0.3)]
    comparisons = compare(results[:1] + results[1:2], by_file=False) + compare(
        results[4:6], by_file=False)
    row = next(r for r in over_all(comparisons) if r['figure'] == 'estimator: ATE')
    assert (row['recordings'], row['better'], row['worse']) == (2, 1, 1)
    assert row['second'] == pytest.approx(0.2)
    text = '\n'.join(comparison_lines(comparisons))
    assert 'over all 2 (means):' in text and 'better in' in text


def test_equal_results_say_so():
    found = compare([result('a'), result('b')], by_file=False)
    assert 'no figure differs' in '\n'.join(comparison_lines(found))
    assert listed([0.1, None, 'x']) == '[0.1, -, x]'
