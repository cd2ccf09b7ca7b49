"""Checks that need the robot file: yaw of wheels against gyro, strafing, parity, commands."""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.bag.analysis.agreement import YawAgreement, on_grid, yaw_agreement, yaw_integral
from mecanum_base.bag.analysis.findings import Finding, spans_where
from mecanum_base.bag.analysis.motion import Gyro, WheelMotion, twist_of
from mecanum_base.bag.analysis.recording import Recording
from mecanum_base.core.kinematics.solve import body_from_wheels, parity_projector
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray

_SCALE_OFF = 0.03
_OFFSET = 0.015  # s
_PARITY_ON = 0.05  # m/s
_WINDOW = 0.3  # s


def yaw_findings(topic: str, motion: WheelMotion, gyro: Gyro,
                 row: FloatArray | None) -> tuple[list[Finding], YawAgreement | None]:
    """Wheels against gyro: offset in time, scale, sign; ``row`` (W,) of the forward matrix."""
    found = yaw_agreement(motion, gyro, row)
    free = free_wheels(topic, motion, gyro, row)
    if found is None or free:
        return free, found
    result: list[Finding] = []
    numbers = {'offset': found.offset, 'fit': found.fit, 'scale': found.scale,
               'turned': found.turned}
    shown = (f'the wheels explain {100 * found.fit:.1f} % of the gyro over '
             f'{math.degrees(found.turned):.0f} deg of turning')
    if row is not None:
        shown += f'; over the whole recording {_totals(motion, gyro, row)}'
    if found.fit < 0.6:
        return [Finding('warning', 'yaw_disagrees', 'wheels and gyro do not tell the same turn',
                        shown, 'wrong geometry, heavy slip, noise or a frozen sensor: '
                        '`mecanum doctor` looks for wiring faults', topic, numbers=numbers)], found
    if abs(found.offset) > _OFFSET and found.offset_sigma < 0.3 * abs(found.offset):
        late = 'late behind' if found.offset > 0.0 else 'ahead of'
        result.append(Finding(
            'warning', 'time_offset', f'the gyro is {late} the wheels',
            f'by {abs(found.offset) * 1e3:.0f} +- {found.offset_sigma * 1e3:.0f} ms; {shown}',
            'filters in the IMU (low-pass) and late stamping are the usual reasons: correct the '
            'stamps at the source, or let `mecanum calibrate` write imu.late', topic,
            numbers=numbers))
    if math.isfinite(found.scale):
        off = found.scale - 1.0
        if found.scale < -0.3:
            result.append(Finding('blocker', 'yaw_sign', 'wheels and gyro turn opposite ways',
                                  f'gyro = {found.scale:+.3f} x wheels; {shown}',
                                  'the IMU is upside down or the wheel table is mirrored: '
                                  '`mecanum doctor` tells which', topic, numbers=numbers))
        elif abs(off) > _SCALE_OFF and abs(off) > 3.0 * found.scale_sigma:
            result.append(Finding(
                'blocker' if not 0.5 < found.scale < 2.0 else 'warning', 'yaw_scale',
                'the wheels turn the robot by another angle than the gyro',
                f'gyro = {found.scale:.3f} +- {found.scale_sigma:.3f} x wheels; {shown}',
                f'`mecanum calibrate` fits the lever arm: about {1.0 / found.scale:.3f} times '
                f'the one of the robot file, if the gyro is right', topic, numbers=numbers))
        else:
            result.append(Finding('note', 'yaw_agrees', 'wheels and gyro agree on the yaw',
                                  f'gyro = {found.scale:.3f} +- {found.scale_sigma:.3f} x wheels; '
                                  f'{shown}', 'nothing to do', topic, numbers=numbers))
    return result, found


