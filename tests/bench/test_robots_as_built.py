"""The fit of robots with a known truth finds errors that were put in by hand."""

import importlib.util
import pathlib
from types import SimpleNamespace

import numpy as np
import pytest

from mecanum_base.bag.analysis.motion import Gyro, WheelMotion
from mecanum_base.robot_file import shipped

RADII = np.array([0.004, 0.001, -0.001, 0.0])  # relative errors: 0.1 % together
LATERAL, LEVER, GYRO, CREEP = -0.002, 0.006, 0.01, 0.08
LOAD = 9.81 / 4.0


@pytest.fixture
def subject():
    path = pathlib.Path(__file__).with_name('robots_as_built.py')
    spec = importlib.util.spec_from_file_location('robots_as_built', path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def drive():
    """Time (N,) s, twist (N, 3) and its change: starts and turns along all axes, a minute."""
    t = np.arange(6000) * 0.01
    phase = np.array([0.5, 0.8, 0.35])
    twist = np.sin(np.outer(t, phase)) * [0.4, 0.3, 0.5]
    return t, twist, np.cos(np.outer(t, phase)) * phase * [0.4, 0.3, 0.5]


def test_what_was_put_in_by_hand_is_found(subject, tmp_path, monkeypatch):
    t, twist, change = drive()
    text = (shipped() / 'mecanum4.yaml').read_text().replace('[9, 9, 9, 9]', '[0, 0, 0, 0]')
    (tmp_path / 'robot.yaml').write_text(text)
    # textbook rows along the roller axes, lx + ly = 0.35 m
    rows = np.sqrt(0.5) * np.array([[1, -1, -0.35], [1, 1, 0.35], [1, 1, -0.35], [1, -1, 0.35]])
    felt = change[:, :2] + twist[:, 2:] * np.column_stack([-twist[:, 1], twist[:, 0]])
    smallest = np.linalg.lstsq(rows[:, :2].T, felt.T, rcond=None)[0].T
    slip = CREEP * np.hypot(*twist[:, :2].T)[:, None] * smallest / LOAD
    speed = (1.0 + RADII) * (twist * [1.0, 1.0 + LATERAL, 1.0 + LEVER] @ rows.T) + slip
    middle = 0.5 * (twist[1:] + twist[:-1])
    yaw = np.concatenate([[0.0], np.cumsum(middle[:, 2]) * 0.01])
    heading = 0.5 * (yaw[1:] + yaw[:-1])
    c, s = np.cos(heading), np.sin(heading)
    place = np.cumsum(np.column_stack([c * middle[:, 0] - s * middle[:, 1],
                                       s * middle[:, 0] + c * middle[:, 1]]), axis=0) * 0.01
    per_rate = 0.05 * np.sqrt(0.5)  # m/s along the roller axis for 1 rad/s
    np.savez(tmp_path / 'truth.npz', t=t, slip_rate=slip / per_rate, slip_speed_per_rate=per_rate,
             pose=np.column_stack([np.vstack([[0.0, 0.0], place]), yaw]))
    way = np.vstack([np.zeros(4), np.cumsum(0.5 * (speed[1:] + speed[:-1]), axis=0) * 0.01])
    stamp = np.round(t * 1e9).astype(np.int64)
    rate = np.column_stack([0.0 * t, 0.0 * t, (1.0 + GYRO) * twist[:, 2] + 0.02])
    monkeypatch.setattr(subject, 'evidence_of', lambda *_: SimpleNamespace(
        motion=WheelMotion(('a', 'b', 'c', 'd'), stamp, way / per_rate),
        gyro=Gyro(stamp, rate, np.full((len(t), 3), np.nan))))
    found = {name: float(value) for name, (value, _) in subject.of_run(tmp_path).items()}
    # 0.002 %: products of two errors, 0.4 x 0.6 %; creep: its acceleration is smoothed over 70 ms
    assert found == {
        'common radius %': pytest.approx(0.1, abs=0.002),
        'wheels %': pytest.approx(100.0 * np.std(RADII, ddof=1), abs=0.002),
        'lateral %': pytest.approx(100.0 * LATERAL, abs=0.002),
        'lever %': pytest.approx(100.0 * LEVER, abs=0.002),
        'gyro scale %': pytest.approx(100.0 * GYRO, abs=0.002),
        'creep': pytest.approx(CREEP, rel=0.01)}


def test_a_run_that_lacks_a_file_is_named(subject, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr('sys.argv', ['robots_as_built.py', str(tmp_path)])
    with pytest.raises(SystemExit, match='2'):
        subject.main()
    assert f'not found: {tmp_path / "robot.yaml"}' in capsys.readouterr().err
