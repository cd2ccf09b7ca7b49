"""Block ``sim`` of the robot file: body, drives, friction, sensors, faults."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.parameter import FloatArray, IntArray, frozen_floats, parameter
from mecanum_base.sim.faults import KINDS
from mecanum_base.sim.imu_presets import PRESETS

ENGINES = ('auto', 'plain', 'numba')
CONTACTS = ('exact', 'mean', 'nominal')


@dataclass(frozen=True, slots=True, eq=False)
class SimConfig:
    """Settings of the simulated hardware; the defaults describe a 12 kg research base."""

    seed: int = parameter('int', '', 'seed of every random number of the simulation', default=1,
                          low=0)
    publish_clock: bool = parameter('bool', '', 'publish /clock', default=False)
    rate_factor: float = parameter('float', '', 'speed of simulated time over real time',
                                   default=1.0, low=0.0, open_low=True)
    command_timeout: float = parameter(
        'float', 's', 'wheels stop this long after the last wheel_commands', default=0.25,
        low=0.0, open_low=True)
    scenario: str = parameter('str', '', 'scenario file: floor, events and faults', default='')
    engine: str = parameter('str', '', 'plain Python, compiled by numba, or auto: numba for '
                            'headless runs where it is installed', default='auto',
                            choices=ENGINES)
    physics_rate: float = parameter('float', 'Hz', 'physics steps a second', default=1000.0,
                                    low=200.0, high=100000.0)
    # body
    mass: float = parameter('float', 'kg', 'whole robot', default=12.0, low=0.0, open_low=True)
    yaw_inertia: float = parameter(
        'float', 'kg m2', 'about the mass centre; 0 = mass x mean squared wheel distance / 2',
        default=0.0, low=0.0)
    mass_centre: FloatArray = parameter('floats', 'm', 'mass centre in base_link (x, y)',
                                        default=(0.0, 0.0))
    mass_height: float = parameter('float', 'm', 'mass centre above the floor', default=0.12,
                                   low=0.0)
    support_sag: float = parameter(
        'float', 'm', 'how far the wheels and frame give under the weight', default=0.0005,
        low=0.0001, high=0.05)
    support_damping: float = parameter('float', '', 'damping ratio of heave', default=0.3,
                                       low=0.0, high=2.0)
    bumper: float = parameter('float', 'm', 'how far the body reaches beyond the wheel centres',
                              default=0.06, low=0.0)
    # wheels and drives
    wheel_inertia: float = parameter('float', 'kg m2', 'of one wheel about its axle',
                                     default=6e-4, low=0.0, open_low=True)
    carrier_inertia: float = parameter('float', 'kg m2', 'of one carrier about its hinge',
                                       default=0.02, low=0.0, open_low=True)
    rotor_inertia: float = parameter('float', 'kg m2', 'of one motor, at the motor shaft',
                                     default=1.5e-6, low=0.0)
    supply_voltage: float = parameter('float', 'V', 'limit of the drive', default=24.0, low=0.0,
                                      open_low=True)
    motor_constant: float = parameter('float', 'N m/A', 'torque and back-EMF constant',
                                      default=0.03, low=0.0, open_low=True)
    motor_resistance: float = parameter('float', 'ohm', 'of the winding and leads', default=0.8,
                                        low=0.0, open_low=True)
    current_limit: float = parameter('float', 'A', 'of the drive', default=8.0, low=0.0,
                                     open_low=True)
    gear_ratio: float = parameter(
        'float', '', 'motor turns a wheel turn; 0 = no-load speed 1.3 x the largest max_speed',
        default=0.0, low=0.0)
    loop_bandwidth: float = parameter('float', 'rad/s', 'of the wheel speed loop (PI)',
                                      default=30.0, low=0.1, high=1000.0)
    bearing_torque: float = parameter('float', 'N m', 'constant friction of axle and gear',
                                      default=0.03, low=0.0)
    bearing_viscous: float = parameter('float', 'N m s/rad', 'viscous friction of axle and gear',
                                       default=0.002, low=0.0)
    # contact
    contact: str = parameter('str', '', 'contact point: exact = wanders along each roller, mean '
                             '= averaged over a roller pitch, nominal = stays under the axle',
                             default='exact', choices=CONTACTS)
    friction: float = parameter('float', '', 'sliding friction coefficient of the floor',
                                default=0.6, low=0.0, high=5.0)
    static_ratio: float = parameter('float', '', 'static over sliding friction', default=1.2,
                                    low=1.0, high=3.0)
    stribeck_speed: float = parameter('float', 'm/s', 'slip at which the static peak fades',
                                      default=0.02, low=0.0, open_low=True)
    creep_stiffness: float = parameter('float', '', 'force over load per unit of creep (slip '
                                       'over speed)', default=30.0, low=0.5, high=1000.0)
    shear_stiffness: float = parameter('float', '1/m', 'force over load per displacement of a '
                                       'contact at rest', default=2000.0, low=50.0, high=1e5)
    shear_damping: float = parameter('float', 's/m', 'force over load per speed within the '
                                     'contact', default=5.0, low=0.0, high=100.0)
    roller_drag: float = parameter('float', '', 'drag of the roller bearings over the load',
                                   default=0.015, low=0.0, high=1.0)
    runout: float = parameter('float', 'm', 'eccentricity of each wheel', default=1e-4, low=0.0,
                              high=0.01)
    # how the true robot differs from the robot file (standard deviations, drawn from the seed)
    radius_error: float = parameter('float', '', 'relative error of each wheel radius',
                                    default=0.002, low=0.0, high=0.1)
    common_radius_error: float = parameter('float', '', 'relative error all radii share',
                                           default=0.002, low=0.0, high=0.1)
    position_error: float = parameter('float', 'm', 'error of each wheel position, x and y',
                                      default=0.0005, low=0.0, high=0.05)
    roller_error: float = parameter('float', 'rad', 'error of each roller angle',
                                    default=0.002, low=0.0, high=0.1)
    mount_error: float = parameter('float', 'rad', 'error of the IMU mount about each axis',
                                   default=0.003, low=0.0, high=0.2)
    # sensors
    encoder_rate: float = parameter('float', 'Hz', 'of joint_states and wheel_ticks',
                                    default=100.0, low=1.0, high=1000.0)
    truth_rate: float = parameter('float', 'Hz', 'of ground_truth', default=100.0, low=1.0,
                                  high=1000.0)
    imu_rate: float = parameter('float', 'Hz', 'of imu/data_raw', default=200.0, low=1.0,
                                high=1000.0)
    stamp_jitter: float = parameter('float', 's', 'stamp minus true time of an encoder sample, '
                                    'standard deviation', default=0.0002, low=0.0, high=0.1)
    encoder_delay: float = parameter('float', 's', 'from measurement to publication',
                                     default=0.001, low=0.0, high=1.0)
    imu_delay: float = parameter('float', 's', 'from measurement to publication', default=0.001,
                                 low=0.0, high=1.0)
    late_share: float = parameter('float', '', 'share of encoder messages that come late',
                                  default=0.0, low=0.0, high=1.0)
    late_time: float = parameter('float', 's', 'how late they come', default=0.03, low=0.0,
                                 high=10.0)
    missing_share: float = parameter('float', '', 'share of encoder messages that never come',
                                     default=0.0, low=0.0, high=1.0)
    burst_rate: float = parameter('float', '1/s', 'how often a burst of encoder messages is '
                                  'lost', default=0.0, low=0.0, high=10.0)
    burst_time: float = parameter('float', 's', 'how long such a burst lasts', default=0.2,
                                  low=0.0, high=60.0)
    imu_preset: str = parameter('str', '', 'IMU whose datasheet gives the errors; ideal = none',
                                default='bmi088', choices=tuple(PRESETS))
    imu_error_scale: float = parameter('float', '', 'all IMU errors of the preset times this',
                                       default=1.0, low=0.0, high=100.0)
    vibration_accel: float = parameter('float', 'm/s2 per m/s', 'roller vibration felt by the '
                                       'accelerometer per wheel speed', default=0.4, low=0.0,
                                       high=50.0)
    vibration_gyro: float = parameter('float', 'rad/s per m/s', 'roller vibration felt by the '
                                      'gyro per wheel speed', default=0.01, low=0.0, high=5.0)
    # fault on demand (also by scenario events)
    fault: str = parameter('str', '', 'fault that is active now', default='none',
                           choices=('none', *(k for k, kind in KINDS.items() if not kind.vector)),
                           live=True)
    fault_wheels: IntArray = parameter('ints', '', 'wheels it concerns, by index; empty = all',
                                       default=(), low=0, live=True)
    fault_value: float = parameter('float', '', 'its size, in the unit of the fault; 0 = usual',
                                   default=0.0, live=True)

    def __post_init__(self) -> None:
        if len(self.mass_centre) != 2:
            raise ConfigError('mass_centre', list(self.mass_centre), 'must have two entries', 'm')
        object.__setattr__(self, 'mass_centre', frozen_floats(self.mass_centre))
        for key in ('encoder_rate', 'imu_rate', 'truth_rate'):
            if getattr(self, key) > self.physics_rate:
                raise ConfigError(key, getattr(self, key),
                                  f'must be <= physics_rate = {self.physics_rate:g}', 'Hz')
        if not math.isfinite(self.fault_value):
            raise ConfigError('fault_value', self.fault_value, 'must be finite')
