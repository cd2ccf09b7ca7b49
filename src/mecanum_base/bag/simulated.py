"""Write a simulated run as a bag, and its truth as text, byte for byte the same for a seed."""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from typing import Any

import numpy as np

from mecanum_base import messages
from mecanum_base.bag.encode import blank, encode
from mecanum_base.bag.recorder import Recorder
from mecanum_base.core.records import ImuSample, TickSample, WheelSample
from mecanum_base.robot import Robot
from mecanum_base.sim.headless import Command, Run
from mecanum_base.sim.records import Reading, Truth

WORLD_FRAME = 'map'  # frame of the truth
TRUTH_COLUMNS = ('stamp', 'x', 'y', 'yaw', 'vx', 'vy', 'wz')


class SimulatedBag:
    """Turns readings and commands into messages on the topics of the interface contract."""

    def __init__(self, folder: pathlib.Path, robot: Robot) -> None:
        frames, prefix = robot.frames, robot.frames.tf_frame_prefix
        self._base, self._imu = prefix + frames.base_frame_id, prefix + frames.imu_frame_id
        self._joints = robot.base.joint
        self._sign = robot.encoder.for_wheels(robot.base.count)[1]
        narrow = robot.encoder.ticks_type == 'int32'
        types = {'joint_states': 'sensor_msgs/msg/JointState',
                 'wheel_ticks': f'std_msgs/msg/Int{32 if narrow else 64}MultiArray',
                 'imu/data_raw': 'sensor_msgs/msg/Imu',
                 'wheel_commands': 'sensor_msgs/msg/JointState',
                 'cmd_vel': 'geometry_msgs/msg/Twist',
                 'ground_truth/odom': 'nav_msgs/msg/Odometry',
                 'ground_truth/slip': 'sensor_msgs/msg/JointState'}
        self._recorder = Recorder(folder)
        self._channel = {t: self._recorder.channel(f'/{t}', kind) for t, kind in types.items()}
        self._filled = {topic: blank(kind) for topic, kind in types.items()}

    def _write(self, topic: str, at_ns: int, message: Any) -> None:
        self._recorder.write(self._channel[topic], at_ns, at_ns, encode(message))

    def reading(self, at_ns: int, reading: Reading) -> None:
        """Write one reading of the simulation, logged at ``at_ns``."""
        filled = self._filled
        if isinstance(reading, WheelSample):
            topic = 'joint_states'
            self._write(topic, at_ns,
                        messages.write_wheel_angles(reading, filled[topic], self._joints))
        elif isinstance(reading, TickSample):
            self._write('wheel_ticks', at_ns,
                        messages.write_ticks(reading, filled['wheel_ticks']))
        elif isinstance(reading, ImuSample):
            topic = 'imu/data_raw'
            self._write(topic, at_ns, messages.write_imu(reading, filled[topic], self._imu))
        elif isinstance(reading, Truth):
            topic = 'ground_truth/odom'
            self._write(topic, at_ns,
                        messages.write_truth(reading, filled[topic], WORLD_FRAME, self._base))
            topic = 'ground_truth/slip'
            self._write(topic, at_ns, messages.write_slip_wheels(
                reading.stamp_ns, reading.slip_rate, reading.slip_angle, filled[topic],
                self._joints))

    def command(self, command: Command) -> None:
        """Write the wanted twist and the wheel rates sent for it."""
        message = messages.write_twist(command.twist, self._filled['cmd_vel'])
        self._write('cmd_vel', command.stamp_ns, message)
        message = messages.write_wheel_rates(
            command.stamp_ns, command.rate * self._sign, self._filled['wheel_commands'],
            self._joints)
        self._write('wheel_commands', command.stamp_ns, message)

    def close(self) -> None:
        """Complete the bag."""
        self._recorder.close()


def write_bag(run: Run, robot: Robot, folder: pathlib.Path,
              progress: Callable[[float], None] | None = None) -> None:
    """Write ``run`` as a rosbag2 folder, which must not exist (BagError)."""
    bag = SimulatedBag(folder, robot)
    waiting = iter((*run.commands, None))
    command = next(waiting)
    for number, item in enumerate(run.published):
        while command is not None and command.stamp_ns <= item.at_ns:
            bag.command(command)
            command = next(waiting)
        bag.reading(item.at_ns, item.reading)
        if progress is not None and number % 1000 == 0:
            progress(number / len(run.published))
    bag.close()


def write_truth(run: Run, folder: pathlib.Path) -> None:
    """Write truth.tum and truth.csv (pose, twist; slip rate [rad/s] and angle of each wheel)."""
    stamps = [f'{ns // 10**9}.{ns % 10**9:09d}' for ns in run.stamp_ns.tolist()]
    half = run.pose[:, 2] / 2.0
    with (folder / 'truth.tum').open('w', encoding='ascii', newline='\n') as out:
        for stamp, (x, y, _), qz, qw in zip(stamps, run.pose.tolist(), np.sin(half).tolist(),
                                            np.cos(half).tolist()):
            out.write(f'{stamp} {x!r} {y!r} 0 0 0 {qz!r} {qw!r}\n')
    columns = [*TRUTH_COLUMNS, *(f'{joint}.slip_rate' for joint in run.joints),
               *(f'{joint}.slip_angle' for joint in run.joints)]
    table = np.hstack([run.pose, run.twist, run.slip_rate, run.slip_angle]).tolist()
    with (folder / 'truth.csv').open('w', encoding='ascii', newline='\n') as out:
        out.write(','.join(columns) + '\n')
        for stamp, row in zip(stamps, table):
            out.write(stamp + ',' + ','.join(map(repr, row)) + '\n')
