"""The truth in a recording: which topic it is, what it is worth, and what the wheels miss."""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.bag.analysis.drift import Track, at_stamps, has_heading, truth_track
from mecanum_base.bag.analysis.findings import Finding
from mecanum_base.bag.analysis.motion import WheelMotion
from mecanum_base.bag.analysis.recording import POSE_TYPES, TF, Recording, Series
from mecanum_base.core.errors import BagError
from mecanum_base.core.kinematics.solve import body_from_wheels
from mecanum_base.core.parameter import FloatArray

_NAMES = ('ground_truth', 'groundtruth', 'truth', 'mocap', 'optitrack', 'vicon', 'vrpn',
          'qualisys', 'gt_pose', 'laser_tracker')
_WINDOW = 0.5  # s
_SCALE_OFF = 0.01
_UNCLEAR = 0.06  # three standard deviations of a scale that says nothing


def truth_series(recording: Recording, topic: str | None) -> Series | None:
    """The topic with the truth: as named, or by its name; None if there is none.

    Raises BagError where the named topic is absent or has no poses. Of /tf only transforms of the
    base count.
    """
    if topic:
        found = recording.find(topic)
        if found is None:
            raise BagError(f'{", ".join(recording.paths)}: no topic {topic}')
        if found.channel.type not in POSE_TYPES or 'pose' not in found.values:
            raise BagError(f'topic {topic} of type {found.channel.type} holds no poses')
        return found
    for series in recording.of_type(*POSE_TYPES):
        name = series.channel.topic.lower()
        if any(word in name for word in _NAMES) and len(series) >= 3 and 'slip' not in name:
            return series
    return None


def track_of(series: Series, frame: str | None = None) -> Track | None:
    """The poses of a topic in order of stamp; of /tf the commonest parent frame (or ``frame``)."""
    pose = series.values.get('pose')
    if pose is None or len(series) < 3 or pose.shape[1:] != (3,):
        return None
    chosen = np.ones(len(series), dtype=bool)
    if series.channel.type == TF:
        frames = [str(f) for f in series.values['frame']]
        usual = frame or max(set(frames), key=frames.count)
        chosen = np.array([f.lstrip('/') == usual.lstrip('/') for f in frames])
    track = truth_track(series.stamp_ns[chosen], pose[chosen])
    return track if len(track.stamp_ns) >= 3 else None


def truth_findings(topic: str, truth: Track) -> list[Finding]:
    """What the truth itself is worth: repeated positions, no heading."""
    found = []
    moving = np.hypot(*np.diff(truth.pose[:, :2], axis=0).T)
    same = (np.diff(truth.pose, axis=0) == 0.0).all(axis=1)
    travel = float(moving.sum())
    window = max(3, len(same) // 100)
    active = np.convolve(moving, np.ones(window) / window, 'same') > 0.2 * moving.mean()
    if travel > 0.05 and active.any() and (share := float(same[active].mean())) > 0.02:
        found.append(Finding(
            'note', 'truth_repeats', 'the truth repeats positions',
            f'{100 * share:.0f} % of its messages in motion equal the one before',
            'its source is slower than its messages; errors over short distances are coarser '
            'than they look', topic, numbers={'share': share}))
    if not has_heading(truth, 1.0):
        found.append(Finding(
            'note', 'truth_without_heading', 'the truth has no heading',
            'its yaw never changes', 'tracks are compared after the best rotation, yaw errors '
            'are not given', topic))
    return found


def scale_findings(motion: WheelMotion, matrix: FloatArray, truth: Track) -> list[Finding]:
    """Scale of the wheel odometry per axis against the truth, over windows of half a second."""
    scale = axis_scales(motion, matrix, truth)
    if scale is None:
        return []
    off = {name: value for name, (value, sigma) in scale.items()
           if abs(value - 1.0) > max(_SCALE_OFF, 3.0 * sigma)}
    numbers = {name: value for name, (value, _) in scale.items()}
    shown = ', '.join(f'{name}: truth = {value:.3f} +- {sigma:.3f} x wheels'
                      for name, (value, sigma) in scale.items())
    if not off and any(3.0 * sigma > _UNCLEAR for _, sigma in scale.values()):
        return [Finding('note', 'scales_unclear', 'distances of wheels and truth hardly compare',
                        shown, 'a longer drive or a better reference would tell', numbers=numbers)]
    if not off:
        return [Finding('note', 'scales_agree', 'the wheels measure distances as the truth does',
                        shown, 'nothing to do', numbers=numbers)]
    large = any(abs(value - 1.0) > 0.15 for value in off.values())
    return [Finding(
        'warning', 'scales_off', 'the wheels measure other distances than the truth', shown,
        '`mecanum calibrate` fits radius, lateral scale and lever arm'
        + ('; 15 % or more means slip or a wrong constant' if large else ''), numbers=numbers)]


def axis_scales(motion: WheelMotion, matrix: FloatArray,
                truth: Track) -> dict[str, tuple[float, float]] | None:
    """{'forward', 'sideways', 'turning': (scale, sigma)} by least squares; None without both.

    An axis is left out where it carries less than a tenth of the motion.
    """
    start = max(int(motion.stamp_ns[0]), int(truth.stamp_ns[0]))
    stop = min(int(motion.stamp_ns[-1]), int(truth.stamp_ns[-1]))
    grid = np.arange(start, stop, int(_WINDOW * 1e9))
    if len(grid) < 8:
        return None
    real = at_stamps(truth, grid)
    heading = has_heading(truth, 1.0)
    seconds, at = motion.seconds, (grid - int(motion.stamp_ns[0])) / 1e9
    angle = np.column_stack([np.interp(at, seconds, column) for column in motion.angle.T])
    wheels = np.diff(angle, axis=0) @ body_from_wheels(matrix).T
    step = np.diff(real, axis=0)
    if heading:
        middle = real[:-1, 2] + step[:, 2] / 2.0
        chord = np.sinc(step[:, 2] / (2.0 * math.pi))  # straight line over arc of a turn
        c, s = np.cos(middle), np.sin(middle)
        body = np.column_stack([(c * step[:, 0] + s * step[:, 1]) / chord,
                                (-s * step[:, 0] + c * step[:, 1]) / chord, step[:, 2]])
        pairs = [('forward', 0), ('sideways', 1), ('turning', 2)]
    else:
        body = np.column_stack([np.hypot(step[:, 0], step[:, 1])] * 3)
        wheels = np.column_stack([np.hypot(wheels[:, 0], wheels[:, 1])] * 3)
        pairs = [('distance', 0)]
    found = {}
    travel = np.abs(wheels).sum(axis=0)
    for name, axis in pairs:
        least = 0.3 if name == 'turning' else 0.1 * max(travel[0], travel[1], 1.0)
        if travel[axis] < least:
            continue
        x, y = wheels[:, axis], body[:, axis]
        power = float(x @ x)
        value = float(x @ y) / power
        rest = y - value * x
        found[name] = (value, float(np.sqrt(np.sum((rest * x) ** 2)) / power))
    return found or None
