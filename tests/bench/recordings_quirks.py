"""What is known of the real recordings, and which finding of `mecanum analyze` must show it.

A quirk names its runs (glob), what the README of the data says, and a check on one result that
gives the measured text, or None where it is missed.
"""

from __future__ import annotations

import math
from fnmatch import fnmatch
from typing import NamedTuple


class Quirk(NamedTuple):
    """``only``: the finding must be absent in all other runs of the set; ``count``: in how many
    of the runs it is known to be (default: all)."""

    runs: str
    known: str
    check: object
    only: bool = False
    count: int | None = None


def finding(result, code, topic=None):
    """The first finding of a code, or None."""
    return next((f for f in result['findings'] if f['code'] == code
                 and (topic is None or f['topic'].lstrip('/') == topic)), None)


def has(code, number=None, unit='', factor=1.0, topic=None, low=-math.inf, high=math.inf):
    """A check: the finding is there, and its number lies between low and high (in the unit)."""
    def check(result):
        found = finding(result, code, topic)
        if found is None:
            return None
        if number is None:
            return 'yes'
        value = found['numbers'][number] * factor
        return f'{value:.3g} {unit}'.strip() if low <= value <= high else None
    return check


def scale(axis, low, high):
    """A check: the scale of truth over wheels that any of the scale findings gives."""
    def check(result):
        for code in ('scales_off', 'scales_agree', 'scales_unclear'):
            found = finding(result, code)
            if found and axis in found['numbers']:
                value = found['numbers'][axis]
                return f'{value:.3f}' if low <= value <= high else None
        return None
    return check


def says(code, text, shown='yes', topic=None):
    """A check: the evidence of a finding holds the text."""
    def check(result):
        found = finding(result, code, topic)
        return shown if found and text in found['evidence'] else None
    return check


def absent(*codes):
    """A check: none of the findings is claimed."""
    return lambda result: None if any(finding(result, c) for c in codes) else 'not claimed'


def rest_first(low, high):
    def check(result):
        found = finding(result, 'gyro_bias')
        if not found or not found['spans']:
            return None
        end = found['spans'][0][1]
        return f'{end:.1f} s' if low <= end <= high else None
    return check


def travelled(low, high):
    """A check: way of the truth over way of the wheels, both axes together."""
    def check(result):
        for code in ('scales_off', 'scales_agree', 'scales_unclear'):
            found = finding(result, code)
            if found:
                moved, numbers = result['motion'], found['numbers']
                axes = [a for a in ('forward', 'sideways') if a in numbers]
                value = (math.hypot(*(moved[a] * numbers[a] for a in axes))
                         / math.hypot(*(moved[a] for a in axes)))
                return f'{value:.3f}' if low <= value <= high else None
        return None
    return check