def _totals(motion: WheelMotion, gyro: Gyro, row: FloatArray) -> str:
    """What both turned from start to end."""
    wheels = math.degrees(float((motion.angle[-1] - motion.angle[0]) @ row))
    return (f'wheels {wheels:+.0f} deg, gyro with its bias '
            f'{math.degrees(float(yaw_integral(gyro)[-1])):+.0f} deg')


def free_wheels(topic: str, motion: WheelMotion, gyro: Gyro,
                row: FloatArray | None) -> list[Finding]:
    """The wheels run but the robot does not turn: off the floor, or a dead gyro."""
    if row is None:
        return []
    origin = int(motion.stamp_ns[0])
    stop = min(int(motion.stamp_ns[-1]), int(gyro.stamp_ns[-1])) - origin
    if stop < 2_000_000_000:
        return []
    wheels = on_grid(motion.stamp_ns, motion.angle @ row[:, None], 0.1, stop / 1e9 - 0.1,
                     origin)[:, 0]
    turn = on_grid(gyro.stamp_ns, yaw_integral(gyro), 0.1, stop / 1e9 - 0.1, origin)[:, 0]
    mean = float(np.mean(np.abs(wheels)))
    real = float(np.mean(np.abs(turn - np.median(turn))))
    if mean < 0.3 or real > 0.1 * mean:
        return []
    return [Finding('blocker', 'wheels_run_free', 'the wheels turn but the robot does not',
                    f'the wheels say {mean:.2f} rad/s of yaw on average, the gyro {real:.3f}',
                    'wheels off the floor, or a gyro that does not measure; no odometry can be '
                    'made from this', topic, numbers={'wheels': mean, 'gyro': real})]


def excitation(motion: WheelMotion, matrix: FloatArray) -> dict[str, float]:
    """Distance forward and sideways [m] and angle turned [rad], sums of sizes over 0.3 s."""
    seconds = motion.seconds
    grid = np.arange(0.0, seconds[-1], _WINDOW)
    if len(grid) < 2:
        return {'forward': 0.0, 'sideways': 0.0, 'turned': 0.0}
    angle = np.column_stack([np.interp(grid, seconds, column) for column in motion.angle.T])
    step = np.abs(np.diff(angle, axis=0) @ body_from_wheels(matrix).T)
    return {'forward': float(step[:, 0].sum()), 'sideways': float(step[:, 1].sum()),
            'turned': float(step[:, 2].sum())}


def excitation_findings(moved: dict[str, float]) -> list[Finding]:
    """Whether the drive says anything about strafing."""
    travelled = moved['forward'] + moved['sideways']
    if travelled < 0.2:
        return []
    share = moved['sideways'] / travelled
    shown = (f'forward {moved["forward"]:.2f} m, sideways {moved["sideways"]:.2f} m, '
             f'turned {math.degrees(moved["turned"]):.0f} deg')
    if share < 0.1:
        return [Finding('note', 'hardly_strafes', 'the robot hardly drives sideways', shown,
                        'a lateral scale cannot be calibrated from this recording: drive 5 m '
                        'sideways', numbers=moved)]
    return [Finding('note', 'motion', 'what was driven', shown, 'nothing to do', numbers=moved)]


