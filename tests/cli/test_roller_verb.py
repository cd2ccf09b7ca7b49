"""`mecanum roller`: numbers, drawing, table, mesh, refusals."""

import csv
import math
import xml.etree.ElementTree

import pytest

from mecanum_base.cli.main import main

WHEEL = ['--radius', '0.05', '--pin-radius', '0.04', '--count', '9']


def test_the_numbers_a_designer_needs_are_printed(capsys):
    assert main(['roller', *WHEEL]) == 0
    out = capsys.readouterr().out
    # r = 50, d = 40, 45 deg: equator 2(r-d), torus r+d and 2d, travel 2 d tan(pi/9)
    for words in ('20.000 mm', '90.000 mm', '80.000 mm', f'{80 * math.tan(math.pi / 9):.3f} mm',
                  'contact ratio', '2.06 %', '+6.42 %', 'clearance'):
        assert words in out


def test_the_angle_may_be_given_in_degrees_or_radians(capsys):
    texts = []
    for angle in ('60', '60deg', '1.0471975511965976', '1.0471975511965976rad'):
        assert main(['roller', *WHEEL, '--angle', angle]) == 0
        texts.append(capsys.readouterr().out)
    assert len(set(texts)) == 1 and 'at 60 deg' in texts[0]


def test_a_swedish_wheel_has_no_ripple_to_print(capsys):
    assert main(['roller', *WHEEL, '--angle', '90']) == 0
    out = capsys.readouterr().out
    assert 'sideways' not in out and 'at 90 deg' in out


def test_too_short_rollers_are_a_finding(capsys):
    assert main(['roller', *WHEEL, '--length', '0.03']) == 1
    assert 'too short' in capsys.readouterr().out


def test_rollers_that_intersect_are_noted_with_a_cure(capsys):
    assert main(['roller', '--radius', '0.05', '--pin-radius', '0.038', '--count', '9']) == 0
    assert 'note: full rollers of this size intersect; they clear each other from a pin radius ' \
        'of 39.' in capsys.readouterr().out


def test_the_csv_file_follows_the_roller_from_end_to_end(tmp_path):
    path = tmp_path / 'roller.csv'
    assert main(['roller', *WHEEL, '--csv', str(path)]) == 0
    with path.open(encoding='utf-8', newline='') as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    middle = rows[len(rows) // 2]
    assert middle['u'] == 0.0 and middle['radius'] == pytest.approx(0.01)
    assert all(abs(row['radius'] - row['torus_radius']) < 1e-4 for row in rows)
    assert all(math.hypot(row['contact_y'], row['contact_z']) == pytest.approx(0.05)
               for row in rows)


def test_the_drawing_shows_both_profiles_with_dimensions(tmp_path):
    pytest.importorskip('matplotlib')
    path = tmp_path / 'roller.svg'
    assert main(['roller', *WHEEL, '--svg', str(path)]) == 0
    root = xml.etree.ElementTree.parse(path).getroot()
    words = ' '.join(''.join(node.itertext()) for node in root.iter() if node.tag.endswith('text'))
    for part in ('exact meridian', 'torus', 'r_m = 90.00', 'L = 44.77', '\u00d8 20.00',
                 'hand-over'):
        assert part in words
    first = path.read_bytes()
    assert main(['roller', *WHEEL, '--svg', str(path)]) == 0
    assert path.read_bytes() == first  # reproducible


def test_the_meshes_are_watertight_and_in_millimetres(tmp_path):
    trimesh = pytest.importorskip('trimesh')
    path = tmp_path / 'roller.stl'
    assert main(['roller', *WHEEL, '--stl', str(path), '--bore', '0.002']) == 0
    one, whole = trimesh.load(path), trimesh.load(tmp_path / 'roller_set.stl')
    assert one.is_watertight and whole.is_watertight
    assert one.extents[0] == pytest.approx(44.774, abs=0.01)
    assert whole.volume == pytest.approx(9 * one.volume, rel=1e-4)
    assert max(whole.extents[1:]) == pytest.approx(100.0, abs=0.5)


def test_without_the_mesh_library_the_package_to_install_is_named(tmp_path, capsys, monkeypatch):
    import sys
    monkeypatch.setitem(sys.modules, 'trimesh', None)
    assert main(['roller', *WHEEL, '--stl', str(tmp_path / 'r.stl')]) == 2
    assert "pip install 'mecanum_base[mesh]'" in capsys.readouterr().err


@pytest.mark.parametrize(('words', 'text'), [
    (['--radius', '0.05', '--pin-radius', '0.047', '--count', '9'],
     'the roller would end in a point before the next roller takes over'),
    (['--radius', '0.05', '--pin-radius', '0.06', '--count', '9'], 'below the wheel radius'),
    (['--radius', '50', '--pin-radius', '40', '--count', '9'], 'is in metres: 50 mm is 0.05'),
    (['--radius', '-1', '--pin-radius', '0.06', '--count', '9'], 'radius'),
    (['--radius', '0.05', '--pin-radius', '0.04', '--count', '2'], 'at least 3 rollers'),
    ([*WHEEL, '--angle', '0'], 'cannot drive'), ([*WHEEL, '--length', '0.2'], 'length'),
    ([*WHEEL, '--stl', '/nonexistent/r.stl', '--bore', '0.009'], 'bore'),
    ([*WHEEL, '--csv', '/nonexistent/r.csv'], 'cannot be written')])
def test_impossible_wheels_are_refused_in_one_line(words, text, capsys):
    assert main(['roller', *words]) == 2
    err = capsys.readouterr().err
    assert text in err and len(err.splitlines()) == 1


def test_an_angle_that_is_none_is_refused(capsys):
    with pytest.raises(SystemExit) as caught:
        main(['roller', *WHEEL, '--angle', 'steep'])
    assert caught.value.code == 2
    assert 'is no angle' in capsys.readouterr().err
