"""The page of `mecanum analyze`: complete in itself, escaped, and drawn by a real browser."""

import pathlib
import re
import shutil
import struct
import subprocess
import zlib

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


def pixels(path):
    """(height, width, 3) of an 8-bit RGB or RGBA PNG, by the standard alone."""
    data = path.read_bytes()
    width, height, depth, kind = struct.unpack('>IIBB', data[16:26])
    assert depth == 8 and kind in (2, 6)
    count, at, packed = (3 if kind == 2 else 4), 8, b''
    while at < len(data):
        size, name = struct.unpack('>I4s', data[at:at + 8])
        if name == b'IDAT':
            packed += data[at + 8:at + 8 + size]
        at += 12 + size
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * count)
    out = np.zeros((height, width, count), np.uint8)
    for y in range(height):
        row = raw[y, 1:].reshape(width, count).astype(int)
        up = out[y - 1].astype(int) if y else np.zeros((width, count), int)
        if raw[y, 0] == 0:
            out[y] = row
        elif raw[y, 0] == 1:
            out[y] = np.cumsum(row, axis=0) % 256
        elif raw[y, 0] == 2:
            out[y] = (row + up) % 256
        else:
            left = np.zeros(count, int)
            corner = np.zeros(count, int)
            for x in range(width):
                if raw[y, 0] == 3:
                    guess = (left + up[x]) // 2
                else:
                    p = left + up[x] - corner
                    a, b, c = abs(p - left), abs(p - up[x]), abs(p - corner)
                    guess = np.where((a <= b) & (a <= c), left, np.where(b <= c, up[x], corner))
                left = (row[x] + guess) % 256
                out[y, x] = left
                corner = up[x]
    return out[:, :, :3]


def shot(page, target, width, dark):
    command = [BROWSER, '--headless', '--no-sandbox', '--disable-gpu', '--hide-scrollbars',
               f'--blink-settings=preferredColorScheme={0 if dark else 1}',
               f'--window-size={width},1500', '--virtual-time-budget=3000',
               f'--user-data-dir={target.parent / "profile"}', f'--screenshot={target}',
               f'file://{page}']
    subprocess.run(command, capture_output=True, timeout=90, check=True)
    return pixels(target)


@pytest.mark.skipif(BROWSER is None, reason='no chromium on this machine')
@pytest.mark.parametrize('width, dark', [(500, True)])
def test_a_browser_draws_it_on_a_phone_in_the_dark(tmp_path, width, dark):
    data = result(EVIL)
    data['findings'] = []  # plots come into view
    write_report(tmp_path / 'a.html', [data], 'run')
    image = shot(tmp_path / 'a.html', tmp_path / 'shot.png', width, dark)
    assert image.shape[1] == width
    background = image[:, :4].reshape(-1, 3).mean()
    assert background < 60 if dark else background > 240
    blue = (image[:, :, 2].astype(int) - image[:, :, 0] > 100).sum()  # the first line's colour
    assert blue > 200, 'no curve was drawn'


@pytest.mark.skipif(BROWSER is None, reason='no chromium on this machine')
def test_scripts_in_names_do_not_run_and_nothing_overflows_a_phone(tmp_path):
    write_report(tmp_path / 'a.html', [result(EVIL, EVIL + 'x' * 80)], EVIL)
    page = (tmp_path / 'a.html').read_text()
    probe = ('<script>window.addEventListener("load", function () { setTimeout(function () {'
             'document.body.setAttribute("data-wide", document.documentElement.scrollWidth);'
             '}, 500); });</script></body>')
    (tmp_path / 'b.html').write_text(page.replace('</body>', probe))
    command = [BROWSER, '--headless', '--no-sandbox', '--disable-gpu', '--window-size=500,800',
               '--virtual-time-budget=3000', f'--user-data-dir={tmp_path / "profile"}',
               '--dump-dom', f'file://{tmp_path / "b.html"}']
    dom = subprocess.run(command, capture_output=True, text=True, timeout=90, check=True).stdout
    assert '<title>broken</title>' not in dom
    wide = re.search(r'data-wide="(\d+)"', dom)
    assert wide and int(wide.group(1)) <= 500
    assert pathlib.Path(tmp_path / 'b.html').exists()
