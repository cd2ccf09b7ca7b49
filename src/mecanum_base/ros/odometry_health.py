"""The diagnostics of the odometry node: sources, estimator, slip and transform in plain words."""

from __future__ import annotations

import math
from typing import Any

from mecanum_base.core.estimation.health import Health
from mecanum_base.core.estimation.notes import unobservable
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.ros.diagnostics import ERROR, OK, STALE, WARN, Source, Status
from mecanum_base.ros.transforms import Transforms

LIKELY = 0.5  # probability from which a wheel is reported as slipping


class OdometryHealth:
    """Collects the statuses of one odometry node."""

    def __init__(self, node: Any, encoder: Source, imu: Source, transforms: Transforms) -> None:
        self._node, self._encoder, self._imu = node, encoder, imu
        self._transforms = transforms
        base = node.robot.base
        radius = base.wheel_radius if isinstance(base, Carriers) else base.radius
        self._radius = (radius.repeat(2) if isinstance(base, Carriers) else radius).tolist()
        self._limits = unobservable(base)
        self._before = 0

    def statuses(self) -> list[Status]:
        """One status a source, then estimator, slip and transform."""
        health = self._node.intake.health
        return [self._encoder_status(health), self._imu_status(health), self._estimator(health),
                self._slip(), self._transform()]

    def _encoder_status(self, health: Health) -> Status:
        rejected = {**_of_stream(health, self._encoder.name), **self._encoder.rejected}
        status = self._encoder.report(rejected=rejected)
        ticks = self._node.ticks
        if ticks is not None and (ticks.conflict or ticks.unknown):
            other = ticks.conflict or ticks.unknown
            return Status(status.name, ERROR, f'{ticks.topic} is also published as {other}, '
                          f'which is ignored; in use: {ticks.type}', status.values)
        return status

    def _imu_status(self, health: Health) -> Status:
        shown = {'state': health.imu}
        status = self._imu.report(
            rejected=_of_stream(health, 'imu'), needed=False, values=shown,
            silent=f'no IMU on {self._imu.topic}: odometry from the wheels alone')
        if self._node.intake.mount_known:
            return status
        return Status(status.name, ERROR, 'the mount of the IMU is not on tf_static '
                      '(imu.from_tf is true): it is not used', status.values)

    def _estimator(self, health: Health) -> Status:
        count = dict(self._node.topics.count)
        total = sum(count.values())
        new, self._before = total - self._before, total
        values: dict[str, object] = {f'published: {source}': n for source, n in count.items()}
        for stream, n in sorted(health.received.items()):
            values[f'received: {stream}'] = n
            values[f'used: {stream}'] = health.used.get(stream, 0)
        values |= {f'rejected: {stream}: {reason}': n
                   for (stream, reason), n in sorted(health.rejected.items())}
        values |= _numbers(health)
        if not new:
            return Status('estimator', STALE, 'no odometry: no encoder data', values)
        values |= {f'cannot be seen ({i + 1})': note for i, note in enumerate(self._limits)}
        notes = [note for note in health.notes if note not in self._limits]
        return Status('estimator', WARN if notes else OK, '; '.join(notes) or 'estimating', values)

    def _slip(self) -> Status:
        estimate = self._node.latest
        if estimate is None:
            return Status('slip', STALE, 'no odometry yet')
        slip, joints = estimate.slip, self._node.robot.base.joint
        values: dict[str, object] = {}
        for index, joint in enumerate(joints):
            speed = float(slip.rate[index]) * self._radius[index]
            values[f'{joint}: slip speed [m/s]'] = f'{speed:.4f}'
            values[f'{joint}: ratio s'] = _defined(float(slip.ratio[index]))
            values[f'{joint}: probability'] = f'{float(slip.probability[index]):.3f}'
        values['body: probability'] = f'{slip.body_probability:.3f}'
        values['body: ratio s'] = _defined(float(slip.ratio[-1]))
        slipping = [joint for joint, p in zip(joints, slip.probability) if p > LIKELY]
        if slipping:
            return Status('slip', WARN, 'slipping: ' + ', '.join(slipping), values)
        if slip.body_probability > LIKELY:
            return Status('slip', WARN, 'slipping, the wheel is not known', values)
        return Status('slip', OK, 'rolling', values)

    def _transform(self) -> Status:
        topics = self._node.topics
        return Status('transform', WARN if topics.tf_missing else OK, topics.tf_way)


def _of_stream(health: Health, stream: str) -> dict[str, int]:
    return {reason: n for (name, reason), n in health.rejected.items() if name == stream}


def _numbers(health: Health) -> dict[str, object]:
    """Biases and standstill as text."""
    return {
        'standstill': str(health.standstill).lower(),
        'gyro bias [rad/s]': _text(health.gyro_bias),
        'gyro bias sigma [rad/s]': _text(health.gyro_bias_sigma),
        'accel bias [m/s2]': _text(health.accel_bias),
        'accel bias sigma [m/s2]': _text(health.accel_bias_sigma),
        'restarts': health.restarts,
    }


def _text(value: Any) -> str:
    items = value if hasattr(value, '__len__') else [value]
    return ' '.join(f'{float(item):.6f}' for item in items)


def _defined(value: float) -> str:
    return 'undefined' if math.isnan(value) else f'{value:.3f}'
