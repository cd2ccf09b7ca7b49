"""Wiring faults of a robot from a recording: named with the corrected lines and how sure.

The doctor claims a fault only where one explanation carries at least 90 % of the probability, and
asks for another drive where the motion does not tell (R: the 81 combinations show which manoeuvre
separates which wheels).
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from mecanum_base.bag.analysis.agreement import yaw_agreement
from mecanum_base.bag.analysis.drift import Track
from mecanum_base.bag.analysis.imu_mount import BRISKLY
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.bag.analysis.wheel_gain import wheel_gain
from mecanum_base.bag.analysis.wheel_lines import listed
from mecanum_base.bag.analysis.wiring_commands import gain_text
from mecanum_base.bag.analysis.wiring_faults import (
    Diagnosis,
    describe,
    faults_of,
    look_at,
    tilt_of,
    wheel_scale,
)
from mecanum_base.bag.analysis.wiring_prices import PRICE, SOUND
from mecanum_base.bag.analysis.wiring_search import DEGREES, Wiring, forward_of, search
from mecanum_base.bag.analysis.wiring_signals import Signals, signals_of
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.robot import Robot

CERTAIN, LIKELY = 0.9, 0.6
_WORTH = 0.05  # of the probability: what is named where nothing is likely
_OFFSET = 0.02
_EXPLAINED = 0.4  # of the gyro by any combination of the wheels
_POOR = 0.02  # m/s rms of motion of any kind
_WOULD = ('an accelerometer or a true pose in the recording would, and cmd_vel if only the '
          'encoders are wired otherwise')


@dataclass(slots=True)
class Verdict:
    """All diagnoses; ``missing``: manoeuvres without which nothing can be said of something;
    ``unclear``: explanations that the recording cannot tell apart."""

    diagnoses: list[Diagnosis] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    unclear: list[str] = field(default_factory=list)
    checked: list[str] = field(default_factory=list)

    def plain(self) -> dict[str, Any]:
        """As JSON values."""
        return asdict(self)


def examine(robot: Robot, motion: WheelMotion, gyro: Gyro | None, truth: Track | None = None,
            command: Track | None = None) -> Verdict:
    """Examine one recording; ``gyro`` in sensor axes, ``motion`` read as the robot file says.

    ``truth``: poses; ``command``: twists that were asked for, a full witness where there is no
    gyro, else a weak one (wiring_search.py).
    """
    verdict = Verdict()
    assert isinstance(robot.base, Wheels)
    _file_plausible(robot.base, verdict)
    late = _time_offset(robot, motion, gyro, verdict)
    signals = signals_of(motion, gyro, truth, command, late)
    if signals is None:
        verdict.missing.append('the recording is too short: drive for at least ten seconds')
        return verdict
    _accel_unit(signals, verdict)
    if gyro is None and signals.witness is None:
        verdict.missing.append('there is neither an IMU nor a true pose nor cmd_vel that the '
                               'wheels follow: only contradictions among the wheels can be seen')
    if not _moves(robot.base, signals, verdict):
        return verdict
    if signals.commanded:
        verdict.missing.append(
            'commands alone do not show what motors and encoders have in common: a wrong order, '
            'sign or scale of both looks right; record an IMU with them')
    if any(d.fault == 'millimetres' for d in verdict.diagnoses):
        verdict.missing.append('correct the millimetres first, then ask again')
        return verdict
    if (share := _explained(signals)) < _EXPLAINED:
        verdict.missing.append(
            f'wheels and gyro hardly tell the same motion (the best combination of the wheels '
            f'explains {100 * share:.0f} % of the turning): noisy wheel speeds, wheels in the '
            'air, heavy slip or a sensor that hangs; nothing can be said of the wiring')
        return verdict
    gain = wheel_gain(signals, robot.base)
    found = search(signals, robot.base, robot.imu.base_from_sensor(),
                   robot.encoder.for_wheels(robot.base.count)[1])
    if gain is not None and gain.cost < found[0].cost - math.log(CERTAIN / (1 - CERTAIN)):
        verdict.diagnoses.append(wheel_scale(robot, gain.wheel, gain.factor, gain.certainty))
        return verdict
    _wiring(robot, motion, signals, found, verdict)
    return verdict


def _file_plausible(wheels: Wheels, verdict: Verdict) -> None:
    """Millimetres where metres are meant show in the file itself."""
    for key, values, most in (('radius', wheels.radius, 1.0), ('x', wheels.x, 5.0),
                              ('y', wheels.y, 5.0)):
        if float(np.abs(values).max()) > most:
            verdict.diagnoses.append(Diagnosis(
                'millimetres', f'wheels.{key} is in millimetres',
                (f'{key}: {listed(values / 1000.0)}',), 0.99,
                f'largest value {float(np.abs(values).max()):g} m'))


def _accel_unit(signals: Signals, verdict: Verdict) -> None:
    """1 at rest instead of 9.81."""
    if signals.up_rested and 0.8 < signals.up_size < 1.2:
        verdict.diagnoses.append(Diagnosis(
            'accel_in_g', 'the accelerometer is in g',
            ('multiply linear_acceleration by 9.80665 in the driver (REP-145)',), 0.99,
            f'its reading at rest has the size {signals.up_size:.3f}'))


def _time_offset(robot: Robot, motion: WheelMotion, gyro: Gyro | None,
                 verdict: Verdict) -> float:
    """Offset of the gyro's stamps, found without any geometry on its liveliest axis."""
    if gyro is None:
        return 0.0
    spread = np.nanstd(gyro.rate, axis=0)
    axis = int(np.argmax(spread))
    column = gyro.rate[:, axis]
    scale = DEGREES if float(np.nanmax(np.abs(column))) > 35.0 else 1.0
    single = Gyro(gyro.stamp_ns, np.column_stack([column / scale] * 3), gyro.accel)
    found = yaw_agreement(motion, single)
    if found is None or found.fit < 0.8 or not math.isfinite(found.offset_sigma):
        return 0.0
    verdict.checked.append(f'time offset of the IMU: {found.offset * 1e3:+.0f} +- '
                           f'{found.offset_sigma * 1e3:.0f} ms')
    if abs(found.offset) < _OFFSET or abs(found.offset) < 4.0 * found.offset_sigma:
        return 0.0
    verdict.diagnoses.append(Diagnosis(
        'time_offset', f'the IMU is stamped {abs(found.offset) * 1e3:.0f} ms '
        f'{"late" if found.offset > 0 else "early"}',
        (f'late: {robot.imu.late + found.offset:.4f}', 'under imu, or correct the stamps in the '
         'driver of the IMU'), 0.97,
        f'{found.offset * 1e3:+.1f} +- {found.offset_sigma * 1e3:.1f} ms, '
        f'the wheels then explain {100 * found.fit:.1f} % of the gyro'))
    return found.offset


