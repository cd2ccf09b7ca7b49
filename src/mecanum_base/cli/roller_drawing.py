"""Dimensioned drawing of a roller: exact meridian and torus side by side, their gap below."""

from __future__ import annotations

import math
import pathlib
from typing import Any

import numpy as np

from mecanum_base.core.errors import ConfigError
from mecanum_base.core.roller.shape import RollerShape, meridian
from mecanum_base.core.roller.sizing import Sizing
from mecanum_base.core.roller.torus import meridian_deviation, torus_of, torus_radius

ROUND = '\u00d8'  # sign of a diameter
INK, SHADE, THIN, MARK = '#1b2733', '#dbe4ee', '#6b7a89', '#b3541e'


def draw(path: pathlib.Path, shape: RollerShape, count: int, sizing: Sizing) -> None:
    """Write the drawing as SVG [mm]; ConfigError where the file cannot be written."""
    import matplotlib

    matplotlib.use('svg')
    import matplotlib.pyplot as plt

    settings: dict[Any, Any] = {
        'svg.fonttype': 'none', 'svg.hashsalt': 'mecanum_base', 'font.size': 9.0,
        'font.family': 'sans-serif', 'axes.edgecolor': THIN}
    with plt.rc_context(settings):
        figure, grid = plt.subplots(2, 2, figsize=(11.0, 6.4), height_ratios=(3.0, 1.3),
                                    constrained_layout=True)
        figure.suptitle(
            f'Roller of a mecanum wheel: r = {1e3 * shape.radius:g} mm, d = '
            f'{1e3 * shape.pin_radius:g} mm, {count} rollers at '
            f'{math.degrees(shape.angle):.4g} deg, lengths in mm', color=INK)
        _exact(grid[0, 0], shape, sizing)
        _torus(grid[0, 1], shape, sizing)
        _gap(grid[1, 0], shape, sizing)
        _radii(grid[1, 1], shape, sizing)
        try:
            figure.savefig(path, format='svg', metadata={'Date': None})
        except OSError as error:
            raise ConfigError(str(path), None, f'cannot be written: {error.strerror}') from None
        finally:
            plt.close(figure)


def _profile(shape: RollerShape, sizing: Sizing) -> tuple[Any, Any, Any]:
    """(u, axis position, radius) in rad, mm, mm, axis position rising."""
    u = np.linspace(-sizing.reach, sizing.reach, 241)
    along, radius = meridian(shape, u)
    order = np.argsort(along)
    return u[order], 1e3 * along[order], 1e3 * radius[order]


def _outline(axes: Any, along: Any, radius: Any, title: str, sizing: Sizing) -> None:
    axes.fill_between(along, -radius, radius, facecolor=SHADE, edgecolor='none')
    axes.plot(np.concatenate([along, along[::-1], along[:1]]),
              np.concatenate([radius, -radius[::-1], radius[:1]]), color=INK, linewidth=1.4)
    reach, top = 0.5e3 * sizing.length, 1e3 * sizing.equator_radius
    axes.plot([-1.15 * reach, 1.15 * reach], [0.0, 0.0], color=THIN, linewidth=0.8,
              dashes=(10, 3, 2, 3))
    axes.set_title(title, color=INK)
    axes.set_aspect('equal')
    axes.set_xlim(-1.6 * reach, 1.6 * reach)
    axes.set_ylim(-2.15 * top, 2.0 * top)
    axes.axis('off')


def _width(axes: Any, left: float, right: float, level: float, edge: float, text: str) -> None:
    """A horizontal dimension line at ``level`` with extension lines from ``edge``."""
    for x in (left, right):
        axes.plot([x, x], [edge, level * 1.04], color=THIN, linewidth=0.6)
    axes.annotate('', (left, level), (right, level),
                  arrowprops={'arrowstyle': '<|-|>', 'color': THIN, 'linewidth': 0.8,
                              'shrinkA': 0, 'shrinkB': 0})
    axes.text(0.5 * (left + right), level, text, ha='center', va='center', color=INK,
              bbox={'facecolor': 'white', 'edgecolor': 'none', 'pad': 1.5})


