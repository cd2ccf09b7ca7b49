"""The page of `mecanum analyze`: complete in itself, escaped, and drawn by a real browser."""

import html
import json
import re
import shutil
import subprocess

import numpy as np
import pytest

pytest.importorskip('jinja2', reason='needs the extra report')
pytest.importorskip('plotly', reason='needs the extra report')

from mecanum_base.report.analysis_page import write_report

BROWSER = next((p for p in map(shutil.which, ('chromium', 'chromium-browser', 'google-chrome'))
                if p), None)
EVIL = '</script><script>document.title="broken"</script><img src=x onerror=alert(1)>'


def result(name='run.mcap', topic='/joint_states'):
    t = np.linspace(0.0, 10.0, 200)
    line = {'x': t.tolist(), 'y': np.sin(t).tolist()}
    finding = {'severity': 'warning', 'code': 'gaps', 'title': f'{topic} has gaps',
               'evidence': '3 gaps', 'advice': 'look', 'topic': topic,
               'spans': [[1.0, 1.5]], 'numbers': {}}
    drift = {'name': 'estimator', 'alignment': 'start', 'path': 10.0, 'seconds': 10.0,
             'ate': 0.01, 'ate_best': 0.005, 'final': 0.02, 'final_share': 0.002,
             'yaw_final': 0.01, 'yaw_rms': 0.01,
             'rpe': {'1': {'segments': 9.0, 'rms': 0.01, 'share': 0.01, 'yaw_rms': 0.001}}}
    return {'bag': name, 'name': name, 'robot_file': None, 'version': '0', 'duration': 10.0,
            'topics': [{'topic': topic, 'type': 'sensor_msgs/msg/JointState', 'count': 5,
                        'rate': 50.0, 'jitter': 0.001, 'largest_gap': 0.5, 'delay': 0.0,
                        'rejected': 0}],
            'findings': [finding, {**finding, 'severity': 'blocker', 'title': 'broken'}],
            'counts': {'blocker': 1, 'warning': 1, 'note': 0}, 'drift': [drift], 'motion': {},
            'slip_episodes': [],
            'plots': {'paths': {topic: line, 'truth': line}, 'slip': {topic: line},
                      'sigma': {'x': line['x'], 'position': line['y'], 'yaw': line['y']}}}


def test_the_page_asks_for_nothing_from_the_network(tmp_path):
    write_report(tmp_path / 'a.html', [result()], 'run')
    text = (tmp_path / 'a.html').read_text()
    head = re.sub(r'<script>.*?</script>', '', text, flags=re.DOTALL)
    assert not re.search(r'(src|href)\s*=\s*["\']?(https?:)?//', head)
    assert '<link' not in head and '@import' not in head
    assert 'prefers-color-scheme: dark' in head and 'width=device-width' in head


def test_strings_from_a_bag_are_escaped_everywhere(tmp_path):
    write_report(tmp_path / 'a.html', [result(EVIL, EVIL), result('b')], EVIL)
    text = (tmp_path / 'a.html').read_text()
    assert EVIL not in text
    assert '<img src=x' not in text
    assert '<script>document.title' not in text


def test_several_recordings_start_with_a_table_of_all(tmp_path):
    write_report(tmp_path / 'a.html', [result('one'), result('two')], 'both')
    text = (tmp_path / 'a.html').read_text()
    assert 'All recordings' in text and 'two: Findings' in text


def comparison():
    row = {'figure': EVIL, 'unit': 'm', 'first': 0.2, 'second': 0.1, 'change': -0.1}
    return {'first': 'one', 'second': EVIL,
            'constants': [{'key': 'wheels.radius', 'unit': 'm', 'first': [0.05] * 4,
                           'second': [0.05, 0.05, 0.05, 0.06], 'change': '+0.00 to +20.00 %'}],
            'figures': [{**row, 'verdict': 'better'}, {**row, 'figure': 'b', 'verdict': 'worse'},
                        {**row, 'figure': 'unchanged', 'verdict': 'same'}],
            'gone': [], 'new': [{'severity': 'warning', 'title': EVIL}]}


