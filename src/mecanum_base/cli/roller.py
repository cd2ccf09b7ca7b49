"""`mecanum roller`: shape, size and limits of the rollers of a mecanum wheel."""

from __future__ import annotations

import argparse
import csv
import math
import pathlib

import numpy as np

from mecanum_base.cli.columns import align
from mecanum_base.core.contact.passage import lateral_peak, lateral_scale
from mecanum_base.core.errors import ConfigError
from mecanum_base.core.roller.mesh import roller_mesh, wheel_mesh
from mecanum_base.core.roller.shape import RollerShape, contact_curve, meridian
from mecanum_base.core.roller.sizing import Sizing, clear_pin_radius, neighbour_clearance, size
from mecanum_base.core.roller.torus import (
    axis_height_error,
    meridian_deviation,
    torus_of,
    torus_radius,
)

HELP = 'roller geometry of a mecanum wheel: sizes, torus approximation, drawing, mesh'
EXAMPLE = """mecanum roller --radius 0.05 --pin-radius 0.040 --count 9
mecanum roller --radius 0.05 --pin-radius 0.040 --count 9 --angle 45 --length 0.046 \\
    --stl roller.stl --svg roller.svg --csv roller.csv

exit codes: 0 fine, 1 the rollers are too short to take over from each other, 2 impossible wheel"""
_SAMPLES = 181  # rows of the CSV file, odd: the middle of the roller is one of them
_LARGEST = 2.0  # m; a larger wheel was given in millimetres
_RADIANS_UP_TO = 1.58  # bare angles up to here are radians, above degrees


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the verb."""
    parser.add_argument('--radius', metavar='M', type=float, required=True,
                        help='wheel radius over the rollers [m]')
    parser.add_argument('--pin-radius', metavar='M', type=float, required=True,
                        help='distance of the roller axes from the wheel axis [m]')
    parser.add_argument('--count', metavar='K', type=int, required=True, help='number of rollers')
    parser.add_argument('--angle', metavar='A', type=_angle, default=math.pi / 4.0,
                        help='roller axis from the wheel axle: degrees, or radians up to 1.58; '
                        '45deg and 0.785rad are clear in any case (default 45; --angle=-45deg)')
    parser.add_argument('--length', metavar='M', type=float,
                        help='length of the roller [m] (default: the shortest that takes over)')
    parser.add_argument('--bore', metavar='M', type=float, default=0.0,
                        help='radius of the hole for the pin in the STL files [m] (default solid)')
    parser.add_argument('--stl', metavar='FILE', type=pathlib.Path,
                        help='write the roller [mm], and the set of the wheel as FILE_set.stl')
    parser.add_argument('--svg', metavar='FILE', type=pathlib.Path,
                        help='draw meridian and torus side by side')
    parser.add_argument('--csv', metavar='FILE', type=pathlib.Path,
                        help='write meridian, torus and contact curve [m, rad]')


def _angle(text: str) -> float:
    for ending, scale in (('deg', math.pi / 180.0), ('rad', 1.0), ('', None)):
        if text.endswith(ending):
            try:
                value = float(text[:len(text) - len(ending)])
            except ValueError:
                break
            if scale is None:
                scale = 1.0 if abs(value) <= _RADIANS_UP_TO else math.pi / 180.0
            return value * scale
    raise argparse.ArgumentTypeError(f'{text!r} is no angle: write 45, 45deg or 0.785rad')


def run(options: argparse.Namespace) -> int:
    """Print and write; 1 where the rollers leave a gap. ConfigError for an impossible wheel."""
    if options.radius > _LARGEST:
        raise ConfigError('--radius', options.radius, 'is in metres: 50 mm is 0.05', 'm')
    shape = RollerShape(options.radius, options.pin_radius, options.angle)
    sizing = size(shape, options.count, options.length)
    print('\n'.join(_describe(shape, options.count, sizing)))
    if options.csv:
        _write_csv(options.csv, shape, sizing)
        print(f'written: {options.csv}')
    if options.svg:
        from mecanum_base.cli.roller_drawing import draw
        draw(options.svg, shape, options.count, sizing)
        print(f'written: {options.svg}')
    if options.stl:
        for path in _write_stl(options.stl, shape, options.count, sizing, options.bore):
            print(f'written: {path} [mm]')
    if sizing.contact_ratio < 1.0 - 1e-12:
        print(f'finding: the rollers are too short: between two of them the wheel axis drops by '
              f'{1e3 * sizing.axis_drop:.3f} mm; make them at least '
              f'{1e3 * sizing.min_length:.2f} mm long')
        return 1
    return 0


def _describe(shape: RollerShape, count: int, sizing: Sizing) -> list[str]:
    torus = torus_of(shape)
    u = np.array([sizing.half_range])
    rows = [
        ['shape', '', ''],
        ['  diameter in the middle', _mm(2 * sizing.equator_radius), '2 (r - d)'],
        ['  diameter at the hand-over', _mm(2 * sizing.handover_radius), 'G eq. 5 at pi/k'],
        ['  diameter at the ends', _mm(2 * sizing.end_radius), ''],
        ['length', '', ''],
        ['  chosen', _mm(sizing.length), ''],
        ['  shortest that takes over', _mm(sizing.min_length), '2 X*(pi/k)'],
        ['  longest (ends in a point)', _mm(sizing.max_length), '2 X*(acos(d/r))'],
        ['  contact ratio', f'{sizing.contact_ratio:.3f}', '>= 1: continuous contact'],
        ['torus instead of the exact meridian', '', ''],
        ['  meridian circle r_m', _mm(torus.meridian_radius), 'G eq. 9'],
        ['  centre circle r_t', _mm(torus.centre_radius), 'G eq. 8'],
        ['  deviation at the hand-over', _um(float(meridian_deviation(shape, u)[0])), ''],
        ['  axis height error there', _um(float(axis_height_error(shape, u)[0])), ''],
        ['contact', '', ''],
        ['  travel along the axle, per roller', _mm(sizing.contact_travel), ''],
    ]
    if abs(math.cos(shape.angle)) > 1e-9:
        rows += [['  peak wheel rate, sideways', f'+{100 * (lateral_peak(count) - 1):.2f} %',
                  'sec(pi/k) - 1'],
                 ['  sideways odometry over-reads by', f'{100 / lateral_scale(count) - 100:.2f} %',
                  'unless corrected']]
    gap = neighbour_clearance(shape, count, sizing.length)
    rows += [['neighbouring rollers (own check, no source)', '', ''],
             ['  clearance', 'ample' if math.isinf(gap) else _mm(gap), '< 0: they intersect']]
    lines = [f'wheel radius r = {_mm(shape.radius)}, pin radius d = {_mm(shape.pin_radius)}, '
             f'{count} rollers at {math.degrees(shape.angle):.4g} deg',
             *align(rows, indent='')]
    if gap < 0.0:
        clear = clear_pin_radius(shape, count, None if sizing.contact_ratio <= 1.0 + 1e-12
                                 else sizing.length)
        lines.append('note: full rollers of this size intersect; ' + (
            'no pin radius gives room for so many rollers' if clear is None else
            f'they clear each other from a pin radius of {_mm(clear)} on'))
    return lines


def _mm(value: float) -> str:
    return f'{1e3 * value:.3f} mm'


def _um(value: float) -> str:
    return f'{1e6 * value:+.1f} um'


def _write_csv(path: pathlib.Path, shape: RollerShape, sizing: Sizing) -> None:
    u = np.linspace(-sizing.reach, sizing.reach, _SAMPLES)
    along, radius = meridian(shape, u)
    columns = {'u': u, 'axis_position': along, 'radius': radius,
               'torus_radius': torus_radius(shape, along),
               'meridian_deviation': meridian_deviation(shape, u),
               'axis_height_error': axis_height_error(shape, u),
               **dict(zip(('contact_x', 'contact_y', 'contact_z'), contact_curve(shape, u).T))}
    try:
        with path.open('w', encoding='utf-8', newline='') as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            writer.writerows(zip(*(column.tolist() for column in columns.values())))
    except OSError as error:
        raise ConfigError(str(path), None, f'cannot be written: {error.strerror}') from None


def _write_stl(path: pathlib.Path, shape: RollerShape, count: int, sizing: Sizing,
               bore: float) -> tuple[pathlib.Path, pathlib.Path]:
    """One roller in its own axes and the set of rollers in wheel axes (x = axle), in mm."""
    import trimesh

    whole = path.with_name(f'{path.stem}_set{path.suffix or ".stl"}')
    meshes = ((path, roller_mesh(shape, sizing.length, bore=bore)),
              (whole, wheel_mesh(shape, count, sizing.length, bore=bore)))
    for target, (vertices, faces) in meshes:
        mesh = trimesh.Trimesh(1e3 * vertices, faces, process=False)
        try:
            mesh.export(str(target), file_type='stl')
        except OSError as error:
            raise ConfigError(str(target), None, f'cannot be written: {error.strerror}') from None
    return path, whole
