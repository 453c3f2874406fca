"""``isoembed certify``: proof that a realization is near the surface in a file."""

import argparse
from pathlib import Path

from isoembed.cli.options import add_json_option, add_merge_option, add_quiet_option
from isoembed.cli.same_triangles import check_same_triangles
from isoembed.cli.screen import print_json, print_out
from isoembed.cli.status import NOT_EMBEDDED, OK
from isoembed.io import MESH_ENDINGS, read_metric, read_surface
from isoembed.io.registry import METRIC_ENDINGS
from isoembed.proof.certificate import certify

EXAMPLES = (
    "isoembed certify surface.ply metric.npz",
    "isoembed certify surface.ply metric.npz --json",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed certify``."""
    endings = " ".join((*METRIC_ENDINGS, *MESH_ENDINGS))
    parser.add_argument("surface", type=Path, metavar="SURFACE", help=f"vertices and triangles ({endings})")
    parser.add_argument(
        "metric", type=Path, metavar="METRIC", help=f"the lengths, on the same triangles ({endings})"
    )
    add_merge_option(parser)
    add_json_option(parser)
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> int:
    """Print the certificate; return the exit status."""
    metric = read_metric(options.metric, merge=options.merge)
    surface = read_surface(options.surface, merge=options.merge)
    check_same_triangles(metric, surface.metric, options.metric, options.surface, "a certificate is for")
    found = certify(metric, surface.vertices)
    if options.json:
        print_json(found.as_json())
    else:
        print_out(found.reason)
    return OK if found.certified else NOT_EMBEDDED
