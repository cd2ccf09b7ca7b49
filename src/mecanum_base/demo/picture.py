"""The PNG of a demo run: trajectories, position error, slip."""

from __future__ import annotations

import pathlib

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mecanum_base.demo.result import DemoResult

TRUTH, WHEELS, FUSED = '0.6', '#e07b00', '#0b7fd6'


def write_picture(path: pathlib.Path, result: DemoResult) -> None:
    """Draw the run into ``path`` (PNG)."""
    figure = Figure(figsize=(12.0, 6.2), layout='constrained')
    axes = figure.subplot_mosaic([['way', 'error'], ['way', 'slip']], width_ratios=[1.0, 1.15])
    _way(axes['way'], result)
    _error(axes['error'], result)
    _slip(axes['slip'], result)
    figure.suptitle(f'mecanum_base demo: {result.name}', fontsize=13)
    figure.savefig(path, dpi=110)


def _way(axes: Axes, result: DemoResult) -> None:
    for label, track, colour, width in (('truth', result.truth, TRUTH, 5.0),
                                        ('wheel-only', result.wheel_only, WHEELS, 1.6),
                                        ('fused', result.fused, FUSED, 1.6)):
        axes.plot(track.pose[:, 0], track.pose[:, 1], color=colour, linewidth=width, label=label)
    axes.set(xlabel='x [m]', ylabel='y [m]', aspect='equal')
    axes.grid(alpha=0.3)
    _legend(axes, 'Trajectories')


def _legend(axes: Axes, title: str) -> None:
    """Title and legend in the line above the plot, so that they hide nothing."""
    axes.set_title(title, loc='left')
    axes.legend(frameon=False, fontsize=9, ncols=3, loc='lower right', borderaxespad=0.1,
                bbox_to_anchor=(1.0, 1.0), columnspacing=1.2, handlelength=1.4)


def _error(axes: Axes, result: DemoResult) -> None:
    fused, wheel = result.fused_error, result.wheel_only_error
    bound = result.own_bound()
    if bound is not None:
        axes.fill_between(bound[0], 0, bound[1], color=FUSED, alpha=0.15, linewidth=0,
                          label='95 % of its covariance')
    axes.plot(result.seconds(wheel.stamp_ns), wheel.distance, color=WHEELS, label='wheel-only')
    axes.plot(result.seconds(fused.stamp_ns), fused.distance, color=FUSED, label='fused')
    _phases(axes, result)
    axes.set(ylabel='error [m]', ylim=(0, None))
    _legend(axes, 'Position error')


def _slip(axes: Axes, result: DemoResult) -> None:
    slip = result.slip
    true = np.max(np.abs(slip.true_speed), axis=1)
    seconds = result.seconds(slip.true_stamp)
    axes.plot(seconds, true, color=TRUTH, linewidth=3.0, label='true, worst wheel')
    index = np.argmax(np.abs(slip.speed) * (slip.probability > 0.5), axis=1)
    claimed = np.where(slip.body_probability >= 0.5,
                       np.abs(slip.speed)[np.arange(len(index)), index], 0.0)
    axes.plot(result.seconds(slip.stamp), claimed, color=FUSED, linewidth=1.2,
              label='claimed, worst wheel')
    axes.fill_between(result.seconds(slip.stamp), 0, slip.body_probability,
                      transform=axes.get_xaxis_transform(), color='#c4413b', alpha=0.18,
                      linewidth=0, label='P(any wheel slips)')
    _phases(axes, result)
    axes.set(xlabel='time [s]', ylabel='slip speed [m/s]', ylim=(0, None))
    _legend(axes, 'Slip')


def _phases(axes: Axes, result: DemoResult) -> None:
    for phase in result.phases:
        start = float(result.seconds(np.array([phase.start_ns]))[0])
        axes.axvline(start, color='0.7', linewidth=0.8, linestyle=':')
        axes.text(start, 0.98, f' {phase.name}', transform=axes.get_xaxis_transform(),
                  va='top', fontsize=8, color='0.35')
