"""`mecanum analyze`: findings and a report on recorded bags."""

from __future__ import annotations

import argparse
import pathlib
import sys
from typing import Any

HELP = 'findings on recorded bags: rates, gaps, wiring, slip, drift; one JSON file and one page'
EXAMPLE = '''mecanum analyze run.mcap --robot robot.yaml --out report
mecanum analyze run.mcap --robot robot.yaml --compare calibrated.yaml --out report
mecanum analyze monday.mcap --robot robot.yaml --compare tuesday.mcap --out report
mecanum analyze bags/ --out report'''
_SHOWN = 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the verb."""
    parser.add_argument('bag', nargs='+', metavar='BAG',
                        help='MCAP files, rosbag2 folders, or folders that hold any of these')
    parser.add_argument('--robot', metavar='FILE',
                        help='robot file (YAML); without it only the data are judged')
    parser.add_argument('--out', required=True, metavar='DIR',
                        help='folder for findings.json and report.html')
    parser.add_argument('--encoder-topic', metavar='T', help='topic of the encoders')
    parser.add_argument('--imu-topic', metavar='T', help='topic of the IMU')
    parser.add_argument('--no-imu', action='store_true', help='leave the IMU out')
    parser.add_argument('--truth-topic', metavar='T',
                        help='topic with the true pose (default: a pose topic named like '
                             'ground_truth, mocap, vicon ...)')
    parser.add_argument('--truth-frame', metavar='F',
                        help='of /tf as truth: parent frame of the base')
    parser.add_argument('--compare', metavar='FILE',
                        help='a second robot file (.yaml), every bag is analysed with both; or a '
                             'second bag: tables of what differs, and what is better or worse')
    parser.add_argument('--workers', type=int, default=0, metavar='N',
                        help='processes to use (default: one a processor)')
    parser.add_argument('--scheduler', metavar='URL',
                        help='run on a Dask cluster, for instance tcp://host:8786')
    parser.add_argument('--no-html', action='store_true', help='write findings.json only')


def run(options: argparse.Namespace) -> int:
    """Analyse, write the files, print the findings; 1 if there is a blocker."""
    from mecanum_base.bag.analysis.analyze import Options, check_options
    from mecanum_base.bag.analysis.comparison import compare
    from mecanum_base.bag.analysis.fleet import analyze_all
    from mecanum_base.bag.folder import bags_under
    from mecanum_base.bag.summary import write_json
    from mecanum_base.cli.progress import Progress
    from mecanum_base.core.errors import BagError, ConfigError
    paths = list(bags_under(options.bag))
    if not options.no_html:
        import jinja2  # noqa: F401  fail before the work, not after it
        import plotly  # noqa: F401
    other = options.compare
    by_file = other is not None and other.lower().endswith(('.yaml', '.yml'))
    if by_file and not options.robot:
        raise ConfigError('--compare', other, 'is a robot file: name the first one with --robot')
    choices = [Options(robot, options.encoder_topic, options.imu_topic, not options.no_imu,
                       options.truth_topic, options.truth_frame)
               for robot in [options.robot, *([other] if by_file else [])]]
    paths += [other] if other is not None and not by_file else []
    for choice in choices:
        check_options(paths, choice)
    jobs = [(path, choice) for path in paths for choice in choices]
    out = pathlib.Path(options.out)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BagError(f'{out}: cannot be written: {error.strerror}') from None
    with Progress('analyze') as progress:
        results = analyze_all(jobs, options.workers, options.scheduler, progress.update)
    comparisons = compare(results, by_file) if other is not None else []
    document = [{k: v for k, v in r.items() if k != 'plots'} for r in results]
    write_json(out / 'findings.json', document)
    if not options.no_html:
        from mecanum_base.report.analysis_page import write_report
        names = ', '.join(dict.fromkeys(str(r['name']) for r in results))
        title = names if len(names) < 60 else f'{len(results)} recordings'
        if len(comparisons) == 1:
            title = f'{comparisons[0]["first"]} against {comparisons[0]["second"]}'
        write_report(out / 'report.html', results, title)
    _print(results)
    if comparisons:
        from mecanum_base.cli.comparison_text import comparison_lines
        print('\n'.join(_plain(line) for line in comparison_lines(comparisons)))
    print(f'written to {out}')
    return 1 if any(r['counts']['blocker'] for r in results) else 0


def _print(results: list[dict[str, Any]]) -> None:
    marks = {'blocker': 'BLOCKER', 'warning': 'warning', 'note': 'note'}
    for result in results:
        if len(results) > 1:
            print(f'{result["name"]}:')
        shown = [f for f in result['findings'] if f['severity'] != 'note' or len(results) == 1]
        for finding in shown[:_SHOWN if len(results) > 1 else None]:
            print(f'{marks[finding["severity"]]:>7}  {_plain(finding["title"])}: '
                  f'{_plain(finding["evidence"])}')
        hidden = len(shown) - _SHOWN
        if len(results) > 1 and hidden > 0:
            print(f'         and {hidden} more')
    sys.stdout.flush()


def _plain(text: str) -> str:
    """Text from a bag without control characters, which could drive a terminal."""
    return ''.join(c if c.isprintable() else '?' for c in text)
