"""``isoembed certify``: prove that an exact surface is near the one in a file."""

import argparse
from pathlib import Path

import numpy as np

from isoembed.arrays import Indices
from isoembed.cli.options import add_json_option, add_merge_option
from isoembed.cli.screen import UsageError, print_json, print_out
from isoembed.cli.status import NOT_EMBEDDED, OK
from isoembed.io import MESH_ENDINGS, read_metric, read_surface
from isoembed.io.registry import METRIC_ENDINGS
from isoembed.surface.certificate import certify


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed certify``."""
    endings = " ".join((*METRIC_ENDINGS, *MESH_ENDINGS))
    parser.add_argument("surface", type=Path, metavar="SURFACE", help=f"vertices and triangles ({endings})")
    parser.add_argument(
        "metric", type=Path, metavar="METRIC", help=f"the lengths, on the same triangles ({endings})"
    )
    add_merge_option(parser)
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Print the certificate; return the exit status."""
    metric = read_metric(options.metric, merge=options.merge)
    surface = read_surface(options.surface, merge=options.merge)
    if surface.space.curvature != metric.space.curvature:
        raise UsageError(
            f"{options.surface} is in a space of curvature {surface.space.curvature:g}, the triangles of "
            f"{options.metric} have the curvature {metric.space.curvature:g}"
        )
    count = metric.triangulation.n_vertices
    if len(surface.vertices) != count:
        raise UsageError(
            f"{options.surface} has {len(surface.vertices)} vertices, {options.metric} has {count}"
        )
    other = ~np.isin(_keys(metric.faces, count), _keys(surface.faces, count))
    if other.any():
        f = int(np.argmax(other))
        raise UsageError(
            f"face {f} {metric.faces[f].tolist()} of {options.metric} is not in {options.surface}: a "
            "certificate is for the same triangles"
        )
    found = certify(metric, surface.vertices)
    if options.json:
        print_json(found.as_json())
    else:
        print_out(found.reason)
    return OK if found.certified else NOT_EMBEDDED


def _keys(faces: Indices, vertices: int) -> Indices:
    """A number for the corners of each face, in whatever order."""
    a, b, c = np.sort(faces, axis=1).T
    return np.asarray((a * vertices + b) * vertices + c)
