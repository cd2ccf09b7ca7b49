"""Checks of the encoders: resets, jumps, stuck wheels, noise, speed limits."""

from __future__ import annotations

from typing import Any

import numpy as np

from mecanum_base.bag.analysis.findings import Finding, spans_where
from mecanum_base.bag.analysis.motion import WheelMotion
from mecanum_base.core.parameter import FloatArray

_STUCK = 1.0  # s
_ABOVE = 1.5  # times max_speed, which limits commands: wheels that slip shoot beyond it
_NOISY = 2.0  # rad/s from sample to sample


def encoder_findings(topic: str, motion: WheelMotion, max_speed: FloatArray | None = None,
                     counts: FloatArray | None = None) -> list[Finding]:
    """What the wheel angles tell without any geometry; ``counts`` (W,) a turn, if known."""
    seconds, rate = motion.rates()
    found = _jumps(topic, motion, seconds, rate, max_speed)
    found += _stuck(topic, motion)
    found += _noise(topic, motion, rate, counts)
    travel = np.ptp(motion.angle, axis=0)
    if travel.max() < 0.05:
        found.append(Finding('note', 'no_motion', 'the wheels hardly move',
                             f'largest wheel travel {travel.max():.4f} rad',
                             'record a drive for findings on geometry, drift and slip', topic))
    return found


def _jumps(topic: str, motion: WheelMotion, seconds: FloatArray, rate: FloatArray,
           max_speed: FloatArray | None) -> list[Finding]:
    found: list[Finding] = []
    step = np.diff(motion.seconds)  # a stamp that comes late makes the next step too short
    rate = rate * (step / np.maximum(step, 0.7 * np.median(step)))[:, None]
    known = max_speed is not None and np.isfinite(max_speed).all()
    limit = (np.asarray(max_speed) if known
             else np.maximum(20.0 * np.percentile(np.abs(rate), 90, axis=0), 60.0))
    for wheel, joint in enumerate(motion.joints):
        before, after = motion.angle[:-1, wheel], motion.angle[1:, wheel]
        reset = (np.abs(before) > 1.0) & (np.abs(after) < 0.02 * np.abs(before)) & (
            np.abs(rate[:, wheel]) > limit[wheel])
        fast = _leaps(np.abs(rate[:, wheel]), float(limit[wheel])) & ~reset
        if reset.any():
            found.append(Finding(
                'warning', 'encoder_reset', f'{joint} starts again at zero',
                f'{int(reset.sum())} times, the first at {before[reset][0]:.1f} rad',
                'the motor controller restarted: check its supply; the step is taken as a jump '
                'and the distance of that period is lost', topic,
                tuple((float(t), float(t)) for t in seconds[reset][:20])))
        if fast.any():
            share = float(fast.mean())
            found.append(Finding(
                'warning', 'encoder_jump', f'{joint} turns faster than it can',
                f'{int(fast.sum())} steps above {limit[wheel]:.0f} rad/s, up to '
                f'{np.abs(rate[fast, wheel]).max():.0f} rad/s ({100 * share:.2f} % of all)',
                'electrical noise, lost counts or a wrong counter width '
                '(encoder.counter_bits); raise wheels.max_speed if the wheel really is that fast',
                topic, spans_where(fast, seconds)[:20],
                {'largest': float(np.abs(rate[fast, wheel]).max()), 'share': share}))
    return found


def _leaps(rate: FloatArray, limit: float) -> Any:
    """Flag (N,) of rates above the limit that are no wheel which spins on a little beyond it."""
    around = np.maximum(np.append(rate[1:], 0.0), np.insert(rate[:-1], 0, 0.0))
    return (rate > limit) & ((rate > _ABOVE * limit) | (around < 0.7 * rate))


def _stuck(topic: str, motion: WheelMotion) -> list[Finding]:
    found = []
    seconds = motion.seconds
    step = np.diff(motion.angle, axis=0)
    for wheel, joint in enumerate(motion.joints):
        for start, end in spans_where(step[:, wheel] == 0.0, seconds[1:], _STUCK):
            inside = (seconds >= start) & (seconds <= end)
            others = np.ptp(np.delete(motion.angle[inside], wheel, axis=1), axis=0)
            if len(others) and np.sort(others)[len(others) // 2] > 1.0:
                found.append((joint, start, end, float(np.median(others))))
    result = []
    for joint in motion.joints:
        spans = tuple((s, e) for j, s, e, _ in found if j == joint)
        if spans:
            total = sum(e - s for s, e in spans)
            long = total > 0.5 * float(seconds[-1])
            result.append(Finding(
                'blocker' if long else 'warning', 'encoder_stuck',
                f'{joint} stands still while the other wheels turn',
                f'{total:.1f} s in {len(spans)} stretches', 'a jammed wheel, a broken encoder '
                'cable, or a turn about that wheel', topic, spans, {'seconds': total}))
    return result


def _noise(topic: str, motion: WheelMotion, rate: FloatArray,
           counts: FloatArray | None) -> list[Finding]:
    usable = rate[np.isfinite(rate).all(axis=1)]
    if len(usable) < 20:
        return []
    rough = np.sqrt(np.median((usable[2:] - 2 * usable[1:-1] + usable[:-2]) ** 2, axis=0) / 6.0
                    / 0.4549)  # white noise of that sigma has this median square
    speed = np.sqrt(np.mean(usable**2, axis=0))
    worst = int(np.argmax(rough))
    if rough[worst] < _NOISY or rough[worst] < 0.2 * speed[worst]:
        return []
    period = float(np.median(np.diff(motion.seconds)))
    numbers = {'sigma': float(rough[worst])}
    shown = ''
    if counts is not None:
        numbers['one_count'] = 2.0 * np.pi / float(counts[worst]) / period
        shown = f'; one count a period is {numbers["one_count"]:.2g} rad/s'
    return [Finding(
        'warning', 'encoder_noise', 'wheel speeds are noisy',
        f'{motion.joints[worst]} changes by {rough[worst]:.1f} rad/s (standard deviation) from '
        f'sample to sample at {speed[worst]:.1f} rad/s rms{shown}',
        'only sums over time are useful: coarse encoder, vibration or stamps that do not belong '
        'to the counts', topic, numbers=numbers)]
