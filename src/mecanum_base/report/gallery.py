"""Pictures of simulated runs: where the base went, on which floor, and how its wheels slipped.

One picture a scenario: the true path over the floor with its patches and walls, coloured by the
largest slip of any wheel; beside it speeds, slip of every wheel and the events over time.
"""

from __future__ import annotations

import base64
import html
import io
import pathlib
from collections.abc import Callable
from typing import Any

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from mecanum_base.core.parameter import FloatArray
from mecanum_base.robot import Robot
from mecanum_base.robot_file import load_robot, shipped
from mecanum_base.sim.body import make_body
from mecanum_base.sim.faults import NANOSECONDS
from mecanum_base.sim.headless import Run
from mecanum_base.sim.headless import run as simulate
from mecanum_base.sim.layout import W_RADIUS, WHEEL
from mecanum_base.sim.scenario import Scenario
from mecanum_base.sim.scenario_file import load_scenario, shipped_scenarios

SLIP_SHOWN = 0.3  # m/s, slip at which the colour of the path is full
SLIPPING = 0.05  # m/s, slip that counts as slipping in the table
_MARK = 4.0  # s between heading marks on the path
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Simulated scenarios</title><style>
:root {{ color-scheme: light dark; }}
body {{ font: 16px/1.5 system-ui, sans-serif; margin: 0 auto; padding: 1.2rem; max-width: 76rem; }}
img {{ width: 100%; height: auto; background: #fff; border-radius: .4rem; }}
h2 {{ margin: 2.2rem 0 .2rem; }} p {{ margin: .2rem 0 .6rem; }} td, th {{ padding: .15rem .8rem;
text-align: right; }} td:first-child, th:first-child {{ text-align: left; }}
.wide {{ overflow-x: auto; }} table {{ border-collapse: collapse; }}
</style></head><body>
<h1>Simulated scenarios</h1>
<p>Truth of the simulator, not an estimate. Path colour and lower curves: slip speed at the contact
of the wheel, along its roller axis.</p>
<div class="wide"><table><tr><th>scenario</th><th>duration s</th><th>way m</th>
<th>top speed m/s</th>
<th>largest slip m/s</th><th>time with slip</th></tr>
{rows}</table></div>
{sections}
</body></html>
"""


def write_gallery(out: pathlib.Path, name: str | None, seed: int | None, duration: float | None,
                  robot_file: str | None, progress: Callable[[float, str], None]) -> pathlib.Path:
    """Run the scenario ``name`` (None: all shipped ones), draw each; returns the page written."""
    names = [name] if name is not None else list(shipped_scenarios())
    out.mkdir(parents=True, exist_ok=True)
    rows, sections = [], []
    for index, each in enumerate(names):
        scenario = load_scenario(each)
        progress(index / len(names), scenario.name)
        robot = load_robot(robot_file or shipped() / scenario.robot)
        run = simulate(scenario, robot.base, robot.encoder, robot.imu, robot.sim, seed=seed,
                       duration=duration)
        slip = slip_speed(run, robot, scenario)
        picture = io.BytesIO()
        figure = draw(scenario, run, slip)
        figure.savefig(picture, format='png', dpi=90)
        (out / f'{scenario.name}.png').write_bytes(picture.getvalue())
        rows.append(_row(scenario, run, slip))
        sections.append(
            f'<h2 id="{html.escape(scenario.name)}">{html.escape(scenario.name)}</h2>'
            f'<p>{html.escape(scenario.title)}; seed {run.seed}, '
            f'{html.escape(pathlib.Path(robot_file or scenario.robot).name)}</p>'
            f'<img alt="{html.escape(scenario.title)}" '
            f'src="data:image/png;base64,{base64.b64encode(picture.getvalue()).decode()}">')
    page = out / 'gallery.html'
    page.write_text(_PAGE.format(rows='\n'.join(rows), sections='\n'.join(sections)),
                    encoding='utf-8')
    return page


def slip_speed(run: Run, robot: Robot, scenario: Scenario) -> FloatArray:
    """Slip (N, W) m/s along the roller axes, from the true slip rates and geometry."""
    body = make_body(robot.base, scenario.settings(robot.sim), robot.imu.xyz)
    sines = [body.wheels[k + 5] for k in range(0, len(body.wheels), WHEEL)]
    lever = np.abs(np.array(body.wheels[W_RADIUS::WHEEL]) * np.array(sines))
    speed: FloatArray = run.slip_rate * lever
    return speed


def _row(scenario: Scenario, run: Run, slip: FloatArray) -> str:
    way = float(np.sum(np.hypot(*np.diff(run.pose[:, :2], axis=0).T)))
    worst = np.max(np.abs(slip), axis=1)
    cells = (f'<a href="#{html.escape(scenario.name)}">{html.escape(scenario.name)}</a>',
             f'{(run.end_ns - run.start_ns) / NANOSECONDS:.0f}', f'{way:.1f}',
             f'{np.max(np.hypot(run.twist[:, 0], run.twist[:, 1])):.2f}', f'{np.max(worst):.2f}',
             f'{np.mean(worst > SLIPPING):.1%}')
    return '<tr>' + ''.join(f'<td>{cell}</td>' for cell in cells) + '</tr>'


def draw(scenario: Scenario, run: Run, slip: FloatArray) -> Figure:
    """The picture of one run; ``slip`` (N, W) m/s."""
    figure = Figure(figsize=(13.0, 5.6), layout='constrained')
    grid = figure.add_gridspec(2, 2, width_ratios=[1.15, 1.0])
    where = figure.add_subplot(grid[:, 0])
    speeds = figure.add_subplot(grid[0, 1])
    slips = figure.add_subplot(grid[1, 1], sharex=speeds)
    _draw_floor(where, scenario, run)
    _draw_path(figure, where, run, slip)
    time = (run.stamp_ns - run.start_ns) / NANOSECONDS
    for column, label in enumerate(('vx [m/s]', 'vy [m/s]', 'wz [rad/s]')):
        speeds.plot(time, run.twist[:, column], lw=0.9, label=label)
    for column, joint in enumerate(run.joints):
        slips.plot(time, slip[:, column], lw=0.8, label=joint.replace('_wheel_joint', ''))
    slips.axhspan(-SLIPPING, SLIPPING, color='0.92', zorder=0)
    for axes, title in ((speeds, 'true speed in base_link'),
                        (slips, 'slip [m/s], grey: rolls')):
        axes.set_title(title, fontsize=10, loc='left')
        axes.grid(alpha=0.25)
        axes.legend(loc='lower right', bbox_to_anchor=(1.01, 0.97), fontsize=7, frameon=False,
                    ncols=min(len(run.joints), 4), columnspacing=1.0, handlelength=1.5)
        for event in scenario.events:
            if event.start_ns <= run.end_ns - run.start_ns:
                begin = event.start_ns / NANOSECONDS
                axes.axvspan(begin, max(event.end_ns / NANOSECONDS, begin + 0.05), color='tab:red',
                             alpha=0.12, lw=0)
                if axes is speeds:
                    axes.annotate(event.kind, (begin, 0.02), xycoords=('data', 'axes fraction'),
                                  rotation=90, fontsize=6, va='bottom', ha='right')
    slips.set_xlabel('time [s]')
    return figure


def _draw_floor(axes: Any, scenario: Scenario, run: Run) -> None:
    colours = matplotlib.colormaps['YlGnBu_r']
    for patch in scenario.floor.patches:
        colour = colours(min(patch.friction, 1.0))
        if len(patch.centre):
            shape: Any = Circle((float(patch.centre[0]), float(patch.centre[1])), patch.radius)
            x, y = float(patch.centre[0]), float(patch.centre[1]) + patch.radius
        else:
            low, left = (float(patch.x[0]), float(patch.y[0]))
            shape = Rectangle((low, left), float(patch.x[1]) - low, float(patch.y[1]) - left)
            x, y = low, min(float(patch.y[1]), float(np.max(run.pose[:, 1])) + 0.3)
        shape.set(facecolor=colour, alpha=0.28, edgecolor='0.4', lw=0.6)
        axes.add_patch(shape)
        axes.annotate(f'{patch.name} {patch.friction:g}', (x, y), fontsize=7, va='top', zorder=4,
                      bbox={'facecolor': 'white', 'alpha': 0.7, 'edgecolor': 'none', 'pad': 1.0})
    for ramp in scenario.floor.ramps:
        axes.axvspan(ramp.begin, ramp.end, color='tab:brown', alpha=0.12, lw=0)
    for wall in scenario.floor.walls:
        x, y = (float(v) for v in wall.point)
        axes.axline((x, y), (x - np.sin(wall.facing), y + np.cos(wall.facing)), color='k', lw=3)


def _draw_path(figure: Figure, axes: Any, run: Run, slip: FloatArray) -> None:
    every = max(1, len(run.pose) // 4000)
    points, worst = run.pose[::every, :2], np.max(np.abs(slip), axis=1)[::every]
    lines = LineCollection(list(np.stack([points[:-1], points[1:]], axis=1)), cmap='turbo',
                           norm=matplotlib.colors.Normalize(0.0, SLIP_SHOWN), lw=1.8)
    lines.set_array(worst[1:])
    axes.add_collection(lines)
    step = max(1, int(_MARK * len(run.pose) / max((run.end_ns - run.start_ns) / NANOSECONDS, 1.0)),
               len(run.pose) // 60)
    marks = run.pose[::step]
    axes.quiver(marks[:, 0], marks[:, 1], np.cos(marks[:, 2]), np.sin(marks[:, 2]), width=0.003,
                scale=28, color='0.35', zorder=3)
    axes.plot(*run.pose[0, :2], 'o', color='tab:green', ms=6)
    axes.plot(*run.pose[-1, :2], 's', color='tab:red', ms=5)
    reach = np.array([run.pose[:, :2].min(axis=0), run.pose[:, :2].max(axis=0)])
    middle, half = reach.mean(axis=0), max(float(np.max(np.ptp(reach, axis=0))) / 2 * 1.15, 0.15)
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half),
             xlabel='x [m]', ylabel='y [m]', aspect='equal')
    axes.set_title('true path; colour = largest slip, arrows = heading', fontsize=10, loc='left')
    axes.grid(alpha=0.25)
    figure.colorbar(lines, ax=axes, shrink=0.6, label='slip [m/s]', extend='max')
