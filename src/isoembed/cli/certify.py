"""``isoembed certify``: proof that a realization is near the surface in a file."""

import argparse
from pathlib import Path

import numpy as np

from isoembed.arrays import Floats
from isoembed.cli.console import NOT_EMBEDDED, OK, UsageError, print_json, print_out
from isoembed.cli.numbers import read_numbers
from isoembed.cli.options import (
    add_json_option,
    add_merge_option,
    add_metric_argument,
    add_surface_argument,
)
from isoembed.cli.same_triangles import metric_of
from isoembed.io import read_surface
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.boundary_heights import certify as certify_heights
from isoembed.proof.certificate import Certificate, certify

EXAMPLES = (
    "isoembed certify surface.ply metric.npz",
    "isoembed certify cap.ply dome.obj --boundary plane",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed certify``."""
    add_surface_argument(parser)
    add_metric_argument(parser)
    parser.add_argument(
        "--boundary",
        metavar="plane|FILE",
        help="boundary condition of a disc: plane, of constant height z, or a .npy file of heights (B,)",
    )
    add_merge_option(parser)
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Print the certificate; return the exit status."""
    surface = read_surface(options.surface, merge=options.merge)
    metric = surface.metric
    if options.metric:
        metric = metric_of(surface, options.surface, options.metric, options.merge, "a certificate is for")
    found = _certificate(metric, surface.vertices, options.boundary)
    if options.json:
        print_json(found.as_json())
    else:
        print_out(found.reason)
    return OK if found.certified else NOT_EMBEDDED


def _certificate(metric: PolyhedralMetric, vertices: Floats, boundary: str | None) -> Certificate:
    if boundary is None:
        return certify(metric, vertices)
    count = int(metric.triangulation.boundary_vertices.sum())
    heights = np.zeros(count) if boundary == "plane" else read_numbers(Path(boundary))
    if heights.shape != (count,):
        raise UsageError(
            f"{boundary} has the shape {heights.shape}, not ({count},): heights of the boundary's vertices"
        )
    return certify_heights(metric, vertices, heights)
