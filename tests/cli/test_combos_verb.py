"""`mecanum combos`: table, counts, exports, unequal speeds."""

import csv
import json

import pytest

from mecanum_base.cli.main import main
from mecanum_base.robot_file import shipped


def test_the_table_has_81_rows_the_counts_and_the_caveat(capsys):
    assert main(['combos']) == 0
    lines = capsys.readouterr().out.splitlines()
    rows = [line for line in lines if line[:4].strip('+-0') == '' and len(line.split()) > 8]
    assert len(rows) == 81 and rows[0].split()[:2] == ['++++', '4']
    assert sum(row.split()[-1] != '-' for row in rows) == 16
    assert any(line.startswith('   19  fit one rigid motion') for line in lines)
    assert any(line.startswith('   30  stall') for line in lines)
    assert '51/30 of the paper' in lines[-1]


def test_csv_and_json_carry_every_column_of_every_combination(tmp_path, capsys):
    names = tmp_path / 'c.csv', tmp_path / 'c.json'
    assert main(['combos', '--csv', str(names[0]), '--json', str(names[1])]) == 0
    with names[0].open(encoding='utf-8', newline='') as file:
        rows = list(csv.DictReader(file))
    document = json.loads(names[1].read_text(encoding='utf-8'))
    assert len(rows) == len(document['combinations']) == 81
    for row, record in zip(rows, document['combinations']):
        assert row['combination'] == record['combination']
        assert float(row['vx']) == record['vx']
    assert document['counts']['stalled'] == 30 and document['counts']['no_slip'] == 19
    assert document['wheels']['1'] == 'front_right_wheel_joint'
    stop = next(r for r in document['combinations'] if r['combination'] == '0000')
    assert stop['bearing_deg'] is None and stop['idle_free'] == 'stop'


def test_unequal_speeds_show_slip_per_wheel(capsys):
    assert main(['combos', '--speeds', '2,1,2,-1']) == 0
    out = capsys.readouterr().out
    assert 'parity      +2 rad/s' in out and 'contradict' in out and '+0.5' in out


def test_speeds_stand_in_the_order_of_the_file(tmp_path, capsys):
    path = tmp_path / 'one.json'
    assert main(['combos', '--speeds', '1,2,3,4', '--json', str(path)]) == 0
    record = json.loads(path.read_text(encoding='utf-8'))['combinations'][0]
    assert record['front_left_wheel_joint.rate'] == 1
    assert record['rear_right_wheel_joint.rate'] == 4
    assert record['parity'] == pytest.approx(1 + 2 - 3 - 4)


def test_a_pair_turn_names_its_centre_and_the_motion_with_free_idle_wheels(capsys):
    assert main(['combos', '--speeds=1,-1,0,0', '--json', '/dev/null']) == 0
    out = capsys.readouterr().out
    assert 'no slip' in out and 'centre      (-0.347, 0) m' in out and 'least drag' in out


def test_any_four_wheel_robot_will_do_and_a_reversed_order_of_wheels_too(capsys):
    for name in ('asymmetric', 'swedish4'):
        assert main(['combos', '--robot', str(shipped() / f'{name}.yaml')]) == 0
    assert '1 = front_right_wheel_joint' in capsys.readouterr().out


@pytest.mark.parametrize(('words', 'text'), [
    (['--robot', str(shipped() / 'swedish3.yaml')], 'four roller wheels'),
    (['--robot', str(shipped() / 'dual_differential.yaml')], 'four roller wheels'),
    (['--rate', '0'], '--rate'), (['--csv', '/nonexistent/c.csv'], 'cannot be written')])
def test_what_cannot_be_done_is_one_line_and_code_2(words, text, capsys):
    assert main(['combos', *words]) == 2
    err = capsys.readouterr().err
    assert text in err and len(err.splitlines()) == 1


@pytest.mark.parametrize('speeds', ['1,2,3', 'a,b,c,d', '1,2,3,nan'])
def test_speeds_must_be_four_numbers(speeds, capsys):
    with pytest.raises(SystemExit) as caught:
        main(['combos', '--speeds', speeds])
    assert caught.value.code == 2
