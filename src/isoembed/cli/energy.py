"""``isoembed energy``: quasi-local energies of a closed-form surface, or of one from a file."""

from __future__ import annotations

import argparse
from pathlib import Path

from isoembed.cli.closed_form import OF_SPACETIME, add_spacetime_options, closed_form, refuse_given
from isoembed.cli.energies import add_answer_options, check_outputs, mesh_answer, smooth_answer
from isoembed.cli.numbers import read_numbers
from isoembed.cli.refusal import UsageError
from isoembed.io import MESH_ENDINGS, read_metric
from isoembed.io.files import ending
from isoembed.relativity.horizons.grid_file import holds_metric_grid, read_metric_grid
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.surface.smooth_integrals import Lengths

OF_METRIC = ("mean_curvature", "momentum", "normal_momentum", "lengths")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed energy``."""
    parser.add_argument(
        "input",
        nargs="?",
        metavar="METRIC",
        help="a surface of your own: a metric on triangles (.npz or .json with faces, edges, lengths, or a "
        "mesh), or on a grid (.npz .h5 .hdf5 with theta, phi, q_tt, q_tp, q_pp)",
    )
    parser.add_argument(
        "--mean-curvature",
        type=Path,
        metavar="K.npy",
        help="its k = k1 + k2 in the slice of spacetime, at the vertices or the nodes of the grid",
    )
    parser.add_argument(
        "--momentum", type=Path, metavar="P.npy", help="its p = K_ij (gamma^ij - n^i n^j) there (default 0)"
    )
    parser.add_argument(
        "--normal-momentum",
        type=Path,
        metavar="J.npy",
        help="on a grid, for --wang-yau: the components of K(., n) for theta and phi, an array (2, n, m)",
    )
    parser.add_argument(
        "--lengths",
        choices=("geodesic", "chord"),
        help="what the lengths of triangles are: those of geodesics, as isoembed triangulate makes them, or "
        "distances of points in Euclidean space, as in meshes and from isoembed surface (by default, but for "
        "meshes, they are taken for geodesics' with errors wide enough for both)",
    )
    add_spacetime_options(parser)
    add_answer_options(parser)


def run(options: argparse.Namespace) -> int:
    """Compute the energies; return the exit status."""
    check_outputs(options)
    if options.spacetime is not None:
        refuse_given(options, ("input", *OF_METRIC), "does not go with a --spacetime")
        return smooth_answer(options, closed_form(options))
    refuse_given(options, OF_SPACETIME, "needs a --spacetime")
    if options.input is None:
        raise UsageError("which surface? Give a METRIC, or a --spacetime and a --surface")
    k, p = (path and read_numbers(path) for path in (options.mean_curvature, options.momentum))
    if not holds_metric_grid(options.input):
        lengths: Lengths | None = options.lengths
        if lengths is None and ending(options.input) in MESH_ENDINGS:
            lengths = "chord"
        refuse_given(options, ("normal_momentum",), "is for a METRIC on a grid")
        return mesh_answer(options, read_metric(options.input), k, p, lengths)
    refuse_given(options, ("lengths",), "is for a METRIC of triangles")
    if p is not None and k is None:
        raise UsageError("the momentum is of use only with the mean curvature: give --mean-curvature, too")
    grid = read_metric_grid(options.input)
    j = None
    if options.normal_momentum:
        components = read_numbers(options.normal_momentum)
        if components.ndim != 3 or len(components) != 2:
            raise UsageError(f"{options.normal_momentum} has the shape {components.shape}, not (2, n, m)")
        j = grid.one_form(components[0], components[1], str(options.normal_momentum))
    data = SurfaceData(
        metric=grid,
        mean_curvature=None if k is None else grid.function(k, str(options.mean_curvature)),
        momentum=None if p is None else grid.function(p, str(options.momentum)),
        normal_momentum=j,
        relative_error=grid.truncation,
        name=options.input,
    )
    return smooth_answer(options, data)
