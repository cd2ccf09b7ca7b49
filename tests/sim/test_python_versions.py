"""The same seed gives the same readings with every supported Python that is found here.

Other interpreters are those named python3.10 to python3.13 (or in OTHER_PYTHONS, separated by ':')
that can import numpy and yaml; `make pythons` makes such environments first.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = HERE / 'one_run.py'
SOURCE = HERE.parents[1] / 'src'
ROUNDING = 1e-9  # m, rad, s ...; all versions seen so far agreed to the bit


def readings(python):
    """What the program prints with one interpreter; None where it lacks numpy or yaml."""
    environment = {k: v for k, v in os.environ.items()
                   if k not in ('LD_LIBRARY_PATH', '_ROS_WHEELS_BOOTSTRAP_COMPLETE')}
    if python != sys.executable:  # this one has the package already, and its ROS libraries
        environment['PYTHONPATH'] = str(SOURCE)
        asked = subprocess.run([python, '-c', 'import numpy, yaml'], env=environment,
                               capture_output=True, timeout=60)
        if asked.returncode:
            return None
    done = subprocess.run([python, PROGRAM], env=environment, capture_output=True, text=True,
                          timeout=300)
    assert done.returncode == 0, done.stderr[-500:]
    return json.loads(done.stdout)


def other_pythons():
    named = [path for path in os.environ.get('OTHER_PYTHONS', '').split(':') if path]
    return named or [f'python3.{minor}' for minor in (10, 11, 12, 13)
                     if minor != sys.version_info.minor and shutil.which(f'python3.{minor}')]


@pytest.mark.skipif(not SOURCE.is_dir(), reason='the sources are not beside the tests')
def test_other_versions_of_python_give_the_same_readings_to_rounding():
    found = [each for each in map(readings, other_pythons()) if each]
    if not found:
        pytest.skip('no other Python 3.10 to 3.13 with numpy and PyYAML here: see make pythons')
    own = readings(sys.executable)
    for other in found:
        for name, expected in own['readings'].items():
            got = other['readings'][name]
            assert len(got) == len(expected) > 500
            for ours, theirs in zip(expected, got):
                assert theirs[:2] == ours[:2], other['python']  # stream and time
                assert theirs[2:] == pytest.approx(ours[2:], rel=0.0, abs=ROUNDING,
                                                   nan_ok=True), other['python']