def _moves(wheels: Wheels, signals: Signals, verdict: Verdict) -> bool:
    """Whether the motion is rich enough; says what is missing."""
    lever = float(np.mean(wheels.radius * np.abs(np.sin(wheels.roller))))
    lever = lever / 1000.0 if lever > 1.0 else lever
    rates = signals.wheel * lever
    power = np.linalg.svd(rates / math.sqrt(len(rates)), compute_uv=False)
    if power[0] < _POOR:
        verdict.missing.append('not enough motion: drive 1 m forward, 1 m sideways, and turn once '
                               'around')
        return False
    if power[min(2, len(power) - 1)] < max(_POOR, 0.05 * float(power[0])):
        verdict.missing.append(
            'not enough kinds of motion: the wheels ran in '
            f'{int(np.sum(power > max(_POOR, 0.05 * float(power[0]))))} of the 3 ways that '
            'tell wheels apart; drive forward, sideways and turn, in one recording')
        return False
    return True


def _explained(signals: Signals) -> float:
    """Share of the gyro's liveliest axis that some combination of the wheels explains; 1 without
    a gyro."""
    if signals.gyro is None:
        return 1.0
    rate = signals.gyro[:, int(np.argmax(np.var(signals.gyro, axis=0)))]
    rest = rate - signals.wheel @ np.linalg.lstsq(signals.wheel, rate, rcond=None)[0]
    return 1.0 - float(rest @ rest) / max(float(rate @ rate), 1e-12)


def _wiring(robot: Robot, motion: WheelMotion, signals: Signals, found: list[Wiring],
            verdict: Verdict) -> None:
    """Turn the probabilities of the search into diagnoses."""
    wheels = robot.base
    assert isinstance(wheels, Wheels)
    sure: dict[tuple[object, ...], float] = {}
    for wiring in found:
        sure[wiring.key] = sure.get(wiring.key, 0.0) + wiring.probability
    best = max(found, key=lambda w: (sure[w.key], -w.cost))
    certainty = sure[best.key]
    verdict.checked.append(f'{wheels.count} wheels, rollers, mounting: best explanation carries '
                           f'{100 * certainty:.1f} %')
    ranked = sorted(sure, key=lambda key: -sure[key])
    first = {wiring.key: wiring for wiring in reversed(found)}
    others = [first[key] for key in ranked if key != best.key]
    if certainty < LIKELY:
        shown = [best, *(w for w in others[:4] if sure[w.key] >= _WORTH)]
    else:
        verdict.diagnoses += faults_of(robot, signals, best, min(certainty, 0.99))
        shown = others[:1] if certainty < CERTAIN else []
    verdict.unclear += [f'{100 * sure[w.key]:.0f} %: {describe(robot, w)}' for w in shown]
    if shown:
        verdict.missing.append(_what_tells(robot, signals, best, others[0]))
    if certainty >= LIKELY:
        verdict.missing += _alike(robot, signals, found, best)
        if text := gain_text(signals, forward_of(wheels, best)):
            verdict.missing.append(text)
        verdict.diagnoses += tilt_of(robot, signals, best)


def _what_tells(robot: Robot, signals: Signals, one: Wiring, other: Wiring) -> str:
    """How to decide between two explanations."""
    if signals.accel is None:
        return f'which of these: the gyro alone does not tell; {_WOULD}'
    if one.mount == other.mount or abs(one.cost - one.price - other.cost + other.price) > 1.0:
        return f'which of these for certain: {BRISKLY}'
    known = ('the recorded commands do not tell' if signals.asked is not None else
             'so does cmd_vel if only the encoders are wired otherwise')
    return ('which of these: it is one and the same base, seen from another side, and no wheel, '
            f'gyro or accelerometer tells where its front is. {look_at(robot, one, other)}. A '
            f'true pose in the recording tells too; {known}')


def _alike(robot: Robot, signals: Signals, found: list[Wiring], best: Wiring) -> list[str]:
    """Single mistakes that would look like a robot file that is right."""
    if not best.sound:
        return []
    told = best.cost + SOUND + math.log(CERTAIN / (1.0 - CERTAIN))
    twins = [w for w in found if 0.0 < w.price < 2.0 * PRICE and w.cost - w.price < told]
    if not twins:
        return []
    tells = (f'the gyro alone does not tell; {_WOULD}' if signals.accel is None else
             f'{BRISKLY}: the accelerometer tells then')
    return [f'this would look the same: {describe(robot, w)}; {tells}' for w in twins[:3]]