def _height(axes: Any, low: float, high: float, place: float, edge: float, text: str) -> None:
    """A vertical dimension line at ``place`` with extension lines from ``edge``."""
    for y in (low, high):
        axes.plot([edge, place * 1.03], [y, y], color=THIN, linewidth=0.6)
    axes.annotate('', (place, low), (place, high),
                  arrowprops={'arrowstyle': '<|-|>', 'color': THIN, 'linewidth': 0.8,
                              'shrinkA': 0, 'shrinkB': 0})
    axes.text(place, 0.5 * (low + high), text, ha='center', va='center', color=INK, rotation=90,
              bbox={'facecolor': 'white', 'edgecolor': 'none', 'pad': 1.5})


def _exact(axes: Any, shape: RollerShape, sizing: Sizing) -> None:
    _, along, radius = _profile(shape, sizing)
    _outline(axes, along, radius, 'exact meridian', sizing)
    reach, top, end = 0.5e3 * sizing.length, 1e3 * sizing.equator_radius, 1e3 * sizing.end_radius
    _width(axes, -reach, reach, -1.45 * top, -end, f'L = {2 * reach:.2f}')
    _height(axes, -top, top, -1.32 * reach, 0.0, f'{ROUND} {2 * top:.2f}')
    _height(axes, -end, end, 1.32 * reach, reach, f'{ROUND} {2 * end:.2f}')
    take = 0.5e3 * sizing.min_length
    if take <= reach * (1.0 + 1e-9):
        hand = 1e3 * sizing.handover_radius
        for x in (-take, take):
            axes.plot([x, x], [-hand, hand], color=MARK, linewidth=1.0, dashes=(3, 2))
        _width(axes, -take, take, 1.4 * top, hand,
               f'hand-over {2 * take:.2f}, {ROUND} {2 * hand:.2f}')
    else:
        axes.text(0.0, 1.4 * top, f'too short: {2 * take:.2f} needed', ha='center', color=MARK)


def _torus(axes: Any, shape: RollerShape, sizing: Sizing) -> None:
    torus = torus_of(shape)
    reach, top = 0.5e3 * sizing.length, 1e3 * sizing.equator_radius
    along = np.linspace(-reach, reach, 241)
    radius = 1e3 * torus_radius(shape, 1e-3 * along)
    _outline(axes, along, radius, 'torus (G eq. 8, 9)', sizing)
    end = float(radius[-1])
    _width(axes, -reach, reach, -1.45 * top, -end, f'L = {2 * reach:.2f}')
    _height(axes, -top, top, -1.32 * reach, 0.0, f'{ROUND} {2 * top:.2f}')
    _height(axes, -end, end, 1.32 * reach, reach, f'{ROUND} {2 * end:.2f}')
    axes.annotate(f'r_m = {1e3 * torus.meridian_radius:.2f}',
                  (0.35 * reach, float(np.interp(0.35 * reach, along, radius))),
                  (0.55 * reach, 1.55 * top), color=INK, ha='left',
                  arrowprops={'arrowstyle': '-|>', 'color': THIN, 'linewidth': 0.8})
    axes.text(0.0, -1.95 * top, f'centre of the arc r_t = {1e3 * torus.centre_radius:.2f} beyond '
              'the axis', ha='center', color=THIN)


def _gap(axes: Any, shape: RollerShape, sizing: Sizing) -> None:
    u, along, _ = _profile(shape, sizing)
    axes.plot(along, 1e6 * meridian_deviation(shape, u), color=MARK)
    axes.set_xlabel('along the roller axis [mm]')
    axes.set_ylabel('exact - torus [um]')
    axes.grid(color='#e3e8ed', linewidth=0.6)


def _radii(axes: Any, shape: RollerShape, sizing: Sizing) -> None:
    u, along, radius = _profile(shape, sizing)
    axes.plot(along, radius, color=INK, label='exact')
    axes.plot(along, 1e3 * torus_radius(shape, 1e-3 * along), color=MARK, dashes=(4, 2),
              label='torus')
    axes.set_xlabel('along the roller axis [mm]')
    axes.set_ylabel('radius [mm]')
    axes.legend(frameon=False)
    axes.grid(color='#e3e8ed', linewidth=0.6)