def parity_findings(topic: str, motion: WheelMotion, wheels: Wheels,
                    matrix: FloatArray) -> list[Finding]:
    """What the wheels disagree on among themselves, as sliding speed along the rollers."""
    if wheels.count <= 3:
        return [Finding('note', 'no_redundancy', 'three wheels cannot contradict each other',
                        'W = 3 gives no parity equation', 'slip is seen against gyro and '
                        'accelerometer only', topic)]
    seconds = motion.seconds
    grid = np.arange(0.0, seconds[-1], _WINDOW)
    if len(grid) < 5:
        return []
    angle = np.column_stack([np.interp(grid, seconds, column) for column in motion.angle.T])
    rate = np.diff(angle, axis=0) / _WINDOW
    lever = np.abs(wheels.radius * np.sin(wheels.roller))
    sliding = np.abs(rate @ parity_projector(matrix).T) * lever
    worst = sliding.max(axis=1)
    moving = np.abs(rate).max(axis=1) * lever.max() > 0.02
    if not moving.any():
        return []
    share = float((worst > _PARITY_ON)[moving].mean())
    rms = float(np.sqrt(np.mean(worst[moving] ** 2)))
    speed = float(np.sqrt(np.mean((rate[moving] * lever) ** 2)))
    numbers = {'rms': rms, 'share': share, 'largest': float(worst.max())}
    return [Finding(
        'warning' if share > 0.2 or rms > 0.15 * speed else 'note', 'parity',
        'how much the wheels contradict each other',
        f'{rms * 1e3:.1f} mm/s rms (largest {worst.max() * 1e3:.0f}) at {speed * 1e3:.0f} mm/s '
        f'rms of wheel speed; above {_PARITY_ON * 1e3:.0f} mm/s for {100 * share:.1f} % of the '
        'time in motion', 'uneven floor, unequal radii or slip; more than 20 % of the time '
        'points at a wrong wheel table (`mecanum doctor`)', topic,
        spans_where(worst > _PARITY_ON, grid[1:], 0.3)[:30], numbers)]


def command_findings(recording: Recording, motion: WheelMotion,
                     matrix: FloatArray) -> list[Finding]:
    """Whether the wheels follow cmd_vel: delay and gain per axis."""
    series = recording.find('cmd_vel_limited') or recording.find('cmd_vel')
    if series is None or 'twist' not in series.values or len(series) < 10:
        return []
    command, times = series.values['twist'], (series.log_ns - recording.origin_ns) / 1e9
    seconds, twist = twist_of(motion, matrix)
    at = seconds + (int(motion.stamp_ns[0]) - recording.origin_ns) / 1e9
    grid = np.arange(max(times[0], at[0]), min(times[-1], at[-1]), 0.02)
    if len(grid) < 50 or not np.isfinite(command).all():
        return []
    held = command[np.clip(np.searchsorted(times, grid, side='right') - 1, 0, None)]
    real = np.column_stack([np.interp(grid, at, column) for column in twist.T])
    weight = np.array([1.0, 1.0, 0.3])
    if np.sqrt(np.mean((held * weight) ** 2)) < 0.01:
        return []
    lags = np.arange(0, min(40, len(grid) // 4))
    cost = [np.mean(((real[lag:] - held[:len(held) - lag]) * weight) ** 2) for lag in lags]
    lag = int(lags[int(np.argmin(cost))])
    asked, done = held[:len(held) - lag], real[lag:]
    gain = {}
    for axis, name in enumerate(('vx', 'vy', 'wz')):
        power = float(np.sum(asked[:, axis] ** 2))
        if np.sqrt(power / len(asked)) > 0.02:
            gain[name] = float(np.sum(asked[:, axis] * done[:, axis]) / power)
    shown = f'delay {lag * 0.02:.2f} s; ' + ', '.join(
        f'{name} {value:.2f} of what was asked' for name, value in gain.items())
    bad = [name for name, value in gain.items() if not 0.7 < value < 1.3]
    dead = gain and all(abs(value) < 0.1 for value in gain.values())
    numbers = {'delay': lag * 0.02, **gain}
    if dead:
        return [Finding('blocker', 'commands_ignored', 'the wheels do not follow the commands',
                        shown, 'is drive_node enabled, is the motor power on, does the right '
                        'topic reach the motors?', series.channel.topic, numbers=numbers)]
    if bad:
        return [Finding('warning', 'commands_missed', 'the wheels do not do what was asked',
                        shown, 'limits, a wrong sign or radius, or motors too weak',
                        series.channel.topic, numbers=numbers)]
    return [Finding('note', 'commands_followed', 'the wheels follow the commands', shown,
                    'nothing to do', series.channel.topic, numbers=numbers)]
