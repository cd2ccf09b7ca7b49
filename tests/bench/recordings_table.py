"""The real recordings: known quirks against findings, and calibration on runs it never saw.

    python tests/bench/recordings_table.py DATA [--converter FILE] [--work DIR] [--doc FILE]

DATA holds the sets, the converter (default: DATA/../tools/to_mcap.py) turns a run into a bag. The
tables go to standard output, or between the marks of the document.
"""

from __future__ import annotations

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile
from fnmatch import fnmatch

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import recordings_quirks as known

from mecanum_base.bag.analysis.analyze import Options, analyze
from mecanum_base.bag.analysis.evidence import evidence_of
from mecanum_base.cli.progress import Progress
from mecanum_base.robot_file import load_robot

AS_LOGGED = 'as logged'  # optiodom_omni4_mecanum with the time and counts of its log
# fit on some runs, judge on others (globs): never the same run on both sides
CROSS = (
    ('optiodom_omni4_mecanum', 'circles, September', 'circular_0809*', 'squares', 'square_0809*'),
    ('optiodom_omni4_mecanum', 'squares, September', 'square_0809*', 'circles', 'circular_0809*'),
    ('optiodom_omni4_mecanum', 'circles, December', 'circular_2312*', 'squares', 'square_2312*'),
    ('optiodom_omni4_mecanum', 'squares, December', 'square_2312*', 'circles', 'circular_2312*'),
    ('optiodom_omni4_mecanum', 'both ways, September', '*0809*run-0[17]', 'other runs of them',
     '*0809*run-?[024]'),
    ('optiodom_omni4_mecanum', 'both ways, December', '*2312*run-0[17]', 'other runs of them',
     '*2312*run-?[03]'),
    ('optiodom_omni3', 'free driving', 'joystick*', 'circles and squares', '[cs]*'),
    ('optiodom_omni3', 'circles and squares', '[cs]*', 'free driving', 'joystick*'),
    ('robotino_omni3_slip', 'table, 4 directions', 'one_surface_table_exp?[04]',
     'table, 2 others', 'one_surface_table_exp?[68]'),
    ('robotino_omni3_slip', 'table', 'one_surface_table*', 'brown', 'one_surface_brown*'),
    ('maverick_omni3_imu', 'exp1', 'exp1', 'exp2', 'exp2'),
)
DOCTOR = ['set', 'runs', 'no fault found', 'cannot say: motion', 'not to be told apart',
          'fault named (wrong)']
FIGURES = (('ate', 1.0, 'm'), ('final', 1.0, 'm'), ('yaw_rms', 180.0 / np.pi, 'deg'))


def runs_of(converter, name):
    """Runs of one set."""
    done = subprocess.run([sys.executable, str(converter), '--list', name], check=True,
                          capture_output=True, text=True)
    return done.stdout.split()


def converted(converter, data, name, run, folder, *more):
    """Folder with bag/ and robot.yaml of one run, made where it is not there."""
    place = folder / run.replace('/', '_')
    if not (place / 'bag' / 'metadata.yaml').exists():
        subprocess.run([sys.executable, str(converter), name, run, str(place), '--root',
                        str(data), *more], check=True, capture_output=True)
    return place


def all_places(options, work):
    """{set: {run: folder}} of everything, converted."""
    found = {}
    for name in known.QUIRKS:
        source, more = ((name, ()) if name != AS_LOGGED
                        else ('optiodom_omni4_mecanum', ('--as-logged',)))
        runs = [r for r in runs_of(options.converter, source)
                if name != AS_LOGGED or r.endswith('run-01')]
        folder = work / name.replace(' ', '_')
        folder.mkdir(parents=True, exist_ok=True)
        found[name] = {r.replace('/', '_'): converted(options.converter, options.data, source, r,
                                                      folder, *more) for r in runs}
    return found


def judged(place, robot_file=None):
    """Result of analyze with the nominal robot file, another one, or none."""
    own = place / 'robot.yaml'
    chosen = robot_file or (str(own) if own.exists() else None)
    result = analyze(str(place / 'bag'), Options(chosen))
    result.pop('plots')
    return result


def calibrated(places, out):
    """(robot file or None, what calibrate printed)."""
    done = subprocess.run(
        [sys.executable, '-m', 'mecanum_base', 'calibrate', *(str(p / 'bag') for p in places),
         '--robot', str(places[0] / 'robot.yaml'), '--out', str(out)],
        capture_output=True, text=True)
    return (out if done.returncode == 0 else None), done.stdout + done.stderr


def shown(results, track, key, factor):
    """Mean over results of one figure of one track."""
    values = [d[key] for r in results for d in r['drift'] if d['name'] == track]
    values = [abs(v) * factor for v in values if v is not None]
    return f'{np.mean(values):.3f}' if values and factor == 1.0 else (
        f'{np.mean(values):.1f}' if values else '-')


