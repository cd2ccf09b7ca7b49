"""Checks of the clocks: rates, gaps, jitter, stamp order, delay and skew between topics."""

from __future__ import annotations

from typing import Any

import numpy as np

from mecanum_base.bag.analysis.findings import Finding
from mecanum_base.bag.analysis.recording import Recording, Series
from mecanum_base.bag.decode import IMU, JOINT_STATE, TICKS
from mecanum_base.core.parameter import FloatArray

SENSORS = (JOINT_STATE, IMU, *TICKS)
_OTHER_CLOCK = 3600.0  # s; a larger delay is another epoch, not a delay
_GAP = 1.8  # periods
_LONG_GAP = 0.2  # s: more than any estimator should have to predict over
_SKEW = 0.02  # s between topics: 1 rad/s then turns into 0.02 rad
_LATE = 0.5  # s behind the usual delay


def topic_table(recording: Recording) -> list[dict[str, Any]]:
    """One row a topic: type, count, rate [Hz], jitter [s], largest gap [s], delay [s]."""
    rows = []
    for topic, series in sorted(recording.series.items()):
        period = periods(series)
        usual = float(np.median(period)) if len(period) else float('nan')
        rows.append({
            'topic': topic, 'type': series.channel.type, 'count': len(series),
            'rate': 1.0 / usual if usual > 0.0 else None,
            'jitter': float(np.std(period)) if len(period) else None,
            'largest_gap': float(period.max()) if len(period) else None,
            'delay': float(np.median(_delay(series))) if series.stamped and len(series) else None,
            'rejected': len(series.rejected)})
    return rows


def periods(series: Series) -> FloatArray:
    """Positive steps between neighbouring stamps in order of arrival [s]."""
    step = np.diff(series.stamp_ns) / 1e9
    found: FloatArray = step[step > 0.0]
    return found


def timing_findings(recording: Recording) -> list[Finding]:
    """Everything the times of the sensor topics tell."""
    found: list[Finding] = []
    delays: dict[str, float] = {}
    for topic, series in sorted(recording.series.items()):
        if series.rejected:
            found.append(Finding(
                'warning', 'malformed', f'{topic} holds messages that cannot be read',
                f'{len(series.rejected)} messages: {sorted(set(series.rejected))[0]}',
                'check the driver that publishes them', topic))
        if series.channel.type not in SENSORS or len(series) < 5:
            continue
        if series.stamped:
            if np.all(series.stamp_ns == 0):
                found.append(Finding(
                    'blocker', 'zero_stamps', f'{topic} has no stamps',
                    'every header stamp is 0', 'let the driver set header.stamp', topic))
                continue
            found += _order(recording, topic, series)
            delays[topic] = float(np.median(_delay(series)))
            found += _delays(recording, topic, series)
        found += _gaps(recording, topic, series)
    return found + _skew(delays)


def _delay(series: Series) -> FloatArray:
    found: FloatArray = (series.log_ns - series.stamp_ns) / 1e9
    return found


def _order(recording: Recording, topic: str, series: Series) -> list[Finding]:
    step = np.diff(series.stamp_ns) / 1e9
    back, same = step < 0.0, step == 0.0
    found = []
    at = (series.log_ns[1:] - recording.origin_ns) / 1e9
    if back.any():
        found.append(Finding(
            'warning', 'stamps_step_back', f'stamps of {topic} step back',
            f'{int(back.sum())} times, by up to {-step.min() * 1e3:.1f} ms, about every '
            f'{recording.seconds / int(back.sum()):.1f} s',
            'samples that are older than the newest by more than estimator.reorder_wait are '
            'dropped; let the driver stamp from one monotonic clock', topic,
            tuple((float(t), float(t)) for t in at[back][:20]),
            {'count': float(back.sum()), 'largest': float(-step.min())}))
    if same.any():
        found.append(Finding(
            'note' if same.mean() < 0.01 else 'warning', 'equal_stamps',
            f'{topic} repeats stamps', f'{int(same.sum())} messages have the stamp of the one '
            f'before', 'duplicates are dropped', topic,
            tuple((float(t), float(t)) for t in at[same][:20]), {'count': float(same.sum())}))
    return found


