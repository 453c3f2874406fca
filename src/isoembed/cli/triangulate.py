"""``isoembed triangulate``: triangulation of a smooth 2-metric with geodesic edge lengths."""

import argparse

import numpy as np

from isoembed.cli.closed_form import OF_SPACETIME, add_spacetime_options, closed_form
from isoembed.cli.console import OK, UsageError, print_aside
from isoembed.cli.options import add_output_option, refuse_given
from isoembed.cli.outputs import written
from isoembed.io import METRIC_ENDINGS, check_output, metric_writer, write_atomically
from isoembed.meshing.spreading import WHOLE, Zone
from isoembed.relativity.horizons.grid_file import read_metric_grid
from isoembed.smooth.triangulation import triangulate_metric
from isoembed.smooth.two_metric import AngleMetric, TwoMetric
from isoembed.space import Space

EXAMPLES = (
    "isoembed triangulate grid.npz --vertices 500 -o metric.npz",
    "isoembed triangulate --spacetime kerr --spin 0.5 --surface horizon --vertices 500 -o metric.npz",
)
USUAL = (
    "spacetime",
    "surface",
    "mass",
    "spin",
    "disc",
    "vertices",
    "size",
    "grading",
    "output",
    "quiet",
)
"""Options listed by ``--help``."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed triangulate``."""
    parser.add_argument(
        "input",
        nargs="?",
        metavar="GRID",
        help="a metric on a grid: .npz .h5 .hdf5 .csv .txt .dat with theta, phi, q_tt, q_tp, q_pp",
    )
    add_spacetime_options(parser)
    parser.add_argument(
        "--disc",
        type=float,
        nargs=2,
        metavar=("K", "R"),
        help="instead: a geodesic disc of curvature K and radius R",
    )
    parser.add_argument(
        "--zone",
        type=float,
        nargs=2,
        metavar=("START", "STOP"),
        help="part of the surface between two angles theta, in radians: a disc about a pole, or a band",
    )
    number = parser.add_mutually_exclusive_group(required=True)
    number.add_argument("--vertices", type=int, metavar="N", help="number of vertices, at least 12")
    number.add_argument("--size", type=float, metavar="L", help="mean edge length, in the metric's unit")
    parser.add_argument(
        "--grading",
        type=float,
        default=0.0,
        metavar="G",
        help="ratio of vertices distributed by curvature to those distributed by area; 0.1 suits sharp "
        "tips (default 0: uniform triangles)",
    )
    add_output_option(
        parser,
        f"{' '.join(METRIC_ENDINGS)}: faces, edges, lengths, and the directions (V, 3) of the vertices",
        required=True,
    )


def run(options: argparse.Namespace) -> int:
    """Write the triangles; return the exit status."""
    check_output(options.output, METRIC_ENDINGS)
    metric: TwoMetric
    zone = WHOLE if options.zone is None else tuple(options.zone)
    if options.spacetime is not None:
        refuse_given(options, ("input",), "does not go with a --spacetime")
        refuse_given(options, ("disc",), "does not go with a --spacetime")
        data = closed_form(options)
        metric, name = data.metric, data.name
    else:
        refuse_given(options, OF_SPACETIME, "needs a --spacetime")
        if options.disc is not None:
            refuse_given(options, ("input", "zone"), "does not go with a --disc")
            metric, zone, name = _disc(*options.disc)
        elif options.input is not None:
            metric, name = read_metric_grid(options.input), options.input
        else:
            raise UsageError("which metric? Give a GRID, a --spacetime and a --surface, or a --disc")
    mesh = triangulate_metric(metric, options.vertices, size=options.size, grading=options.grading, zone=zone)
    write_atomically({options.output: metric_writer(options.output, mesh.metric, directions=mesh.directions)})
    smallest, largest = np.degrees(mesh.angles)
    print_aside(
        f"{name}, {mesh.metric.triangulation.n_vertices} vertices, mean edge length "
        f"{mesh.metric.mean_length:.6g}, angles from {smallest:.1f} to {largest:.1f} degrees\n"
        f"{written(options, options.output)}"
    )
    return OK


def _disc(curvature: float, radius: float) -> tuple[TwoMetric, Zone, str]:
    """Geodesic disk of constant curvature, its zone, and its name."""
    if not radius > 0.0:
        raise UsageError(f"--disc: the radius must be positive, not {radius:g}")
    if curvature > 0.0 and radius * np.sqrt(curvature) >= np.pi:
        maximum = np.pi / np.sqrt(curvature)
        raise UsageError(
            f"--disc: with curvature {curvature:g} the radius must be less than {maximum:.6g}, not {radius:g}"
        )
    space = Space(curvature)
    metric = AngleMetric(lambda theta, phi: (radius**2, 0.0, space.sn(radius * theta) ** 2))
    return metric, (0.0, 1.0), f"disc of curvature {curvature:g} and radius {radius:g}"
