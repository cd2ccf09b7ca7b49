"""What the drive node says on /diagnostics: what it hears, what it does and why it stands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mecanum_base.core.command.stopping import DISABLED, STOPPED
from mecanum_base.core.parameter import FloatArray
from mecanum_base.ros.diagnostics import ERROR, OK, WARN, Status

if TYPE_CHECKING:
    from mecanum_base.ros.drive_node import DriveNode


def drive_statuses(node: DriveNode) -> tuple[Status, ...]:
    """The statuses 'cmd_vel' (input) and 'wheels' (output) of a drive node."""
    return _command_status(node), _wheel_status(node)


def _command_status(node: DriveNode) -> Status:
    rejected = {**node.driver.stopping.rejected, **node.source.rejected}
    status = node.source.report(
        rejected=rejected, needed=False, silent='no command: standing',
        values={'type': node.command.type, 'subscribed as': node.robot.drive.cmd_vel_type})
    level, text = status.level, status.message
    if level == WARN and text == 'no command: standing':
        level = OK  # nobody has to command a base that may stand
    if node.command.problem:
        level, text = ERROR, node.command.problem
    return Status(status.name, level, text, status.values)


def _wheel_status(node: DriveNode) -> Status:
    stopping, told = node.driver.stopping, node.told
    twist = np.zeros(3) if told is None else told.twist
    rates = np.zeros(node.robot.base.count) if told is None else told.rates
    values: dict[str, object] = {
        'mode': stopping.mode, 'reason': stopping.reason,
        'wanted twist [m/s, m/s, rad/s]': _numbers(node.driver.wanted),
        'told twist [m/s, m/s, rad/s]': _numbers(twist),
        'limited': str(not np.allclose(node.driver.wanted, twist)).lower(),
    }
    for name, rate in zip(node.robot.base.joint, rates):
        values[f'{name} [rad/s]'] = f'{rate:.4g}'
    level = WARN if stopping.mode in (DISABLED, STOPPED) else OK
    text = f'{stopping.mode}: {stopping.reason}'
    if node.clock_stopped:
        level, text = WARN, f'the simulated clock stands still; {text}'
    return Status('wheels', level, text, values)


def _numbers(values: FloatArray) -> str:
    return ', '.join(f'{value:.4g}' for value in values)