def _gaps(recording: Recording, topic: str, series: Series) -> list[Finding]:
    stamps = np.sort(series.stamp_ns)
    step = np.diff(stamps) / 1e9
    positive = step[step > 0.0]
    if not len(positive):
        return []
    usual = float(np.median(positive))
    spread = 1.4826 * float(np.median(np.abs(positive - usual)))  # sigma of a normal spread
    wide = (step > _GAP * usual) & (step > usual + 8.0 * spread) & (step > usual + 0.004)
    if not wide.any():
        return []
    begin = (stamps[:-1][wide] - _stamp_origin(recording, series)) / 1e9
    # what came late is not missing: the whole time holds that many periods and no more
    owed = max(0.0, float(stamps[-1] - stamps[0]) / 1e9 / usual - (len(series) - 1))
    late = float((step[wide] / usual - 1.0).sum())
    missing = min(late, owed)
    share = missing / (len(series) + missing)
    severe = step[wide].max() > _LONG_GAP or share > 0.02
    return [Finding(
        'warning' if severe else 'note', 'gaps', f'{topic} has gaps',
        f'{int(wide.sum())} gaps of {step[wide].min() * 1e3:.0f} to {step[wide].max() * 1e3:.0f} '
        f'ms at a period of {usual * 1e3:.1f} ms; about {missing:.0f} messages '
        f'({100 * share:.1f} %) are missing' + (
            ', the others only came late' if missing < 0.5 * late else ''),
        'look for a busy computer, a full queue or a serial line at its limit', topic,
        tuple((float(b), float(b + s)) for b, s in zip(begin[:40], step[wide][:40])),
        {'count': float(wide.sum()), 'largest': float(step[wide].max()), 'share': share})]


def _stamp_origin(recording: Recording, series: Series) -> int:
    """Stamp that corresponds to the start of the recording."""
    if abs(float(np.median(_delay(series)))) > _OTHER_CLOCK:
        return int(series.stamp_ns[0])
    return recording.origin_ns


def _delays(recording: Recording, topic: str, series: Series) -> list[Finding]:
    delay = _delay(series)
    usual = float(np.median(delay))
    at = (series.log_ns - recording.origin_ns) / 1e9
    if abs(usual) > _OTHER_CLOCK:
        return [Finding(
            'note', 'other_clock', f'{topic} is stamped on another clock than the recording',
            f'stamps and log times differ by {usual:.0f} s (simulated time, or time since boot?)',
            'use one clock for all topics; wheel_ticks takes the log time', topic)]
    found = []
    if usual < -0.002 or usual > 0.25:
        what = 'ahead of' if usual < 0.0 else 'behind'
        found.append(Finding(
            'warning', 'clock_offset', f'stamps of {topic} are {what} the recorder\'s clock',
            f'arrival minus stamp is {usual * 1e3:+.0f} ms (median)',
            'synchronise the clocks of the two computers (chrony); wheel_ticks, which has no '
            'stamp, is then off by as much', topic, numbers={'offset': usual}))
    late = delay - usual > _LATE
    if late.any():
        found.append(Finding(
            'warning', 'late_messages', f'{topic} arrives late at times',
            f'{int(late.sum())} messages up to {(delay - usual).max():.2f} s later than usual',
            'the recorder or the network was busy, often at the start; leave that part out',
            topic, ((float(at[late][0]), float(at[late][-1])),),
            {'largest': float((delay - usual).max())}))
    step = np.diff(series.log_ns) / 1e9
    period = float(np.median(periods(series))) if len(periods(series)) else 0.0
    crowded = float(np.mean(step < 0.1 * period))
    if crowded > 0.05 and step.max() > 3.0 * period:
        found.append(Finding(
            'note', 'bursts', f'{topic} arrives in bursts',
            f'{100 * crowded:.0f} % of the messages come at once with the one before; pauses up '
            f'to {step.max() * 1e3:.0f} ms', 'stamps at the source keep the estimate right; log '
            'times would not', topic, numbers={'share': crowded}))
    return found


def _skew(delays: dict[str, float]) -> list[Finding]:
    usable = {t: d for t, d in delays.items() if abs(d) < _OTHER_CLOCK}
    if len(usable) < 2:
        return []
    low, high = min(usable, key=usable.__getitem__), max(usable, key=usable.__getitem__)
    skew = usable[high] - usable[low]
    if skew < _SKEW:
        return []
    return [Finding(
        'warning', 'skew', f'{high} and {low} are stamped differently',
        f'their delay between stamp and arrival differs by {skew * 1e3:.0f} ms',
        'one of them is stamped late, or by another clock; `mecanum doctor` measures the offset '
        'from the motion', high, numbers={'skew': skew})]
