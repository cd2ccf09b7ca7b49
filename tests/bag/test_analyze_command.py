import json
import re
import subprocess
import sys

import pytest


def bags(folder, make):
    folder.mkdir()
    make.write_mcap(folder / 'run_2.mcap', [e for e in make.drive(2.0) if 'imu' not in e[0]])
    make.write_mcap(folder / 'run_10.mcap', [e for e in make.drive(2.0) if 'imu' not in e[0]])
    return folder


def test_a_folder_of_bags_gives_one_report_and_code_0(tmp_path, make):
    pytest.importorskip('plotly', reason='needs the extra report')
    done = subprocess.run([sys.executable, '-m', 'mecanum_base', 'analyze',
                           str(bags(tmp_path / 'bags', make)), '--workers', '2', '--out',
                           str(tmp_path / 'out')], capture_output=True, text=True, timeout=180)
    assert done.returncode == 0, done.stderr
    assert done.stderr == '' and '\r' not in done.stdout
    names = [r['name'] for r in json.loads((tmp_path / 'out' / 'findings.json').read_text())]
    assert names == ['run_2.mcap', 'run_10.mcap']
    assert 'run_10.mcap' in (tmp_path / 'out' / 'report.html').read_text()


def test_a_blocker_gives_code_1_and_the_others_are_still_there(tmp_path, make, mecanum):
    folder = bags(tmp_path / 'bags', make)
    (folder / 'run_3.mcap').write_text('no bag')
    done = mecanum('analyze', folder, '--out', tmp_path / 'out', '--no-html', '--workers', 1)
    assert done.returncode == 1
    assert 'BLOCKER' in done.stdout and 'run_3.mcap' in done.stdout
    assert len(json.loads((tmp_path / 'out' / 'findings.json').read_text())) == 3


def test_two_robot_files_stand_side_by_side_with_a_table_of_what_differs(tmp_path, make, mecanum):
    from mecanum_base.robot_file import shipped
    robot = shipped() / 'mecanum4.yaml'
    other = tmp_path / 'other.yaml'
    other.write_text(re.sub(r'radius: *\[[^]]*\]', 'radius: [0.06, 0.06, 0.06, 0.06]',
                            robot.read_text(), count=1))
    entries = [e for e in make.drive(3.0) if 'imu' not in e[0]]
    entries += [('/ground_truth/odom', s,
                 make.odometry(s, (0.06 * 4.0 * (s - make.T0) / 1e9, 0, 0)))
                for s in range(make.T0, make.T0 + 3 * 10**9, 10**7)]
    make.write_mcap(tmp_path / 'a.mcap', sorted(entries, key=lambda e: e[1]))
    done = mecanum('analyze', tmp_path / 'a.mcap', '--robot', robot, '--compare', other, '--out',
                   tmp_path / 'out', '--no-html', '--workers', 1)
    first, second = json.loads((tmp_path / 'out' / 'findings.json').read_text())
    assert [first['name'], second['name']] == ['a.mcap (mecanum4.yaml)', 'a.mcap (other.yaml)'], \
        done.stderr
    found = second['comparison']
    assert [row['key'] for row in found['constants']] == ['wheels.radius']
    rows = {row['figure']: row for row in found['figures']}
    # the truth goes as wheels of 0.06 m do
    assert rows['wheels only: final error']['verdict'] == 'better'
    assert 'wheels only: final error [m]' in done.stdout and 'wheels.radius [m]' in done.stdout


def test_two_bags_stand_side_by_side(tmp_path, make, mecanum):
    for name, seconds in (('a.mcap', 2.0), ('b.mcap', 2.0)):
        entries = [e for e in make.drive(seconds) if 'imu' not in e[0]]
        if name == 'b.mcap':
            del entries[60:90]
        make.write_mcap(tmp_path / name, entries)
    done = mecanum('analyze', tmp_path / 'a.mcap', '--compare', tmp_path / 'b.mcap', '--out',
                   tmp_path / 'out', '--no-html', '--workers', 1)
    results = json.loads((tmp_path / 'out' / 'findings.json').read_text())
    assert [r['name'] for r in results] == ['a.mcap', 'b.mcap'], done.stderr
    rows = {row['figure']: row for row in results[0]['comparison']['figures']}
    assert rows['warnings']['verdict'] == 'worse'
    assert 'found only in the second: warning: /joint_states has gaps' in done.stdout


@pytest.mark.parametrize('words, reason', [
    (['none.mcap'], 'does not exist'), (['.'], 'no bag below')])
def test_wrong_input_is_one_line_and_code_2(tmp_path, mecanum, words, reason):
    empty = tmp_path / 'empty'
    empty.mkdir()
    path = empty if words == ['.'] else tmp_path / words[0]
    done = mecanum('analyze', path, '--out', tmp_path / 'out')
    assert done.returncode == 2 and reason in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_a_robot_file_to_compare_needs_a_first_one(tmp_path, make, mecanum):
    make.write_mcap(tmp_path / 'a.mcap', make.drive(1.0))
    done = mecanum('analyze', tmp_path / 'a.mcap', '--compare', 'other.yaml', '--out',
                   tmp_path / 'out')
    assert done.returncode == 2 and '--robot' in done.stderr


def test_control_characters_in_names_do_not_reach_the_terminal(tmp_path, make, mecanum):
    entries = [('/joint\x1b[2J_states', s, make.joint_state(s, [0.1, 0.2, 0.3, 0.4]))
               for s in range(make.T0, make.T0 + 10**9, 10**7)]
    del entries[40:80]
    make.write_mcap(tmp_path / 'a.mcap', entries)
    done = mecanum('analyze', tmp_path / 'a.mcap', '--out', tmp_path / 'out', '--no-html')
    assert 'gaps' in done.stdout and '\x1b' not in done.stdout
