"""Random wheel sets, twists and numbers for property tests."""

import math

import numpy as np
from hypothesis import strategies as st

from mecanum_base.core.kinematics.mobility import assess
from mecanum_base.core.kinematics.wheels import Wheels


def numbers(low, high):
    return st.floats(low, high).map(lambda value: round(value, 4))


twists = st.tuples(numbers(-2, 2), numbers(-2, 2), numbers(-3, 3)).map(np.array)
ROLLERS = np.array([math.pi / 2, -math.pi / 2, math.pi / 4, -math.pi / 4, 2.4, -2.4, 1.2, -0.5])


def wheel_set(seed, count, counted):
    """Wheels anywhere, of any kind; ``counted``: with roller counts and pin radii."""
    draw = np.random.default_rng(seed)
    radius = draw.uniform(0.03, 0.12, count).round(4)
    counts = draw.integers(5, 17, count) if counted else np.zeros(count, dtype=int)
    limit = radius * np.cos(math.pi / np.maximum(counts, 3))
    odd = np.where(draw.random(count) < 0.5, -1.0, 1.0) * draw.uniform(0.35, 1.5, count).round(4)
    roller = np.where(draw.random(count) < 0.4, draw.choice(ROLLERS, count), odd)
    return Wheels(
        tuple(f'w{i}' for i in range(count)), draw.uniform(-0.5, 0.5, count).round(4),
        draw.uniform(-0.5, 0.5, count).round(4), draw.uniform(-3.1, 3.1, count).round(4), roller,
        radius, counts, limit * draw.uniform(0.3, 0.9, count) if counted else np.zeros(count))


def wheel_sets(low=3, high=6, counted=False):
    """Any wheel sets, sound or not. One seed draws all columns: quick, and easy to repeat."""
    return st.builds(wheel_set, st.integers(0, 10**6), st.integers(low, high), st.just(counted))


def mobile_sets(low=3, high=6, counted=False):
    """Wheel sets that hold the base well: condition above 0.1."""
    return wheel_sets(low, high, counted).filter(lambda w: assess(w).condition > 0.1)
