"""Write a simulated run as a bag, and its truth as text, byte for byte the same for a seed."""

from __future__ import annotations

import pathlib
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from mecanum_base import messages
from mecanum_base.bag.encode import blank, encode
from mecanum_base.bag.recorder import Recorder
from mecanum_base.core.records import ImuSample, TickSample, WheelSample
from mecanum_base.robot import Robot
from mecanum_base.sim.headless import Command, Headless, Section
from mecanum_base.sim.records import Published, Reading, Truth

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
        self._commands: deque[Command] = deque()
        self._readings: deque[Published] = deque()

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

    def section(self, section: Section) -> None:
        """Write a section, commands before readings of the same instant."""
        self._commands.extend(section.commands)
        self._readings.extend(section.published)
        self._write_before(section.until_ns)  # of that instant commands may still come

    def rest(self) -> None:
        """Write what waits after the last section."""
        self._write_before(None)

    def _write_before(self, end_ns: int | None) -> None:
        commands, readings = self._commands, self._readings
        while readings and (end_ns is None or readings[0].at_ns < end_ns):
            item = readings.popleft()
            while commands and commands[0].stamp_ns <= item.at_ns:
                self.command(commands.popleft())
            self.reading(item.at_ns, item.reading)

    def close(self) -> None:
        """Complete the bag."""
        self._recorder.close()


class TruthFiles:
    """truth.tum and truth.csv (pose, twist; slip rate [rad/s] and angle of each wheel)."""

    def __init__(self, folder: pathlib.Path, joints: tuple[str, ...]) -> None:
        self._tum, self._csv = ((folder / name).open('w', encoding='ascii', newline='\n')
                                for name in ('truth.tum', 'truth.csv'))
        columns = [*TRUTH_COLUMNS, *(f'{joint}.slip_rate' for joint in joints),
                   *(f'{joint}.slip_angle' for joint in joints)]
        self._csv.write(','.join(columns) + '\n')

    def write(self, truths: Sequence[Truth]) -> None:
        """Add what is true at more instants."""
        for truth in truths:
            stamp = f'{truth.stamp_ns // 10**9}.{truth.stamp_ns % 10**9:09d}'
            x, y, yaw = truth.pose.tolist()
            qz, qw = float(np.sin(yaw / 2.0)), float(np.cos(yaw / 2.0))
            self._tum.write(f'{stamp} {x!r} {y!r} 0 0 0 {qz!r} {qw!r}\n')
            row = [x, y, yaw, *truth.twist.tolist(), *truth.slip_rate.tolist(),
                   *truth.slip_angle.tolist()]
            self._csv.write(stamp + ',' + ','.join(map(repr, row)) + '\n')

    def close(self) -> None:
        """Complete the files."""
        self._tum.close()
        self._csv.close()


def write_run(headless: Headless, robot: Robot, folder: pathlib.Path,
              progress: Callable[[float], None] | None = None) -> tuple[int, Truth | None]:
    """Run and write as it goes: a rosbag2 folder ``bag``, which must not exist (BagError), and
    the truth. Returns how many readings there were and the last truth.

    A run that is broken off leaves complete files that end there.
    """
    bag, truths = SimulatedBag(folder / 'bag', robot), TruthFiles(folder, headless.joints)
    count, last = 0, None
    try:
        for section in headless.sections(progress):
            bag.section(section)
            known = [item.reading for item in section.published
                     if isinstance(item.reading, Truth)]
            truths.write(known)
            count, last = count + len(section.published), known[-1] if known else last
        bag.rest()
    finally:
        bag.close()
        truths.close()
    return count, last
