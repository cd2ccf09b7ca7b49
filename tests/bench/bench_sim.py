"""Speed of the simulation, as a multiple of real time. Not a test: run it by hand.

    python tests/bench/bench_sim.py [--seconds 60]

1 kHz physics, IMU 200 Hz, encoders and truth 100 Hz, commands 50 Hz, exact contacts, all noise.
CPU time of this process is measured, best of three, so that a busy machine disturbs less.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import platform
import time

import numpy as np

from mecanum_base.core.estimation.sensors import EncoderConfig, ImuConfig
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.body import make_body
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.engine import numba_installed
from mecanum_base.sim.floor import Floor
from mecanum_base.sim.headless import run
from mecanum_base.sim.plant import Plant
from mecanum_base.sim.scenario import scenario_from_mapping

DRIVE = {'driver': {'figure8': {'length': 4.0, 'width': 2.0, 'speed': 0.6, 'spin': 0.3}}}


def ring(count: int) -> Wheels:
    """``count`` mecanum wheels in two rows."""
    pairs = count // 2
    x = [0.4 * (k / max(pairs - 1, 1) - 0.5) for k in range(pairs) for _ in range(2)]
    y = [side for _ in range(pairs) for side in (0.15, -0.15)]
    roller = [math.copysign(math.pi / 4, a * b) if a else math.copysign(math.pi / 4, b)
              for a, b in zip(x, y)]
    return Wheels(joint=tuple(f'w{k}' for k in range(count)), x=x, y=y,
                  axle=[math.pi / 2] * count, roller=roller, radius=[0.05] * count,
                  roller_count=[9] * count, roller_pin_radius=[0.038] * count,
                  max_speed=[20.0] * count)


def best(function, repeats: int = 3) -> float:
    """Least CPU seconds of some calls."""
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        function()
        times.append(time.process_time() - begin)
    return min(times)


def whole(base, engine: str, seconds: float) -> float:
    """Multiple of real time of a headless run with all sensors."""
    scenario = scenario_from_mapping({**DRIVE, 'duration': seconds}, 'bench')
    config = dataclasses.replace(SimConfig(), engine=engine)
    blocks = base, EncoderConfig(counts_per_revolution=4096.0), ImuConfig()
    run(scenario, *blocks, config, duration=0.2)  # compile
    return seconds / best(lambda: run(scenario, *blocks, config))


def physics(base, engine: str, seconds: float) -> float:
    """Microseconds of one physics step."""
    plant = Plant(make_body(base, SimConfig(), np.zeros(3)), Floor(), step=1e-3, engine=engine)
    for row in range(0, len(plant.inputs), 5):
        plant.inputs[row] = 5.0
    plant.advance(10)
    return 1e6 * best(lambda: plant.advance(round(seconds * 1000))) / (seconds * 1000)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=60.0, help='simulated time of a run')
    seconds = parser.parse_args().seconds
    four = load_robot(shipped() / 'mecanum4.yaml').base
    engines = ['plain', *(['numba'] if numba_installed() else [])]
    print(f'Python {platform.python_version()}, numpy {np.__version__}, {platform.machine()}')
    print(f'{"engine":8}{"wheels":>7}{"us per step":>13}{"x real time, all sensors":>27}')
    for engine in engines:
        length = seconds if engine == 'numba' else min(seconds, 10.0)
        for base in (four, *(ring(count) for count in (6, 8, 12))):
            print(f'{engine:8}{base.count:7}{physics(base, engine, length / 4):13.2f}'
                  f'{whole(base, engine, length):27.0f}')
    fast = engines[-1]
    print('several robots one after the other in one process (cost is the sum):')
    for robots in (1, 4, 16):
        length = seconds / 4 if fast == 'numba' else 2.0
        one = whole(four, fast, length)
        begin = time.process_time()
        scenario = scenario_from_mapping({**DRIVE, 'duration': length}, 'bench')
        config = dataclasses.replace(SimConfig(), engine=fast)
        for seed in range(robots):
            run(scenario, four, EncoderConfig(counts_per_revolution=4096.0), ImuConfig(), config,
                seed=seed)
        spent = time.process_time() - begin
        print(f'{robots:4} robots: {robots * length / spent:6.0f} robot-seconds a second '
              f'(one alone {one:.0f})')


if __name__ == '__main__':
    main()