QUIRKS = {
    'kobuki_slip_labels': (
        Quirk('nonfaulty', 'stamps ahead of arrival by 53 ms', has(
            'clock_offset', 'offset', 'ms', 1e3, 'joint_states', -60, -45)),
        Quirk('left_faulty', 'stamps ahead of arrival by 484 ms', has(
            'clock_offset', 'offset', 'ms', 1e3, 'joint_states', -495, -475)),
        Quirk('*', 'arrival late in the first seconds (0.8 s on stamped topics)', has(
            'late_messages', 'largest', 's', 1.0, 'joint_states', 0.7, 0.9)),
        Quirk('*', 'messages arrive in bursts', has('bursts')),
        Quirk('*', 'ticks (no stamp) pause and catch up', says(
            'gaps', 'only came late', topic='wheel_ticks')),
        Quirk('*', 'IMU stamps step back once a second, by up to 11 ms', has(
            'stamps_step_back', 'largest', 'ms', 1e3, 'imu/data_raw', 8, 12)),
        Quirk('*', 'gyro 70 to 100 ms behind the wheels', has(
            'time_offset', 'offset', 'ms', 1e3, low=70, high=100)),
        Quirk('*', 'gyro bias -0.0100 and -0.0104 rad/s', has(
            'gyro_bias', 'z', 'rad/s', low=-0.0107, high=-0.0098)),
        Quirk('*', 'rest of 7.7 and 7.9 s at the start', rest_first(7.0, 8.2)),
        Quirk('*', 'no accelerometer', has('no_accelerometer'))),
    'maverick_omni3_imu': (
        Quirk('exp5', 'IMU repeats itself for 1.83 s while turning', has(
            'imu_frozen', 'seconds', 's', low=1.75, high=1.9), only=True),
        Quirk('exp5', 'late rows, gaps to 60 ms', has(
            'gaps', 'largest', 'ms', 1e3, 'joint_states', 55, 65), only=True),
        Quirk('exp5', 'two rows with the same time', has(
            'equal_stamps', 'count', topic='joint_states', low=1, high=1), only=True),
        Quirk('*', 'wheel speeds very noisy', has('encoder_noise', 'sigma', 'rad/s')),
        Quirk('*', 'one count in a row is 2.38 rad/s', has(
            'encoder_noise', 'one_count', 'rad/s', low=2.37, high=2.39)),
        Quirk('exp1', 'single speeds of 100 to 380 rad/s', has(
            'encoder_jump', 'largest', 'rad/s', low=100)),
        Quirk('exp?', 'vibration of 1.8 to 2.3 m/s2', has(
            'vibration', 'rms', 'm/s2', low=1.5, high=2.6), only=True),
        Quirk('motor_*', 'wheels turn in the air', has('wheels_run_free', 'wheels', 'rad/s'),
              only=True),
        Quirk('*', 'gravity already removed', has('gravity_removed')),
        Quirk('*', 'no gyro about x and y', has('gyro_axis_constant')),
        Quirk('*', 'moves from the first row on', has('no_rest')),
        Quirk('exp?', 'the video has no heading', has('truth_without_heading')),
        Quirk('exp[12]', 'video way 0.83 to 0.84 of the wheels', scale('distance', 0.78, 0.88)),
        Quirk('exp[12]', 'wheel yaw 197/142 deg, sensor 204/186 deg', has('yaw_disagrees'))),
    'optiodom_omni4_mecanum': (
        Quirk('*run-0[1-4]', 'way forward 1.03 of nominal', scale('forward', 1.015, 1.04)),
        Quirk('*run-07', 'sideways 4 to 5 % shorter than forward', scale('sideways', 0.965, 0.99)),
        Quirk('*run-10', 'the same, counter-clockwise', scale('sideways', 0.965, 0.99)),
        Quirk('circular*', 'lx + ly larger than nominal: less yaw', scale(
            'turning', 0.94, 0.975)),
        Quirk('*run-0[1-4]', 'no lateral scale to be had from these', has('hardly_strafes'),
              only=True),
        Quirk('*', 'slow and even: no slip', absent('slip', 'wheels_doubted')),
        Quirk('*', 'no IMU', has('no_imu'))),
    'as logged': (
        Quirk('circular*', 'counts of 6 % of the rows lost', scale('forward', 1.06, 1.11)),
        Quirk('square*', 'counts of 10 % of the rows lost', scale('forward', 1.10, 1.16))),
    'optiodom_omni3': (
        Quirk('*', 'no redundancy: no slip can be claimed', has('slip_unseen')),
        Quirk('joystick*', 'way 0.960 of nominal', scale('forward', 0.94, 0.99)),
        Quirk('square*', 'way 0.960 of nominal', travelled(0.94, 0.99)),
        Quirk('joystick*', 'arm 0.191 of 0.195 m: yaw 0.98 of nominal', scale(
            'turning', 0.97, 0.99)),
        Quirk('circular*', 'no set of constants suits every way of driving', travelled(0.9, 1.01)),
        Quirk('*', 'no IMU', has('no_imu'))),
    'robotino_omni3_slip': (
        Quirk('*', '8 to 10 % of the camera positions repeat', has(
            'truth_repeats', 'share', '%', 100.0, low=4, high=14)),
        Quirk('*', 'six gaps of 60 to 250 ms in all files', has(
            'gaps', 'largest', 'ms', 1e3, 'joint_states', 60, 250), count=6),
        Quirk('*', 'nothing on board shows slip at constant speed', has('slip_unseen')),
        Quirk('one_surface_table*', 'smooth table: way 0.91 of the wheels', travelled(0.87, 0.95)),
        Quirk('one_surface_brown*', 'brown: 0.87', travelled(0.80, 0.91)),
        Quirk('one_surface_gray*', 'gray: 0.71 to 0.72 +- 0.05', travelled(0.6, 0.82)),
        Quirk('one_surface_green*', 'green mat: 0.48 to 0.53 +- 0.09', travelled(0.35, 0.70)),
        Quirk('two_surfaces_table_gray*', 'half on each: 0.79 to 0.87', travelled(0.6, 0.95)),
        Quirk('two_surfaces_green_table*', 'half on each: 0.58 to 0.66', travelled(0.4, 0.85))),
}

