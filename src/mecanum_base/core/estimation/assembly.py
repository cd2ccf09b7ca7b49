"""Model and memory of one robot: the only place where configuration becomes plain numbers.

Constants that are physics or taste of the filter rather than properties of a robot are written
here with their reason; section 5 of docs/estimator.md says how flat each optimum is.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import cells
from mecanum_base.core.estimation.geometry import (
    Base,
    carrier_table,
    rolling_rows,
    travel_per_radian,
)
from mecanum_base.core.estimation.hindsight import SLOTS, TAPE
from mecanum_base.core.estimation.hypotheses import Hypotheses, build
from mecanum_base.core.estimation.layout import (
    BAX,
    BAY,
    BG,
    BLOCK,
    BSX,
    BSY,
    CLOCK_SIZE,
    CREEPS,
    FLAT,
    JITTER,
    KAX,
    KAY,
    KG,
    KL,
    LEAN_ZZ,
    M_SIZE,
    PAST,
    PX,
    PY,
    REEL_SIZE,
    SIGMA,
    SLOPE,
    STRETCH,
    VX,
    VY,
    WHEEL_ROWS,
    YAW,
    K,
    Memory,
)
from mecanum_base.core.estimation.lean import GRAVITY, LEAK
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.output import row_size
from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.estimation.trail import row_width
from mecanum_base.core.estimation.tuning import EstimatorConfig
from mecanum_base.core.parameter import FloatArray
from mecanum_base.core.platform.carriers import Carriers

FINEST = 5e-5  # m, no encoder on wheels with rollers is better than this
START_JITTER = 3e-4  # s
REST_CREEP = 1.5e-4  # m within 0.25 s: a base that is held by its motors on a slope may creep
TILT = 0.08  # m/s^2 of gravity that a floor not quite level lets x and y feel


def hypotheses_of(base: Base) -> Hypotheses:
    """Slip hypotheses of a base with the filter's own prior (estimator.md, section 5)."""
    return build(rolling_rows(base), single=0.18, common=0.25, spread=0.02, loose_rate=0.1,
                 grip_rate=3.0, common_rate=1.0)


def model_of(base: Base, encoder: EncoderConfig, imu: ImuConfig, tuning: EstimatorConfig) -> Model:
    """All constants of the filter; raises ConfigError where columns do not fit the wheels."""
    counts, _ = encoder.for_wheels(base.count)
    travel = travel_per_radian(base)
    count = travel * (2.0 * math.pi / counts)
    tables = hypotheses_of(base)
    resolution = np.maximum(0.35 * count, FINEST) + 2e-5
    return Model(
        wheels=base.count,
        lever_x=float(imu.xyz[0]), lever_y=float(imu.xyz[1]), imu_gap=0.03,
        gyro_noise=tuning.gyro_noise, gyro_shake=8e-4,
        accel_noise=tuning.accel_noise, accel_shake=0.004,
        gyro_drift=math.radians(8e-4), accel_drift=0.04, sensor_drift=0.002,
        blind_turn=2.0, blind_push=0.8,
        traction_time=0.01, scale_time=0.3, rolling_noise=0.0015, traction_noise=0.001,
        creep_time=0.12, creep_traction=0.008, creep_hard=0.03,
        creep_steady=0.0 if isinstance(base, Carriers) else tuning.creep,
        creep_least=0.05, creep_sigmas=3.0,
        creep_limit=0.3, creep_edge=0.03,
        travel=travel, resolution=resolution, reading=np.diag(resolution ** 2),
        tick=cells(np.maximum(count, FINEST)),
        late_weight=0.01,
        member=tables.member, likely=tables.likely, change=tables.change,
        pairs=tables.groups,
        calm_span=0.025, calm_push=0.5, calm_slip=0.03,
        loose_sigma=10.0, regrip_factor=0.03, flat_speed=0.03,
        extra_creep=500.0, extra_time=0.15,
        drift_apart=0.02, patience=5.0,
        rest_window=0.25,
        rest_travel=cells(np.maximum(1.5 * np.maximum(count, FINEST), REST_CREEP)),
        rest_gyro=0.02, rest_accel=0.25,
        ratio_window=0.5, ratio_travel=0.05,
        unit=np.eye(K + 4 * base.count),
        inverse=cells(np.array(np.linalg.pinv(rolling_rows(base)), dtype=np.float64)),
        carriers=(carrier_table(base) if isinstance(base, Carriers) else np.zeros((4, 0))),
    )


