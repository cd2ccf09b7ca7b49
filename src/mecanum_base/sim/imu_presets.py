"""Errors of well-known IMUs, named as in their datasheets.

Behind each number: [s] seen in a copy of the document named, [q] only seen quoted from it (by
drivers and other projects), [-] from memory, not found again. Unless it says otherwise the sheets
give typical values at 25 degrees C.

    MPU-6050  InvenSense PS-MPU-6000A-00 rev. 3.4, gyro at +-250 deg/s, accelerometer at +-2 g
      6.1     rate noise density 0.005 deg/s/rtHz [s], zero-rate output +-20 deg/s [s],
              sensitivity -3..+3 % (min, max) [s], cross axis +-2 % [s], 131 LSB/(deg/s) [s]
      6.2     400 ug/rtHz [s], zero-g +-50 mg (x, y; z: 80 mg, not used) [s], tolerance +-3 % [s],
              cross axis +-2 % [s], 16384 LSB/g [s]
              RM-MPU-6000A-00 rev. 4.2, 4.3: DLPF_CFG 2 = 94 Hz (accel), 98 Hz (gyro) [q]
    BNO055    Bosch BST-BNO055-DS000 rev. 1.4
      0.2     table 0-2: gyro 0.014 deg/s/rtHz [q], zero rate +-1 deg/s [-], sensitivity +-1 % [-],
              cross axis +-1 % [-]; accelerometer 150 ug/rtHz (190 at most) [q], zero-g +-80 mg
              [q], sensitivity +-1 % [-], cross axis +-1 % [-]
      3.5     ranges at power-on 2000 deg/s [-], 4 g [q]; 47 Hz is one of the gyro's bandwidths,
              at which the sheet states its noise [-]
      3.6     tables 3-22 and 3-33: 16 LSB/(deg/s) [s], 100 LSB/(m/s2) [s]
    BMI088    Bosch BST-BMI088-DS001 rev. 1.9
      1       gyro 0.014 deg/s/rtHz [q], zero rate +-1 deg/s [q], sensitivity +-1 % [-], cross axis
              +-1 % [-]; accelerometer 160 ug/rtHz (x, y; z: 190, not used) [q], zero-g 20 mg [q],
              sensitivity +-0.5 % [-], cross axis 0.5 % [q], 5460 LSB/g at +-6 g [q]
      5.3.4   accelerometer 16 bit, scale of its range [s];  5.5.2 gyro 16 bit, 32767 LSB over the
              range [s], here +-500 deg/s
      5.5.5   gyro at 200 Hz output: 64 Hz [q, Bosch's own driver]

Standard deviations of what is drawn at switch-on are our choice, because a typical value is no
distribution: a third of the sheet's number for MPU-6050 and BMI088 (a robot's maker calibrates
once), the whole number for BNO055 (as it comes). No sheet gives the random walk of the bias; the
numbers here are of the size that Allan plots of such parts show (assumption). Not modelled:
temperature, g-sensitivity of the gyro.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

_DEG = math.pi / 180.0
_G = 9.80665


@dataclass(frozen=True, slots=True)
class ImuErrors:
    """Error figures of one IMU, SI units."""

    gyro_noise_density: float  # rad/s/rtHz
    gyro_zero_rate: float  # rad/s, standard deviation of the turn-on bias
    gyro_bias_walk: float  # rad/s/rt(s)
    gyro_sensitivity_error: float  # relative, standard deviation
    gyro_cross_axis: float  # relative, standard deviation
    gyro_lsb: float  # rad/s
    gyro_range: float  # rad/s
    accel_noise_density: float  # m/s2/rtHz
    accel_zero_g: float  # m/s2, standard deviation of the turn-on bias
    accel_bias_walk: float  # m/s2/rt(s)
    accel_sensitivity_error: float  # relative, standard deviation
    accel_cross_axis: float  # relative, standard deviation
    accel_lsb: float  # m/s2
    accel_range: float  # m/s2
    bandwidth: float  # Hz, of the low-pass filter in the sensor; 0 = none


PRESETS: dict[str, ImuErrors] = {
    'ideal': ImuErrors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    'mpu6050': ImuErrors(
        0.005 * _DEG, 20.0 / 3.0 * _DEG, 1e-5, 0.01, 0.02 / 3.0, _DEG / 131.0, 250.0 * _DEG,
        400e-6 * _G, 0.05 / 3.0 * _G, 3e-4, 0.01, 0.02 / 3.0, _G / 16384.0, 2.0 * _G, 94.0),
    'bno055': ImuErrors(
        0.014 * _DEG, 1.0 * _DEG, 8e-6, 0.01, 0.01, _DEG / 16.0, 2000.0 * _DEG,
        150e-6 * _G, 0.08 * _G, 2e-4, 0.01, 0.01, 0.01, 4.0 * _G, 47.0),
    'bmi088': ImuErrors(
        0.014 * _DEG, 1.0 / 3.0 * _DEG, 5e-6, 0.01 / 3.0, 0.01 / 3.0, _DEG / 65.536, 500.0 * _DEG,
        160e-6 * _G, 0.02 / 3.0 * _G, 1e-4, 0.005 / 3.0, 0.005 / 3.0, _G / 5460.0, 6.0 * _G,
        64.0),
}
