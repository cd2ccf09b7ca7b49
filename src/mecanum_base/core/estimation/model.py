"""What the kernels only read: geometry, noise and hypotheses of one robot as plain numbers."""

from __future__ import annotations

from typing import NamedTuple

from mecanum_base.core.parameter import FloatArray


class Model(NamedTuple):
    """Constants of the filter; W wheels, M slip hypotheses. Lengths in m, angles in rad, SI."""

    wheels: int
    lever_x: float
    lever_y: float
    imu_gap: float  # s without IMU after which it counts as lost
    # process noise: power spectral densities are squares of these
    gyro_noise: float  # rad/s/rtHz
    gyro_shake: float  # rad/s/rtHz per m/s of speed
    accel_noise: float  # m/s^2/rtHz
    accel_shake: float  # m/s^2/rtHz per m/s of speed
    gyro_drift: float  # rad/s/rts
    accel_drift: float  # m/s^2/rts, floors that tilt the base
    sensor_drift: float  # m/s^2/rts, the accelerometer itself
    traction_time: float  # s over which acceleration is averaged for traction
    scale_time: float  # s over which speeds are averaged for scale errors
    blind_turn: float  # rad/s, how well the last yaw rate is known without gyro
    blind_push: float  # m/s^2/rtHz of acceleration without accelerometer
    # wheels
    rolling_noise: float  # m/rtm of micro-slip
    traction_noise: float  # m/rtm per rt(m/s^2)
    creep_time: float  # s the creep of a gripping wheel takes to change
    creep_traction: float  # m/s of creep per m/s^2 of acceleration
    creep_hard: float  # m/s of creep per (m/s^2)^2
    creep_steady: float  # creep over speed of a gripping wheel, per traction over load
    creep_least: float  # m/s of creep beyond which a wheel is looked at, and standard deviations
    creep_sigmas: float  # of what its traction explains besides
    creep_limit: float  # m/s of creep with which a wheel may still grip
    creep_edge: float  # m/s, how soft that limit is at least
    travel: FloatArray  # (W,) m a rad
    resolution: FloatArray  # (W,) m, standard deviation of one travel reading
    reading: FloatArray  # (W, W) m^2, covariance of the travels of one frame
    tick: FloatArray  # (W,) cells, m of travel a count
    late_weight: float  # probability that the frame's stamp is late
    # hypotheses
    member: FloatArray  # (M, W) 1 where the wheel slips
    likely: FloatArray  # (W, W, M) covariance of slip speeds in the likelihood, (m/s)^2
    change: FloatArray  # (M, M) rates of change between hypotheses, 1/s
    pairs: FloatArray  # (G, W) groups of wheels whose roller axes are parallel
    calm_span: float  # s that calm frames may wait for a covariance step
    calm_push: float  # m/s^2 of traction above which no frame is calm
    calm_slip: float  # m/s of slip above which no frame is calm
    loose_sigma: float  # m/s, slip speed in the update: as good as unknown
    regrip_factor: float  # penalty for gripping again while the slip speed still changes
    flat_speed: float  # m/s of change in slip speed that counts as none
    extra_creep: float  # variance factor of micro-slip around a slip
    extra_time: float  # s
    drift_apart: float  # m/s^2: growth of the doubt of the velocity while nothing holds it
    patience: float  # s after which wheels win over the accelerometer
    # standstill
    rest_window: float  # s
    rest_travel: FloatArray  # (W,) cells, m a wheel may move and still stand
    rest_gyro: float  # rad/s, rms that still counts as quiet beyond the noise
    rest_accel: float  # m/s^2
    # outputs
    ratio_window: float  # s
    ratio_travel: float  # m a wheel must turn for a ratio to be defined
    unit: FloatArray  # (N, N) identity
    inverse: FloatArray  # (3, W) cells, least-squares body motion of wheel travel
    carriers: FloatArray  # (4, C) table of the carriers; (4, 0) for wheels
