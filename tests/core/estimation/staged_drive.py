"""Sensor readings of a base on rails: a staged motion and what its sensors must show.

Nothing of the code under test makes the numbers. The motion is a sequence of body twists joined by
smooth ramps, integrated at 1 kHz. Wheel rates are the textbook ones of a rectangle (source R)

    FL = (vx - vy - L wz)/r   FR = (vx + vy + L wz)/r   RL = (vx + vy - L wz)/r
    RR = (vx - vy + L wz)/r   L = half wheelbase + half track

and the IMU at lever arm l shows  v' + w x v + w' x l + w x (w x l)  and gravity, turned into its
own axes by scipy. Slip is a wheel rate added while the body keeps its motion.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from mecanum_base.core.estimation.assembly import memory_of, model_of
from mecanum_base.core.estimation.estimator import Estimator
from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.records import ImuSample, WheelSample

LX, LY, RADIUS = 0.2, 0.15, 0.05
COUNTS = 4096.0
T0 = 1_700_000_000_000_000_000  # ns, a stamp of today's size
GRAVITY = 9.81
RAMP = 0.5  # s
MS = 1_000_000
LEVER = LX + LY
RECTANGLE = np.array([[1, -1, -LEVER], [1, 1, LEVER], [1, 1, -LEVER], [1, -1, LEVER]]) / RADIUS
DIAGONAL = np.array([0.5, 0.5, 0.0]) * math.sqrt(2.0)  # 1 m/s along the rollers of FR and RL
UNLOADED_AT = 2.5  # s
GRIP = 0.2  # s in which wheels that grip again pull the base back


def rectangle(count=4, **more):
    """Four wheels FL FR RL RR, or six with a middle row (ML, MR at x = 0)."""
    rows = {4: (LX, -LX), 6: (LX, 0.0, -LX)}[count]
    x = [row for row in rows for _ in range(2)]
    y = [side for _ in rows for side in (LY, -LY)]
    roller = [math.pi / 4, -math.pi / 4, -math.pi / 4, math.pi / 4]
    if count == 6:
        roller = [*roller[:2], math.pi / 4, -math.pi / 4, *roller[2:]]
    return Wheels(joint=tuple(f'wheel_{k}' for k in range(count)), x=x, y=y,
                  axle=[math.pi / 2] * count, roller=roller, radius=[RADIUS] * count,
                  max_speed=[40.0] * count, **more)


def estimator(base=None, encoder=None, imu=None, tuning=None, smoothed=False):
    return Estimator(rectangle() if base is None else base,
                     encoder or EncoderConfig(counts_per_revolution=COUNTS),
                     imu or ImuConfig(), tuning or EstimatorConfig(), smoothed)


def at_start(base=None, tuning=None):
    """Constants and memory of the filter at its start."""
    base, tuning = rectangle() if base is None else base, tuning or EstimatorConfig()
    model = model_of(base, EncoderConfig(counts_per_revolution=COUNTS), ImuConfig(), tuning)
    return model, memory_of(base, model, tuning)


@dataclass
class Motion:
    """Columns at 1 kHz: ``t`` (N,), ``twist`` and ``rate`` of change (N, 3), ``pose`` (N, 3)."""

    t: np.ndarray
    twist: np.ndarray
    change: np.ndarray
    pose: np.ndarray

    @property
    def path(self):
        """Length of the way driven, m."""
        return float(np.hypot(self.twist[:, 0], self.twist[:, 1]).sum() * 1e-3)


def staged(*legs):
    """Motion of legs (seconds, (vx, vy, wz)), each begun with a smooth ramp of RAMP seconds."""
    total = sum(seconds for seconds, _ in legs)
    t = np.arange(round(total * 1000) + 1) * 1e-3
    twist, change = np.zeros((len(t), 3)), np.zeros((len(t), 3))
    before, begin = np.zeros(3), 0.0
    for seconds, target in legs:
        part = t >= begin - 1e-9
        u = np.clip((t[part] - begin) / RAMP, 0.0, 1.0)[:, None]
        step = np.array(target, dtype=float) - before
        twist[part] = before + step * u * u * (3.0 - 2.0 * u)
        change[part] = step * 6.0 * u * (1.0 - u) / RAMP
        before, begin = np.array(target, dtype=float), begin + seconds
    yaw = summed(twist[:, 2])
    c, s = np.cos(yaw), np.sin(yaw)
    pose = np.column_stack([summed(c * twist[:, 0] - s * twist[:, 1]),
                            summed(s * twist[:, 0] + c * twist[:, 1]), yaw])
    return Motion(t, twist, change, pose)


def summed(column):
    """Trapezoid sum of a 1 kHz column, from 0."""
    area = np.zeros(column.shape)
    area[1:] = np.cumsum(0.5e-3 * (column[1:] + column[:-1]), axis=0)
    return area


def wheel_angles(motion, rows=RECTANGLE, slip=None):
    """Angles (N, W) rad; ``slip`` {wheel: (from s, to s, added rad/s)}."""
    rates = motion.twist @ np.asarray(rows).T
    for wheel, (begin, end, added) in (slip or {}).items():
        rates[(motion.t >= begin) & (motion.t < end), wheel] += added
    return summed(rates)


def unloaded(rate, top, gain=0.0):
    """(motion, angles, end s, lost m) of a base that glides off its wheels FR and RL, then grips.

    The wheels turn for 0.5 m/s ahead, and for ``gain`` m/s^2 more all the time; the base gains
    ``rate`` m/s^2 along the rollers of that diagonal, up to ``top`` m/s, so that it gets ``lost``
    m to where the wheels do not.
    """
    end = UNLOADED_AT + top / rate + GRIP
    t = np.arange(round((end + 3.0) * 1000) + 1) * 1e-3
    speed = np.interp(t, [0.9, 1.4], [0.0, 0.5]) + gain * np.maximum(t - UNLOADED_AT, 0.0)
    claim = speed[:, None] * np.array([1.0, 0.0, 0.0])
    glide = np.interp(t, [UNLOADED_AT, end - GRIP, end], [0.0, top, 0.0])
    body = claim + glide[:, None] * DIAGONAL
    return (Motion(t, body, np.gradient(body, 1e-3, axis=0), summed(body)),
            summed(claim @ RECTANGLE.T), end, 0.5 * top * (top / rate + GRIP))


def frames(motion, angles, *, every=10, quantised=True, first=0):
    """WheelSamples each ``every`` ms from column ``first`` on."""
    unit = 2.0 * math.pi / COUNTS
    if quantised:
        angles = np.floor(angles / unit + 0.5) * unit
    blank = np.full(angles.shape[1], math.nan)
    return [WheelSample(T0 + k * MS, angles[k].copy(), blank)
            for k in range(first, len(motion.t), every)]


def imu(motion, *, every=5, xyz=(0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.0), gyro_bias=0.0,
        accel_bias=(0.0, 0.0), noise=1.0, seed=1, accel=True):
    """ImuSamples; biases along base axes; ``noise`` 1 = 2 mrad/s and 0.03 m/s^2 rms."""
    v, dv = motion.twist[::every], motion.change[::every]
    count = len(v)
    zero = np.zeros(count)
    w, dw = np.column_stack([zero, zero, v[:, 2]]), np.column_stack([zero, zero, dv[:, 2]])
    speed, rise = v.copy(), dv.copy()
    speed[:, 2] = rise[:, 2] = 0.0
    lever = np.broadcast_to(np.array(xyz, dtype=float), (count, 3))
    force = (rise + np.cross(w, speed) + np.cross(dw, lever) + np.cross(w, np.cross(w, lever)))
    force = force + np.array([*accel_bias, GRAVITY])
    rate = w + np.array([0.0, 0.0, gyro_bias])
    turn = Rotation.from_euler('xyz', rpy)  # fixed axes X Y Z
    random = np.random.default_rng(seed)
    gyro = turn.inv().apply(rate) + noise * 0.002 * random.standard_normal((count, 3))
    push = turn.inv().apply(force) + noise * 0.03 * random.standard_normal((count, 3))
    if not accel:
        push = np.full((count, 3), math.nan)
    return [ImuSample(T0 + k * every * MS, gyro[k], push[k]) for k in range(count)]


def merged(*streams):
    """All samples by stamp; of equal stamps the stream named first comes first."""
    return sorted((sample for stream in streams for sample in stream),
                  key=lambda sample: sample.stamp_ns)


def run(estimator, samples):
    """All estimates of ``samples``, the flush included."""
    found = []
    for sample in samples:
        found.extend(estimator.handle(sample))
    found.extend(estimator.flush())
    return found


def drive(motion, *, base=None, rows=RECTANGLE, slip=None, tuning=None, **sensor):
    """(estimator, estimates) of one run with both sensors."""
    mount = {key: sensor[key] for key in ('xyz', 'rpy') if key in sensor}
    subject = estimator(base, imu=ImuConfig(**mount), tuning=tuning)
    return subject, run(subject, merged(imu(motion, **sensor),
                                        frames(motion, wheel_angles(motion, rows, slip))))


def miss(estimate, motion):
    """(m, rad) between an estimate and the pose of the motion at its stamp."""
    truth = motion.pose[(estimate.stamp_ns - T0) // MS]
    return (math.hypot(*(estimate.pose[:2] - truth[:2])), abs(float(estimate.pose[2] - truth[2])))


def is_sound(estimate):
    """All finite (the ratio may be NaN), covariances symmetric and positive definite."""
    slip = estimate.slip
    numbers = [estimate.pose, estimate.twist, estimate.pose_covariance.ravel(), slip.rate,
               slip.angle, estimate.twist_covariance.ravel(), slip.probability, slip.twist,
               slip.twist_covariance.ravel(), [slip.body_probability]]
    if not np.isfinite(np.concatenate(numbers)).all() or np.isinf(slip.ratio).any():
        return False
    for matrix in (estimate.pose_covariance, estimate.twist_covariance, slip.twist_covariance):
        if not (matrix.diagonal() > 0.0).all():
            return False
        sigma = np.sqrt(matrix.diagonal())
        scale = np.outer(sigma, sigma)
        if not np.allclose(matrix, matrix.T, atol=1e-9 * scale.max(), rtol=1e-9):
            return False
        if np.linalg.eigvalsh(matrix / scale).min() < 1e-12:
            return False
    return bool(((slip.probability >= 0.0) & (slip.probability <= 1.0)).all()
                and 0.0 <= slip.body_probability <= 1.0)
