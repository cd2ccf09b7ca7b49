"""One trial: a scenario with one seed, all methods on its readings, figures against the truth."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from mecanum_base.accuracy.drift import Drift, at_stamps, drift_of, path_of
from mecanum_base.accuracy.oracle import oracle_track
from mecanum_base.accuracy.slip_score import SlipScore, score_of
from mecanum_base.accuracy.told import told
from mecanum_base.accuracy.track import Track, readings_of, wheel_track
from mecanum_base.accuracy.twist_filter import twist_filter_track
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.estimation.estimator import Estimator
from mecanum_base.core.estimation.geometry import (
    parallel_groups,
    rolling_rows,
    travel_per_radian,
)
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.parameter import FloatArray, IntArray
from mecanum_base.core.records import Estimate, Sample, TickSample, WheelSample
from mecanum_base.robot import Robot
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.headless import run
from mecanum_base.sim.scenario_file import load_scenario

METHODS = ('ours', 'wheels', 'wheels + gyro', 'rl-style', 'oracle', 'oracle (times)')
_SPARSE = 10  # every tenth sample of the truth enters the consistency figures
_MOVED = 0.05  # m from the start, before which a position error says nothing


@dataclass(frozen=True, slots=True)
class Trial:
    """Figures of one run: ``drift`` by method; NEES of (x, y) and (vx, vy), each of 2 degrees
    of freedom, at moments 0.1 s apart, that of the position also of an estimator that was told how
    the robots are built (:mod:`.told`; empty where it was not asked for); slip score; ``path`` m.
    """

    scenario: str
    seed: int
    path: float
    drift: dict[str, Drift]
    nees_position: tuple[float, ...]
    nees_velocity: tuple[float, ...]
    slip: SlipScore
    nees_told: tuple[float, ...] = ()


def run_trial(name: str, seed: int, duration: float | None = None,
              also_told: bool = False) -> Trial:
    """Simulate and judge; ``name`` is a scenario file or a shipped one.

    Raises ConfigError for a robot the harness has no reference methods for (carriers).
    """
    scenario = load_scenario(name)
    shipped_file = shipped() / scenario.robot
    robot = load_robot(shipped_file if shipped_file.is_file() else scenario.robot)
    if not isinstance(robot.base, Wheels):
        raise ConfigError('robot', scenario.robot, 'must have fixed wheels: the reference '
                          'methods know no carriers')
    simulated = run(scenario, robot.base, robot.encoder, robot.imu, robot.sim, seed=seed,
                    duration=duration)
    samples = _subscribed(simulated.samples(commands=False), robot)
    estimates = _estimates(samples, robot)
    readings = readings_of(simulated, robot, [
        s for s in simulated.samples(commands=False) if not isinstance(s, TickSample)])
    tracks = {
        'ours': _track(estimates),
        'wheels': wheel_track(readings, robot, gyro_heading=False),
        'wheels + gyro': wheel_track(readings, robot, gyro_heading=True),
        'rl-style': twist_filter_track(readings, rolling_rows(robot.base)),
        'oracle': oracle_track(readings, robot, simulated, 'travel'),
        'oracle (times)': oracle_track(readings, robot, simulated, 'times'),
    }
    first = max(int(t.stamp_ns[0]) for t in tracks.values())
    last = min(int(t.stamp_ns[-1]) for t in tracks.values())
    inside = (simulated.stamp_ns >= first) & (simulated.stamp_ns <= last)
    stamp, truth = simulated.stamp_ns[inside], simulated.pose[inside]
    drift = {method: drift_of(at_stamps(track, stamp), truth)
             for method, track in tracks.items()}
    own = np.searchsorted(tracks['ours'].stamp_ns, stamp, side='right') - 1
    position, velocity = _consistency(estimates, tracks['ours'], stamp[::_SPARSE],
                                      truth[::_SPARSE], simulated.twist[inside][::_SPARSE])
    position_told: tuple[float, ...] = ()
    if also_told:
        others = _estimates(samples, dataclasses.replace(robot, estimator=told(robot)))
        position_told, _ = _consistency(others, _track(others), stamp[::_SPARSE],
                                        truth[::_SPARSE], simulated.twist[inside][::_SPARSE])
    groups = parallel_groups(rolling_rows(robot.base))
    pairs = groups if robot.base.count == 4 and len(groups) == 2 else ()
    slip = score_of((stamp - stamp[0]) * 1e-9,
                    simulated.slip_rate[inside] * travel_per_radian(robot.base),
                    np.array([e.slip.body_probability for e in estimates])[own],
                    np.array([e.slip.probability for e in estimates])[own], pairs)
    return Trial(scenario.name, seed, float(path_of(truth)[-1]), drift, position, velocity, slip,
                 position_told)


def _subscribed(samples: list[Sample], robot: Robot) -> list[Sample]:
    """What the odometry node subscribes to: one encoder source and the IMU."""
    unused = TickSample if robot.encoder.source == 'joint_states' else WheelSample
    return [sample for sample in samples if not isinstance(sample, unused)]


def _estimates(samples: list[Sample], robot: Robot) -> list[Estimate]:
    """Our odometry, samples in order of arrival as the node gets them."""
    estimator = Estimator(robot.base, robot.encoder, robot.imu, robot.estimator)
    found: list[Estimate] = []
    with np.errstate(all='ignore'):  # absurd values are judged, not warned of
        for sample in samples:
            found += estimator.handle(sample)
        found += estimator.flush()
    return found


def _track(estimates: list[Estimate]) -> Track:
    """Stamps and poses alone."""
    return Track(np.array([e.stamp_ns for e in estimates], dtype=np.int64),
                 np.array([e.pose for e in estimates]))


def _consistency(estimates: list[Estimate], track: Track, stamp: IntArray, pose: FloatArray,
                 twist: FloatArray) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """NEES of position and velocity at ``stamp``, errors and covariances interpolated."""
    seconds, own = (stamp - stamp[0]) * 1e-9, (track.stamp_ns - stamp[0]) * 1e-9

    def at(values: FloatArray) -> FloatArray:
        flat = values.reshape(len(values), -1)
        columns = [np.interp(seconds, own, flat[:, i]) for i in range(flat.shape[1])]
        return np.column_stack(columns).reshape(len(seconds), *values.shape[1:])

    position = at(track.pose[:, :2]) - pose[:, :2]
    spread = at(np.array([e.pose_covariance[:2, :2] for e in estimates]))
    speed = at(np.array([e.twist[:2] for e in estimates])) - twist[:, :2]
    speed_spread = at(np.array([e.twist_covariance[:2, :2] for e in estimates]))
    moved = np.hypot(pose[:, 0], pose[:, 1]) > _MOVED
    return (tuple(nees(position[moved], spread[moved]).tolist()),
            tuple(nees(speed, speed_spread).tolist()))


def nees(error: FloatArray, covariance: FloatArray) -> FloatArray:
    """e' P^-1 e (N,) of errors (N, D) and covariances (N, D, D)."""
    solved = np.linalg.solve(covariance, error[..., None])[..., 0]
    found: FloatArray = np.einsum('ni,ni->n', error, solved)
    return found
