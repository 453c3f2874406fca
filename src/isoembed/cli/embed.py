"""``isoembed embed``: from a file of lengths to a file with the surface."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

import isoembed
from isoembed.cli.live import live_view
from isoembed.cli.parameters import configured
from isoembed.cli.refusal import Refusal
from isoembed.cli.screen import complain, say
from isoembed.cli.status import NOT_EMBEDDED, OK
from isoembed.cli.summary import summary
from isoembed.errors import NotEmbedded
from isoembed.io import (
    REPORT_ENDINGS,
    SURFACE_ENDINGS,
    check_output,
    read_metric,
    report_writer,
    surface_writer,
    write_whole,
)
from isoembed.io.files import Writer

METHODS = ("aim", "paper", "alexandrov")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed embed``."""
    parser.add_argument(
        "input",
        metavar="INPUT",
        help="a metric (.npz or .json with faces, edges, lengths), or a mesh (.obj .ply .stl .off .vtk .vtu) "
        "whose lengths are taken and whose coordinates are thrown away; - reads JSON from standard input",
    )
    parser.add_argument(
        "--method",
        choices=METHODS,
        default="aim",
        help="aim: the adaptive method (default); paper: AIM as printed; "
        "alexandrov: the exact convex polyhedron",
    )
    parser.add_argument(
        "--tolerance",
        type=_tolerance,
        default=1e-10,
        metavar="T",
        help="largest length error allowed, relative to the mean edge length (default 1e-10)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=f"where to write the surface, by its ending: {' '.join(SURFACE_ENDINGS)}",
    )
    parser.add_argument("--report", type=Path, metavar="FILE.json", help="where to write the report")
    parser.add_argument(
        "--keep", action="store_true", help="write the best attempt even if it is not an answer"
    )
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    parser.add_argument(
        "--parameter",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="set a parameter of the method; may be repeated, e.g. --method paper --parameter Tsteps=20",
    )


def run(options: argparse.Namespace) -> int:
    """Embed the input; return the exit status."""
    _check_outputs(options)
    method = configured(options.method, options.parameter)
    metric = read_metric(options.input)
    show = not options.quiet and sys.stderr is not None and sys.stderr.isatty()
    try:
        with live_view(show) as progress:
            embedding = isoembed.embed(metric, method=method, tolerance=options.tolerance, progress=progress)
        failure = None
    except NotEmbedded as error:
        embedding, failure = error.embedding, str(error)

    writers: dict[Path, Writer] = {}
    if options.output and (failure is None or options.keep):
        writers[options.output] = surface_writer(options.output, embedding)
    if options.report:
        writers[options.report] = report_writer(_report(embedding, failure))
    write_whole(writers)
    if failure is not None:
        complain(failure)
    if not options.output and not options.quiet:
        say(summary(embedding))
    return OK if failure is None else NOT_EMBEDDED


def _check_outputs(options: argparse.Namespace) -> None:
    """Find out what cannot be written before anything is computed."""
    if options.output:
        check_output(options.output, SURFACE_ENDINGS)
    elif options.keep:
        raise Refusal("--keep needs an --output to write the best attempt to")
    if options.report:
        check_output(options.report, REPORT_ENDINGS)
    if options.output and options.report and options.output.resolve() == options.report.resolve():
        raise Refusal(f"--output and --report are the same file {options.output}")


def _report(embedding: isoembed.Embedding, failure: str | None) -> dict[str, Any]:
    return embedding.report if failure is None else {**embedding.report, "message": failure}


def _tolerance(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not (value > 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text} is not a positive finite number")
    return value
