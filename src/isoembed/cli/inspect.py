"""``isoembed inspect``: geometry, rounding and convexity of a metric before it is embedded."""

import argparse

from isoembed.cli.console import OK, print_json, print_out
from isoembed.cli.options import add_json_option, add_merge_option
from isoembed.io import MESH_ENDINGS, read_metric
from isoembed.metric.inspection import inspect

EXAMPLES = (
    "isoembed inspect metric.npz",
    "isoembed inspect scan.stl --json",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed inspect``."""
    parser.add_argument(
        "input",
        metavar="INPUT",
        help=f"a metric (.npz .json), a mesh ({' '.join(MESH_ENDINGS)}), a strut table (.csv), or - for "
        "JSON on standard input",
    )
    add_merge_option(parser)
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Inspect the input; return the exit status."""
    metric = read_metric(options.input, merge=options.merge, any_surface=True)
    found = inspect(metric)
    if options.json:
        print_json(found.report)
    else:
        kind = "the sphere" if metric.triangulation.is_sphere else "a surface"
        print_out(f"{options.input}: a polyhedral metric on {kind}\n\n{found}")
    return OK
