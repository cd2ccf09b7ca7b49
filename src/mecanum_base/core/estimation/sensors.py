"""Blocks ``encoder`` and ``imu`` of the robot file: how the sensors are wired and mounted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Union

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray, IntArray, frozen_floats, parameter

LATEST = 0.5  # s: stamps that are further off come from another clock, not from a delay


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class EncoderConfig:
    """Source, resolution, width and sign of the wheel encoders."""

    source: str = parameter('str', '', 'topic that carries the wheel angles',
                            default='joint_states', choices=('joint_states', 'wheel_ticks'))
    ticks_type: str = parameter('str', '', 'message type of wheel_ticks', default='auto',
                                choices=('auto', 'int32', 'int64'))
    counts_per_revolution: Union[float, FloatArray] = parameter(
        'float_or_floats', 'counts', 'counts a wheel turn: pulses x quadrature x gear reduction',
        low=0.0, open_low=True)
    counter_bits: int = parameter('int', 'bit', 'width at which the counter wraps (wheel_ticks)',
                                  default=32, choices=('16', '32', '64'))
    sign: IntArray = parameter('ints', '', '+1 or -1 a wheel, for encoders and commands alike',
                               default=())
    position_wrap: str = parameter('str', '', 'where joint_states positions wrap', default='none',
                                   choices=('none', 'two_pi'))

    def __post_init__(self) -> None:
        for index, value in enumerate(self.sign):
            if value not in (-1, 1):
                raise ConfigError(f'sign[{index}]', int(value), 'must be 1 or -1')

    def for_wheels(self, count: int) -> tuple[FloatArray, FloatArray]:
        """(counts per revolution (W,), sign (W,)); ConfigError where lengths do not fit W."""
        if len(self.sign) not in (0, count):
            raise ConfigError('sign', [int(v) for v in self.sign],
                              f'must have one entry a wheel ({count})')
        counts = np.asarray(self.counts_per_revolution, dtype=np.float64)
        if counts.ndim == 1 and len(counts) != count:
            raise ConfigError('counts_per_revolution', counts.tolist(),
                              f'must be one number or one a wheel ({count})', 'counts')
        sign = np.asarray(self.sign if len(self.sign) else np.ones(count), dtype=np.float64)
        return np.broadcast_to(counts, (count,)).copy(), sign


@dataclass(frozen=True, slots=True, eq=False)
class ImuConfig:
    """Mount of the IMU in base_link (REP-145), scale of its gyro and lateness of its stamps.

    ``late`` is taken off where messages become samples (intake, columns of a bag): the estimator
    knows moments of measurement only.
    """

    xyz: FloatArray = parameter('floats', 'm', 'position in base_link', default=(0.0, 0.0, 0.0))
    rpy: FloatArray = parameter('floats', 'rad', 'rotation base_link -> sensor, fixed axes X Y Z',
                                default=(0.0, 0.0, 0.0))
    from_tf: bool = parameter('bool', '', 'read the mount from /tf_static and record it',
                              default=False)
    gyro_scale: float = parameter('float', '', 'rate that the gyro reads over the true rate',
                                  default=1.0, low=0.5, high=2.0)
    late: float = parameter('float', 's', 'how much later than the moment of measurement the '
                            'IMU stamps; subtracted', default=0.0, low=-LATEST, high=LATEST)

    def __post_init__(self) -> None:
        for key in ('xyz', 'rpy'):
            value = getattr(self, key)
            if len(value) != 3:
                raise ConfigError(key, list(value), 'must have three entries')
            object.__setattr__(self, key, frozen_floats(value))

    @property
    def late_ns(self) -> int:
        """``late`` in ns: what messages of the IMU are stamped too late."""
        return round(1e9 * self.late)

    def base_from_sensor(self) -> FloatArray:
        """Rotation (3, 3) from sensor axes to base_link axes: Rz(yaw) Ry(pitch) Rx(roll)."""
        roll, pitch, yaw = (float(v) for v in self.rpy)
        cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
        cy, sy = math.cos(yaw), math.sin(yaw)
        return np.array([
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ])