def test_a_comparison_shows_constants_and_figures_with_their_verdict(tmp_path):
    other = {**result('two'), 'comparison': comparison()}
    write_report(tmp_path / 'a.html', [result('one'), other], 'both')
    text = (tmp_path / 'a.html').read_text()
    assert EVIL not in text
    assert 'wheels.radius [m]' in text and '0.05 (all 4)' in text
    better, worse = (text.index(f'<tr class="{word}">') for word in ('better', 'worse'))
    assert '-0.1 better' in text[better:worse] and '-0.1 worse' in text[worse:]
    assert 'unchanged' not in text
    both = [{**result(), 'comparison': comparison()} for _ in range(2)]
    write_report(tmp_path / 'b.html', both, 'all')
    assert 'Comparison over 2 recordings' in (tmp_path / 'b.html').read_text()


PROBE = """<script>
// smallest distance between the buttons, the legend and the title of the axis of any figure
function apart() {
  var least = 1e9;
  document.querySelectorAll(".js-plotly-plot").forEach(function (plot) {
    var boxes = [".modebar", ".legend", ".xtick", ".xtitle"].map(function (name) {
      var found = plot.querySelector(name); return found && found.getBoundingClientRect();
    }).filter(Boolean);
    for (var i = 1; i < boxes.length; i++) {
      least = Math.min(least, boxes[i].top - boxes[i - 1].bottom);
    }
  });
  return least;
}
window.addEventListener("load", function () { setTimeout(function () {
  var lines = 0;
  document.querySelectorAll(".scatterlayer path.js-line").forEach(function (path) {
    if (path.getAttribute("d").length > 100 && path.getBoundingClientRect().width > 100) lines++;
  });
  document.body.setAttribute("data-seen", JSON.stringify({
    lines: lines, wide: document.documentElement.scrollWidth,
    paper: getComputedStyle(document.body).backgroundColor,
    text: getComputedStyle(document.querySelector(".xtitle")).fill,
    title: document.title.length, apart: apart()}));
}, 500); });</script></body>"""


def seen(folder, results, title, dark, width=500):
    """What a headless browser makes of the page, told by a script put into it."""
    write_report(folder / 'a.html', results, title)
    page = (folder / 'a.html').read_text().replace('</body>', PROBE)
    (folder / 'b.html').write_text(page)
    command = [BROWSER, '--headless', '--no-sandbox', '--disable-gpu',
               f'--blink-settings=preferredColorScheme={0 if dark else 1}',
               f'--window-size={width},900', '--virtual-time-budget=3000',
               f'--user-data-dir={folder / "profile"}', '--dump-dom',
               f'file://{folder / "b.html"}']
    dom = subprocess.run(command, capture_output=True, text=True, timeout=90, check=True).stdout
    found = re.search(r'data-seen="([^"]*)"', dom)
    assert found, 'the page did not load'
    return json.loads(html.unescape(found.group(1)))


def brightness(colour):
    return sum(int(v) for v in re.findall(r'\d+', colour)[:3]) / 3


@pytest.mark.skipif(BROWSER is None, reason='no chromium on this machine')
def test_a_phone_in_the_dark_shows_curves_runs_no_foreign_script_and_does_not_overflow(tmp_path):
    told = seen(tmp_path, [{**result(EVIL, EVIL + 'x' * 80), 'comparison': comparison()}], EVIL,
                dark=True)
    assert told['lines'] >= 4
    assert told['wide'] <= 500
    assert told['apart'] > -4, 'buttons, legend or axis title overlap'
    assert brightness(told['paper']) < 60 and brightness(told['text']) > 160
    assert told['title'] == len(EVIL), 'a script from a name has run'


@pytest.mark.skipif(BROWSER is None, reason='no chromium on this machine')
def test_a_desktop_in_the_light_has_dark_text_on_white(tmp_path):
    told = seen(tmp_path, [result()], 'run', dark=False, width=1200)
    assert told['lines'] >= 4
    assert brightness(told['paper']) > 240 and brightness(told['text']) < 80