def start_covariance(wheels: int, rollers: bool, tuning: EstimatorConfig,
                     resolution: FloatArray) -> FloatArray:
    """Covariance (N, N) of a base that has just started: known pose, unknown biases.

    Units are those of the state (:mod:`.layout`), ``resolution`` (W,) m. Where wheels have no
    ``rollers`` they share their lateral gain.
    """
    phi, creep, side, n = K + wheels, K + 2 * wheels, K + 3 * wheels, K + 4 * wheels
    sigma = np.zeros(n)
    sigma[[VX, VY]] = 0.1
    sigma[BG] = tuning.gyro_bias_sigma
    sigma[[BAX, BAY]] = TILT
    sigma[KG], sigma[KL] = tuning.gyro_scale_sigma, tuning.lever_sigma
    sigma[[KAX, KAY]] = tuning.accel_scale_sigma
    sigma[K:phi] = tuning.wheel_sigma
    sigma[phi:creep] = resolution
    sigma[side:] = tuning.roller_sigma if rollers else 0.0
    covariance = np.diag(sigma ** 2)
    covariance[K:phi, K:phi] += tuning.radius_sigma ** 2
    covariance[side:, side:] += tuning.lateral_sigma ** 2
    for i, j in ((BAX, BSX), (BAY, BSY)):
        covariance[i:j + 1:j - i, i:j + 1:j - i] += tuning.accel_bias_sigma ** 2
    for i in (PX, PY):
        covariance[i, i] = 1e-8
    covariance[YAW, YAW] = 1e-10
    return covariance


def memory_of(base: Base, model: Model, tuning: EstimatorConfig) -> Memory:
    """Working memory of a base that stands at 0, 0, 0."""
    w = model.wheels
    n = K + 4 * w
    m = np.zeros(M_SIZE)
    m[JITTER] = START_JITTER ** 2
    m[STRETCH] = 1.0
    m[CREEPS] = model.creep_limit
    m[LEAN_ZZ] = (model.accel_drift / GRAVITY / LEAK) ** 2
    wheel = np.zeros((WHEEL_ROWS, w))
    wheel[FLAT] = 1.0
    wheel[SIGMA] = 1.0
    start = start_covariance(w, not isinstance(base, Carriers), tuning, model.resolution)
    parts = (np.zeros(n), start, m,
             np.ascontiguousarray(rolling_rows(base)),
             np.array(base.initial_angle) if isinstance(base, Carriers) else np.zeros(0),
             np.eye(1, len(model.member))[0], wheel, np.zeros((2 * SLOPE, w)),
             np.zeros((PAST, 1 + 2 * w)), np.zeros(row_size(w)), np.zeros(3 * BLOCK))
    store = np.concatenate([part.ravel() for part in parts])
    ends = np.cumsum([part.size for part in parts])
    x, P, m, rows, hinge, mode, wheel, slope, past, row, block = (
        store[end - part.size:end].reshape(part.shape) for part, end in zip(parts, ends))
    kept_ns = np.zeros((SLOTS, 4), dtype=np.int64)
    kept_ns[:, 1] = -TAPE - 1
    return Memory(
        x=x, s=cells(x), P=P, variance=P.reshape(-1)[::n + 1], m=cells(m),
        clock=cells(np.zeros(CLOCK_SIZE, dtype=np.int64)),
        rows=rows, axis=cells(rows), hinge=hinge, mode=mode, wheel=wheel, each=cells(wheel),
        slope=cells(slope), past=cells(past), row=row, entry=cells(row), block=cells(block),
        store=store, kept=np.zeros((SLOTS, len(store))),
        kept_clock=np.zeros((SLOTS, CLOCK_SIZE), dtype=np.int64), kept_ns=cells(kept_ns),
        tape=cells(np.zeros((TAPE, max(5, 2 * w)))),
        tape_ns=cells(np.zeros((TAPE, 2), dtype=np.int64)),
        reel=cells(np.zeros(REEL_SIZE, dtype=np.int64)),
        trail=np.zeros((0, row_width(w))), trail_ns=np.zeros(0, dtype=np.int64))
