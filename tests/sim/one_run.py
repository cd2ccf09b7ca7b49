"""One seeded run, printed as JSON: every reading as exact numbers. Needs numpy and PyYAML only.

    python tests/sim/one_run.py            (with the package importable)
"""

import json
import math
import platform

import numpy as np

from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.headless import run
from mecanum_base.sim.scenario_file import load_scenario

SECONDS = {('mecanum4.yaml', 'oil'): 4.0, ('dual_differential.yaml', 'carriers'): 2.0}


def readings():
    """{run: [[stream, at_ns, numbers ...], ...]}, all of it in order of publication."""
    found = {}
    for (robot_name, scenario), seconds in SECONDS.items():
        robot = load_robot(shipped() / robot_name)
        done = run(load_scenario(scenario), robot.base, robot.encoder, robot.imu, robot.sim,
                   duration=seconds)
        found[scenario] = [[type(item.reading).__name__, item.at_ns, *_numbers(item.reading)]
                           for item in done.published]
    return found


def _numbers(reading):
    for name in type(reading).__dataclass_fields__:
        value = getattr(reading, name)
        if value is not None:
            for number in np.asarray(value, dtype=np.float64).ravel().tolist():
                yield None if math.isnan(number) else number


if __name__ == '__main__':
    print(json.dumps({'python': platform.python_version(), 'numpy': np.__version__,
                      'readings': readings()}))
