"""Small builders the tests of the plant share."""

from __future__ import annotations

import dataclasses

import numpy as np

from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.sim import layout as at
from mecanum_base.sim.body import make_body
from mecanum_base.sim.config import SimConfig
from mecanum_base.sim.engine import choose
from mecanum_base.sim.floor import Floor
from mecanum_base.sim.plant import Plant

G = 9.80665
LX, LY, RADIUS = 0.20, 0.15, 0.05
PERFECT = dict(radius_error=0.0, common_radius_error=0.0, position_error=0.0, roller_error=0.0,
               runout=0.0, contact='mean')


def four_wheels(rollers: int = 0, pin: float = 0.0) -> Wheels:
    quarter = np.pi / 4
    return Wheels(joint=('fl', 'fr', 'rl', 'rr'), x=[LX, LX, -LX, -LX], y=[LY, -LY, LY, -LY],
                  axle=[np.pi / 2] * 4, roller=[quarter, -quarter, -quarter, quarter],
                  radius=[RADIUS] * 4, roller_count=[rollers] * 4, roller_pin_radius=[pin] * 4,
                  max_speed=[20.0] * 4)


def ring(count: int, arm: float = 0.2, radius: float = 0.05) -> Wheels:
    """``count`` Swedish wheels on a circle, axles pointing outwards."""
    angles = [2.0 * np.pi * k / count for k in range(count)]
    return Wheels(joint=tuple(f'w{k}' for k in range(count)), x=[arm * np.cos(a) for a in angles],
                  y=[arm * np.sin(a) for a in angles], axle=angles, roller=[np.pi / 2] * count,
                  radius=[radius] * count, max_speed=[20.0] * count)


def make_plant(base=None, floor=None, *, step=1e-3, **settings):
    """A plant on the quicker engine; test_engines_agree shows that both give the same."""
    engine = choose('auto', prefer_numba=True)
    config = dataclasses.replace(SimConfig(), **{**PERFECT, **settings})
    body = make_body(base or four_wheels(), config, np.zeros(3))
    return Plant(body, floor or Floor(), step=step, engine=engine, seed=config.seed)


def set_inputs(plant, place, values):
    for i, value in enumerate(np.broadcast_to(values, plant.body.count)):
        plant.inputs[i * at.INPUT + place] = float(value)


def set_velocity(plant, vx, vy, w):
    """Give the base a twist (of its mass centre) from rest at yaw 0."""
    plant.state[at.S_VX], plant.state[at.S_VY], plant.state[at.S_W] = vx, vy, w
