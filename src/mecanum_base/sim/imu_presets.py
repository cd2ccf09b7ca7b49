"""Errors of well-known IMUs, named as in their datasheets.

Typical values; where a tolerance is a limit (MPU-6050, BMI088), a third of it is the standard
deviation; where it is typical (BNO055), it is the standard deviation itself.

    MPU-6050  InvenSense PS-MPU-6000A-00 rev. 3.4, tables 6.1 and 6.2 (gyro +-250 deg/s, accel
              +-2 g, DLPF_CFG 2): rate noise density 0.005 deg/s/rtHz, zero-rate output +-20 deg/s,
              sensitivity tolerance +-3 %, cross axis +-2 %, 131 LSB/(deg/s); accelerometer
              400 ug/rtHz, zero-g +-50 mg, tolerance +-3 %, cross axis +-2 %, 16384 LSB/g
    BNO055    Bosch BST-BNO055-DS000 rev. 1.4, table 0-2: gyro 0.014 deg/s/rtHz, zero rate
              +-1 deg/s, sensitivity +-1 %, cross axis +-1 %; accelerometer 150 ug/rtHz, zero-g
              +-80 mg, sensitivity +-1 %, cross axis +-1 %; tables 3-22 and 3-33: output
              16 LSB/(deg/s), 100 LSB/(m/s2)
    BMI088    Bosch BST-BMI088-DS001, specification tables: gyro 0.014 deg/s/rtHz, zero rate
              +-1 deg/s, sensitivity +-1 %, cross axis +-1 %, 16 bit over +-500 deg/s;
              accelerometer 160 ug/rtHz, zero-g +-20 mg, sensitivity +-0.5 %, cross axis +-0.5 %,
              16 bit over +-6 g; filter of the gyro at 200 Hz output: 64 Hz

Datasheets do not give the random walk of the bias; the numbers here are of the size that Allan
plots of such parts show (assumption). Not modelled: temperature, g-sensitivity of the gyro.
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
