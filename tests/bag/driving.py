"""A drive of a mecanum base made by hand formulas, for tests of doctor and calibration.

Nothing of the code under test is used: wheel rates are the textbook ones (R, inverse kinematics)

    FL = (vx - vy - L wz)/r   FR = (vx + vy + L wz)/r   RL = (vx + vy - L wz)/r
    RR = (vx - vy + L wz)/r   L = half wheelbase + half track

with own radius and lateral scale per wheel where a test asks for it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

LX, LY, RADIUS = 0.2, 0.15, 0.05
JOINTS = ('front_left_wheel_joint', 'front_right_wheel_joint', 'rear_left_wheel_joint',
          'rear_right_wheel_joint')
T0 = 1_700_000_000_000_000_000
YAML = f'''/**:
  ros__parameters:
    wheels:
      joint: [{", ".join(JOINTS)}]
      x: [{LX}, {LX}, -{LX}, -{LX}]
      y: [{LY}, -{LY}, {LY}, -{LY}]
      axle: [1.5707963267948966, 1.5707963267948966, 1.5707963267948966, 1.5707963267948966]
      roller: [0.7853981633974483, -0.7853981633974483, -0.7853981633974483, 0.7853981633974483]
      radius: [{RADIUS}, {RADIUS}, {RADIUS}, {RADIUS}]
    encoder:
      source: joint_states
      counts_per_revolution: 4096.0
'''


@dataclass
class Drive:
    """Columns of one drive; ``angle`` (N, 4) rad, ``gyro`` and ``accel`` (M, 3) sensor axes."""

    wheel_ns: np.ndarray
    angle: np.ndarray
    imu_ns: np.ndarray
    gyro: np.ndarray
    accel: np.ndarray
    truth_ns: np.ndarray
    pose: np.ndarray
    command: np.ndarray = field(default=None)


def drive(seed=1, seconds=60.0, forward=0.5, sideways=0.5, turning=0.8, radius=RADIUS, lever=None,
          lateral=1.0, gyro_scale=1.0, gyro_bias=0.01, imu_late=0.0, creep=0.01, rest=2.0,
          gyro_noise=0.003, accel_noise=0.05, truth_noise=0.0, slip=0.0,
          zero_g=(0.05, -0.08, 0.0), floor=(0.0, 0.0), place=(0.0, 0.0), rollers=0.0):
    """Legs of random twists with pauses; scales make the base differ from the robot file.

    ``zero_g`` m/s2: offset of the accelerometer; ``floor`` rad: how much the floor rises along
    x and y of the start; ``place`` m: the IMU in base_link.

    ``rollers`` rad: how far rollers that are off turn the way of the wheels against the base.
    ``lateral``: real sideways way over what four ideal wheels would give. ``slip``: share of legs
    in which one wheel spins 30 % faster than it rolls.
    """
    generator = np.random.default_rng(seed)
    dt = 0.005
    count = int(seconds / dt)
    t = np.arange(count) * dt
    target = np.zeros((count, 3))
    spin = np.ones((count, 4))
    at, leg = rest, 0
    while at < seconds - rest:
        length = generator.uniform(1.5, 3.0)
        twist = np.zeros(3)
        kind = leg % 4
        if kind in (0, 3):
            twist[0] = forward * generator.choice([-1, 1]) * generator.uniform(0.6, 1.0)
        if kind in (1, 3):
            twist[1] = sideways * generator.choice([-1, 1]) * generator.uniform(0.6, 1.0)
        if kind in (2, 3):
            twist[2] = turning * generator.choice([-1, 1]) * generator.uniform(0.6, 1.0)
        chosen = (t >= at) & (t < min(at + length, seconds - rest))
        target[chosen] = twist
        if generator.random() < slip:
            spin[chosen, generator.integers(4)] = 1.3
        at += length + generator.uniform(0.2, 0.6)
        leg += 1
    twist = target.copy()
    for axis in range(3):  # a first-order drive, 0.25 s
        state = 0.0
        for k in range(count):
            state += (target[k, axis] - state) * dt / 0.25
            twist[k, axis] = state
    vx, vy, wz = twist.T
    vx, vy = (vx * np.cos(rollers) + vy * np.sin(rollers),  # in the axes of the wheels
              vy * np.cos(rollers) - vx * np.sin(rollers))
    arm = LX + LY if lever is None else lever
    rates = np.column_stack([vx - vy / lateral - arm * wz, vx + vy / lateral + arm * wz,
                             vx + vy / lateral - arm * wz, vx - vy / lateral + arm * wz])
    rates = rates / (np.ones(4) * radius) * spin
    for wheel in range(4):  # creep: slowly varying share of the rate
        rates[:, wheel] *= 1.0 + creep * np.interp(t, np.arange(0, seconds + 1, 1.0),
                                                   generator.normal(size=int(seconds) + 1))
    angle = integral(rates, dt)
    vx, vy, wz = twist.T
    yaw = integral(wz, dt)
    c, s = np.cos(yaw), np.sin(yaw)
    pose = np.column_stack([integral(c * vx - s * vy, dt), integral(s * vx + c * vy, dt), yaw])
    wheel = slice(0, count, 2)
    quantum = 2 * np.pi / 4096
    push = np.gradient(twist[:, :2], dt, axis=0)
    accel = np.column_stack([push[:, 0] - wz * vy, push[:, 1] + wz * vx, np.full(count, 9.80665)])
    spin_up = np.gradient(wz, dt)
    accel[:, 0] += -spin_up * place[1] - wz**2 * place[0]
    accel[:, 1] += spin_up * place[0] - wz**2 * place[1]
    accel[:, 0] += 9.80665 * (c * floor[0] + s * floor[1])
    accel[:, 1] += 9.80665 * (-s * floor[0] + c * floor[1])
    accel += generator.normal(size=accel.shape) * accel_noise + np.array(zero_g)
    gyro = np.column_stack([0 * wz, 0 * wz, wz * gyro_scale])
    gyro += generator.normal(size=gyro.shape) * gyro_noise + [0.002, -0.003, gyro_bias]
    stamp = T0 + np.round(t * 1e9).astype(np.int64)
    seen = pose[::4] + generator.normal(size=pose[::4].shape) * truth_noise
    return Drive(stamp[wheel], np.round(angle[wheel] / quantum) * quantum,
                 stamp + int(imu_late * 1e9), gyro, accel, stamp[::4], seen, target)


def integral(rate, dt):
    """Integral of samples dt apart, trapezoidal: a held rate would be half a step late."""
    found = np.zeros_like(rate)
    found[1:] = np.cumsum((rate[1:] + rate[:-1]) * dt / 2.0, axis=0)
    return found


def mount(made, rotation, gyro_cross=None, accel_cross=None):
    """The same drive seen by an IMU whose axes are rotated: v_base = rotation @ v_sensor.

    The (3, 3) cross-axis errors are relative, in sensor axes.
    """
    made.gyro, made.accel = made.gyro @ rotation, made.accel @ rotation
    if gyro_cross is not None:
        made.gyro = made.gyro + made.gyro @ gyro_cross.T
    if accel_cross is not None:
        made.accel = made.accel + made.accel @ accel_cross.T
    return made