def cross_rows(places, results, work, progress):
    """[fit on, judged on, runs, wheels nominal -> calibrated ..., estimator ...] of each pair."""
    rows, given = [], []
    for number, (name, fit, fit_runs, test, test_runs) in enumerate(CROSS):
        progress(number / len(CROSS))
        fitted = [p for run, p in places[name].items() if fnmatch(run, fit_runs)]
        tested = {run: p for run, p in places[name].items() if fnmatch(run, test_runs)}
        assert fitted and tested and not set(fitted) & set(tested.values())
        file, told = calibrated(fitted, work / f'calibrated_{number}.yaml')
        given.append([f'{name}: {fit}', *(_value(told, word) for word in (
            'radius (way forward)', 'way sideways', 'yaw (radius over lever)'))])
        before = [results[name][run] for run in tested]
        after = [judged(p, str(file)) for p in tested.values()] if file else None
        for track in ('wheels only', 'estimator'):
            rows.append([name, f'{fit} ({len(fitted)})', f'{test} ({len(tested)})', track] + [
                f'{shown(before, track, key, factor)} -> '
                + (shown(after, track, key, factor) if after else 'refused')
                for key, factor, _ in FIGURES])
    return rows, given


def doctor_rows(places):
    """[set, runs, no fault, cannot say, not to be told apart, named] of `mecanum doctor`.

    All robots are wired as their nominal files say, so a named fault would be a wrong one.
    """
    rows, wrong = [], 0
    for name, runs in places.items():
        words = []
        for place in runs.values():
            file = place / 'robot.yaml'
            if not file.exists():
                continue
            verdict = evidence_of(str(place / 'bag'), load_robot(str(file))).examined()
            words.append('named' if verdict.diagnoses else 'apart' if verdict.unclear
                         else 'cannot say' if verdict.missing else 'no fault')
        if words:
            wrong += words.count('named')
            rows.append([name, str(len(words)), *(str(words.count(w)) for w in (
                'no fault', 'cannot say', 'apart', 'named'))])
    return rows, wrong


def put(doc, mark, table):
    """Replace what stands between the marks of a document."""
    begin, end = f'<!-- {mark} -->\n', f'<!-- end of {mark} -->'
    head, rest = doc.read_text().split(begin)
    doc.write_text(head + begin + table + '\n' + end + rest.split(end)[1])


def _value(told, word):
    line = next((t for t in told.splitlines() if t.startswith(word)), '')
    found = re.search(r'x ([\d.]+) +90 %: ([\d.]+) to ([\d.]+)', line)
    return f'{found[1]} ({found[2]} to {found[3]})' if found else 'not given'


def markdown(head, rows):
    """A table in Markdown."""
    return '\n'.join(['| ' + ' | '.join(row) + ' |' for row in (
        head, ['---'] * len(head), *[[str(c) for c in row] for row in rows])])


def tables(options, work):
    """{mark: Markdown} of all tables, and the number of missed or false findings."""
    found, wrong, results = {}, 0, {}
    with Progress('recordings') as progress:
        progress.update(0.0, 'converting')
        places = all_places(options, work)
        total, done = sum(len(runs) for runs in places.values()), 0
        for name, runs in places.items():
            results[name] = {}
            for run, place in runs.items():
                results[name][run] = judged(place)
                done += 1
                progress.update(done / total, f'analysing {name}')
        rows, given = cross_rows(places, results, work,
                                 lambda share: progress.update(share, 'calibrating'))
        progress.update(1.0, 'doctor')
        doctor, named = doctor_rows(places)
    wrong += named
    quirks, warnings = [], []
    for name, runs in results.items():
        some, missed = known.quirk_rows(name, runs)
        wrong += missed
        quirks += [[name, *row] for row in some]
        warnings += [[name, *row] for row in known.warning_rows(name, runs)]
    wrong += sum('unexplained' in row[-1] for row in warnings)
    found['quirks'] = markdown(['set', 'known', 'runs', 'found', 'measured'], quirks)
    found['warnings'] = markdown(['set', 'finding', 'runs', 'why it is true'], warnings)
    found['doctor'] = markdown(DOCTOR, doctor)
    found['constants'] = markdown(['fitted on', 'radius x', 'sideways x', 'yaw x'], given)
    found['cross'] = markdown(['set', 'fitted on (runs)', 'judged on (runs)', 'track',
                               *(f'{key} [{unit}]' for key, _, unit in FIGURES)], rows)
    return found, wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('data', type=pathlib.Path, help='folder that holds the sets')
    parser.add_argument('--converter', type=pathlib.Path, help='to_mcap.py')
    parser.add_argument('--work', type=pathlib.Path, help='keep the converted bags here')
    parser.add_argument('--doc', type=pathlib.Path, help='document to put the tables into')
    options = parser.parse_args()
    options.converter = options.converter or options.data.parent / 'tools' / 'to_mcap.py'
    with tempfile.TemporaryDirectory() as folder:
        found, wrong = tables(options, options.work or pathlib.Path(folder))
    for mark, table in found.items():
        if options.doc:
            put(options.doc, mark, table)
        else:
            print(f'\n{mark}\n\n{table}')
    print(f'{wrong} missed, false or unexplained findings')
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
