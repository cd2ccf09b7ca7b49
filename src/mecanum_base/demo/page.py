"""The HTML page of a demo run: tracks, wheel speeds, slip timeline, covariance."""

from __future__ import annotations

import math
import pathlib

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mecanum_base.demo.result import DemoResult
from mecanum_base.demo.table import error_rows
from mecanum_base.report.page import Section, Table, write_page

TRUTH, WHEELS, FUSED = '#7f8a96', '#e07b00', '#0b7fd6'
WHEEL_COLOURS = ('#0b7fd6', '#e07b00', '#2a9d5c', '#b0479e', '#c4413b', '#7a6ae0')
MOST_POINTS = 4000  # a curve is thinned to this many points, the page stays small


def write_demo_page(path: pathlib.Path, result: DemoResult) -> None:
    """Write the page of one demo run."""
    wheel, fused, score = result.wheel_only_error, result.fused_error, result.score
    facts = {
        'driven': f'{result.path_length:.1f} m',
        'position error at the end, fused': f'{100 * fused.final_distance:.1f} cm',
        'position error at the end, wheel-only': f'{100 * wheel.final_distance:.1f} cm',
        'yaw error at the end, fused': f'{math.degrees(fused.final_yaw):+.2f}°',
        'yaw error at the end, wheel-only': f'{math.degrees(wheel.final_yaw):+.2f}°',
        'slip episodes found': f'{score.found} of {len(score.true)}, {len(score.false)} false',
    }
    sections = [
        Section('Errors against the truth',
                table=Table(('', 'wheel-only', 'fused'), error_rows(result))),
        Section('Trajectories', ('Truth, wheel-only odometry and the published odometry, all '
                                 'starting at 0, 0, 0; nothing is aligned.',),
                figure=_trajectories(result)),
        Section('Error and covariance', (
            'Position error of the published odometry inside the band its own covariance allows '
            '(95 %). A band below the curve would be a covariance that is too sure.',),
                figure=_errors(result)),
        Section('Slip', (
            'Upper: probability that each wheel slips, as published on slip/probability. '
            'Lower: estimated (lines) and true (dotted) slip speed along the roller axes.',),
                figure=_slip(result)),
        Section('Wheel speeds', ('Measured wheel rates; commanded ones dotted.',),
                figure=_wheels(result)),
    ]
    write_page(path, f'mecanum_base demo: {result.name}',
               'Nodes over ROS 2 topics in stepped time: cmd_vel to wheel speeds, simulated '
               'hardware, odometry and slip from encoders and IMU, compared with the truth.',
               sections, facts)


def _thin(count: int) -> slice:
    return slice(None, None, max(1, math.ceil(count / MOST_POINTS)))



def _phases(figure: go.Figure, result: DemoResult) -> None:
    for phase in result.phases:
        start = float(result.seconds(np.array([phase.start_ns]))[0])
        figure.add_vline(x=start, line=dict(color=TRUTH, width=1, dash='dot'))
        figure.add_annotation(x=start, y=1.0, yref='paper', text=phase.name, showarrow=False,
                              xanchor='left', yanchor='top', font=dict(size=11))


def _trajectories(result: DemoResult) -> go.Figure:
    figure = go.Figure()
    for name, track, colour, width in (('truth', result.truth, TRUTH, 5),
                                       ('wheel-only', result.wheel_only, WHEELS, 2),
                                       ('fused', result.fused, FUSED, 2)):
        part = track.pose[_thin(len(track.pose))]
        figure.add_scatter(x=np.round(part[:, 0], 4), y=np.round(part[:, 1], 4), name=name,
                           mode='lines', line=dict(color=colour, width=width))
    figure.update_xaxes(title='x [m]')
    figure.update_yaxes(title='y [m]', scaleanchor='x', scaleratio=1)
    figure.update_layout(height=560)
    return figure


def _errors(result: DemoResult) -> go.Figure:
    figure = go.Figure()
    fused, wheel = result.fused_error, result.wheel_only_error
    bound = result.own_bound()
    if bound is not None:
        part = _thin(len(bound[0]))
        figure.add_scatter(
            x=bound[0][part], y=np.round(bound[1], 5)[part], mode='lines',
            name='95 % of its own covariance', fill='tozeroy',
            line=dict(color=FUSED, width=0), fillcolor='rgba(11,127,214,0.18)')
    for name, error, colour in (('wheel-only', wheel, WHEELS), ('fused', fused, FUSED)):
        part = _thin(len(error.distance))
        figure.add_scatter(x=result.seconds(error.stamp_ns)[part],
                           y=np.round(error.distance, 5)[part], name=name, mode='lines',
                           line=dict(color=colour, width=2))
    _phases(figure, result)
    figure.update_xaxes(title='time [s]')
    figure.update_yaxes(title='position error [m]', rangemode='tozero')
    figure.update_layout(height=380)
    return figure


def _slip(result: DemoResult) -> go.Figure:
    slip = result.slip
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, row_heights=[0.4, 0.6],
                           vertical_spacing=0.08)
    part, true_part = _thin(len(slip.stamp)), _thin(len(slip.true_stamp))
    figure.add_heatmap(x=result.seconds(slip.stamp)[part], y=list(result.joint),
                       z=np.round(slip.probability[part].T, 3), zmin=0.0, zmax=1.0,
                       colorscale=[[0, 'rgba(127,138,150,0.12)'], [1, '#c4413b']],
                       colorbar=dict(title='P(slip)', len=0.4, y=0.8), row=1, col=1)
    for index, joint in enumerate(result.joint):
        colour = WHEEL_COLOURS[index % len(WHEEL_COLOURS)]
        figure.add_scatter(x=result.seconds(slip.stamp)[part],
                           y=np.round(slip.speed[part, index], 4), name=joint, mode='lines',
                           line=dict(color=colour, width=1.5), row=2, col=1)
        figure.add_scatter(x=result.seconds(slip.true_stamp)[true_part],
                           y=np.round(slip.true_speed[true_part, index], 4), mode='lines',
                           name=f'{joint} (true)', showlegend=False,
                           line=dict(color=colour, width=1.5, dash='dot'), row=2, col=1)
    figure.update_xaxes(title='time [s]', row=2, col=1)
    figure.update_yaxes(title='slip speed [m/s]', row=2, col=1)
    figure.update_yaxes(automargin=True, row=1, col=1)
    figure.update_layout(height=560)
    return figure


def _wheels(result: DemoResult) -> go.Figure:
    figure = go.Figure()
    wheels = result.wheels
    part, sent = _thin(len(wheels.stamp)), _thin(len(wheels.command_stamp))
    for index, joint in enumerate(result.joint):
        colour = WHEEL_COLOURS[index % len(WHEEL_COLOURS)]
        figure.add_scatter(x=result.seconds(wheels.stamp)[part],
                           y=np.round(wheels.rate[part, index], 3), name=joint, mode='lines',
                           line=dict(color=colour, width=1.5))
        figure.add_scatter(x=result.seconds(wheels.command_stamp)[sent],
                           y=np.round(wheels.command[sent, index], 3), name=f'{joint} (commanded)',
                           mode='lines', line=dict(color=colour, width=1.5, dash='dot'),
                           showlegend=False)
    _phases(figure, result)
    figure.update_xaxes(title='time [s]')
    figure.update_yaxes(title='wheel rate [rad/s]')
    figure.update_layout(height=380)
    return figure
