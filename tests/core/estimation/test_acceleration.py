"""Compiled kernels (extra ``fast``) and plain numpy give the same track."""

import importlib.util
import json
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

HERE = pathlib.Path(__file__).parent
# runs in a process of its own: the switch is read on import
TRACK = """
import json, sys
sys.path.insert(0, sys.argv[1])
from staged_drive import estimator, frames, imu, merged, run, staged, wheel_angles
from mecanum_base.core.estimation import acceleration
motion = staged((0.8, (0, 0, 0)), (1.6, (0.5, 0.2, 0.8)))
angles = wheel_angles(motion, slip={0: (1.5, 1.9, 8.0)})
subject = estimator(smoothed=True)
found = run(subject, merged(imu(motion), frames(motion, angles)))
past, = (piece.smoothed() for piece in subject.past(last=True))
print(json.dumps([acceleration.COMPILED, [[*e.pose, *e.twist, *e.slip.probability]
                                          for e in found],
                  [[*a, *b] for a, b in zip(past.track.tolist(), past.slip.tolist())]]))
"""


def track(**environment):
    clean = {k: v for k, v in os.environ.items() if k not in ('MECANUM_BASE_FAST',
                                                              'NUMBA_DISABLE_JIT')}
    done = subprocess.run([sys.executable, '-c', TRACK, str(HERE)], env={**clean, **environment},
                          capture_output=True, text=True, timeout=900, check=True)
    compiled, rows, past = json.loads(done.stdout)
    return compiled, np.array(rows), np.array(past)


def test_plain_numpy_is_used_unless_asked_otherwise():
    compiled, rows, _ = track()
    assert not compiled
    assert len(rows) > 200


@pytest.mark.slow
@pytest.mark.skipif(os.environ.get('COMPILED_TESTS') != '1',
                    reason='compiling takes minutes: make compiled')
@pytest.mark.skipif(importlib.util.find_spec('numba') is None, reason='extra fast not installed')
def test_compiled_and_plain_tracks_agree_to_a_nanometre_and_a_nanoradian():
    compiled, fast, fast_past = track(MECANUM_BASE_FAST='1')
    assert compiled
    compiled, plain, past = track(MECANUM_BASE_FAST='0')
    assert not compiled
    assert fast.shape == plain.shape
    assert np.abs(fast[:, :3] - plain[:, :3]).max() < 1e-9
    # speeds and probabilities pass through more roundings, and are not promised to the last digit
    assert np.abs(fast[:, 3:] - plain[:, 3:]).max() < 1e-6
    # so do smoothed rows; their slip is given in rad/s, 20 times the m/s of the wheels
    assert fast_past.shape == past.shape and len(past) > 200
    assert np.abs(fast_past[:, :3] - past[:, :3]).max() < 1e-8
    assert np.abs(fast_past[:, 3:] - past[:, 3:]).max() < 2e-5
