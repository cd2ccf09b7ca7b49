"""Which topics of a recording feed the estimator: by name, with or without a leading slash."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from mecanum_base.bag.block import Channel
from mecanum_base.bag.decode import IMU, JOINT_STATE, RATES, TICKS
from mecanum_base.core.errors import BagError
from mecanum_base.robot import Robot

POSE = 'geometry_msgs/msg/PoseWithCovarianceStamped'
HEADER = 'std_msgs/msg/Header'
TF = 'tf2_msgs/msg/TFMessage'
STREAMS = ('encoder', 'imu', 'set_pose', 'odometry_reset', 'tf_static', 'wheel_commands')
TYPES = {'encoder': (JOINT_STATE, *TICKS), 'imu': (IMU,), 'set_pose': (POSE,),
         'odometry_reset': (HEADER,), 'tf_static': (TF,), 'wheel_commands': (JOINT_STATE, RATES)}


@dataclass(frozen=True, slots=True)
class Topics:
    """Topic names of the estimator's inputs; None leaves an input out."""

    encoder: str | None = 'joint_states'
    imu: str | None = 'imu/data_raw'
    set_pose: str | None = 'set_pose'
    odometry_reset: str | None = 'odometry_reset'
    tf_static: str | None = None  # read only where the robot file has imu.from_tf
    wheel_commands: str | None = 'wheel_commands'  # for notes alone: a type unknown is left out

    @classmethod
    def of(cls, robot: Robot, encoder: str | None = None, imu: str | None = None,
           use_imu: bool = True) -> Topics:
        """Defaults for a robot, with names given by the user put in their place."""
        found = cls(encoder=encoder or robot.encoder.source,
                    tf_static='tf_static' if robot.imu.from_tf else None)
        return replace(found, imu=(imu or found.imu) if use_imu else None)

    def stream(self, channel: Channel) -> str | None:
        """The input that the channel feeds; None for none. BagError for a wrong type."""
        name = channel.topic.lstrip('/')
        for stream in STREAMS:
            wanted = getattr(self, stream)
            if wanted is not None and wanted.lstrip('/') == name:
                fits = channel.type in TYPES[stream] and channel.encoding == 'cdr'
                if stream == 'wheel_commands' and not fits:
                    return None
                if channel.type not in TYPES[stream]:
                    raise BagError(f'topic {channel.topic} has the type {channel.type}, but '
                                   f'{stream} needs {" or ".join(TYPES[stream])}')
                if channel.encoding != 'cdr':
                    raise BagError(f'topic {channel.topic} is encoded as {channel.encoding!r}; '
                                   f'only cdr can be read')
                return stream
        return None


def advice(stream: str, wanted: str, channels: Iterable[Channel]) -> str:
    """What a user can do when the topic of a stream is not in the recording."""
    known = sorted(set(channels), key=lambda c: c.topic)
    fitting = [c.topic for c in known if c.type in TYPES[stream]]
    option = {'encoder': '--encoder-topic', 'imu': '--imu-topic'}.get(stream, '')
    if fitting and option:
        return f'no messages on {wanted}; try {option} {" or ".join(fitting[:4])}'
    listed = ', '.join(f'{c.topic} ({c.type})' for c in known[:8]) or 'none'
    return f'no messages on {wanted}; topics in the recording: {listed}'