# warnings and blockers that are right there, and why; any other one is listed as unexplained
TRUE = {
    'kobuki_slip_labels': {
        'clock_offset': 'two computers', 'late_messages': 'start of the recorder',
        'stamps_step_back': 'in the data', 'time_offset': 'in the data',
        'gaps': 'pauses of up to 0.43 s in the arrival of ticks, which have no stamp'},
    'maverick_omni3_imu': {
        'wheels_run_free': 'motor test', 'imu_frozen': 'exp5', 'gaps': 'exp5',
        'encoder_jump': 'spikes of the logged speed', 'encoder_noise': 'in the data',
        'gravity_removed': 'in the data', 'vibration': 'in the data',
        'scales_off': 'doubtful geometry: video 0.83 of the wheels',
        'yaw_disagrees': 'noise of the wheels, heading frozen in exp5',
        'wheels_doubted': 'noise and doubtful geometry; motor test: wheels in the air',
        'drift': 'against a video good to some centimetres'},
    'optiodom_omni4_mecanum': {'scales_off': 'nominal constants are wrong by 2 to 5 %',
                               'drift': '5 to 6 % of the way in one run'},
    'as logged': {'scales_off': 'lost rows', 'drift': 'lost rows'},
    'optiodom_omni3': {'scales_off': 'nominal constants are wrong by 1 to 9 %'},
    'robotino_omni3_slip': {
        'scales_off': 'slip, and a camera scale in doubt', 'drift': 'slip', 'gaps': 'in the data',
        'encoder_noise': 'steps of counts alternate: read at other times than the rows say',
        'encoder_jump': 'exp25 on table and gray: the third counter jumps by 9824 at the start'},
}


def quirk_rows(name, results):
    """[expected, runs, found in, measured] and the number of missed or false ones."""
    rows, wrong = [], 0
    for quirk in QUIRKS[name]:
        own = {run: quirk.check(result) for run, result in results.items()
               if fnmatch(run, quirk.runs)}
        hits = {run: text for run, text in own.items() if text is not None}
        false = [run for run, result in results.items() if quirk.only and run not in own
                 and quirk.check(result) is not None]
        known = len(own) if quirk.count is None else quirk.count
        rows.append([quirk.known, quirk.runs, f'{len(hits)} of {known}'
                     + (f', false in {len(false)}' if false else ''),
                     _range(list(hits.values())) if hits else 'MISSED'])
        wrong += len(false) + abs(known - len(hits))
    return rows, wrong


def _range(texts):
    """One text for all, or the range of their numbers with the unit."""
    parts = [text.split(' ', 1) for text in texts]
    try:
        numbers = sorted(float(part[0]) for part in parts)
    except ValueError:
        return texts[0]
    unit = ''.join(f' {word}' for word in parts[0][1:])
    low, high = f'{numbers[0]:.3g}', f'{numbers[-1]:.3g}'
    return f'{low}{unit}' if low == high else f'{low} to {high}{unit}'


def warning_rows(name, results):
    """[finding, runs, why it is true or 'unexplained'] of all warnings and blockers."""
    runs = {}
    for run, result in results.items():
        for found in result['findings']:
            if found['severity'] != 'note':
                runs.setdefault((found['severity'], found['code']), set()).add(run)
    return [[f'{severity}: {code}', f'{len(where)} of {len(results)}',
             TRUE[name].get(code, '**unexplained**')]
            for (severity, code), where in sorted(runs.items())]
