"""The diagnostics of the goal node."""

from __future__ import annotations

from typing import Any

from mecanum_base.ros.diagnostics import ERROR, OK, WARN, Status


def goal_statuses(node: Any) -> list[Status]:
    """One status a source (odom must be there while a goal is pursued), then the goal."""
    active = node.pursuit.active
    found = []
    for topic, source in node.sources.items():
        status = source.report(needed=topic == 'odom' and active,
                               silent='' if topic == 'odom' and active else f'no {topic}')
        if status.level == WARN and not source.rejected:  # silence of an input nobody needs now
            status = Status(status.name, OK, status.message, status.values)
        found.append(status)
    state, values = node.pursuit.state, {
        'distance [m]': f'{node.pursuit.distance:.3f}', 'obstacle points': len(node.obstacles),
        'odom age [s]': f'{node.odom_age:.3f}'}
    level = ERROR if state.startswith('stuck') else WARN if state.startswith('waiting') else OK
    return [*found, Status('goal', level, state, values)]
