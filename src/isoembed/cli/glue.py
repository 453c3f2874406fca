"""``isoembed glue``: from a paper net to the solid that it folds to."""

from __future__ import annotations

import argparse
from pathlib import Path

import isoembed
from isoembed.cli.answer import add_output_options, answer, asked_for, check_outputs
from isoembed.cli.netfile import read_net
from isoembed.cli.screen import print_out
from isoembed.cli.solid import described
from isoembed.cli.status import OK
from isoembed.io import METRIC_ENDINGS, check_output, metric_writer, write_atomically
from isoembed.progress.stages import Listener


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed glue``."""
    parser.add_argument(
        "input",
        metavar="FILE.json",
        help="polygons and the pairs of sides that are glued, or a zip, a pita form or a D-form; "
        "- reads standard input",
    )
    add_output_options(parser)
    parser.add_argument(
        "--metric",
        type=Path,
        metavar="FILE",
        help="where to write the glued metric, on a simplicial complex, by its ending: "
        f"{' '.join(METRIC_ENDINGS)}; where nothing else is asked for, nothing is solved",
    )


def run(options: argparse.Namespace) -> int:
    """Glue the net and solve it; return the exit status."""
    if options.metric:
        check_output(options.metric, METRIC_ENDINGS)
    check_outputs(options, metric=options.metric)
    net = read_net(options.input)
    beside = {options.metric: metric_writer(options.metric, net.simplicial())} if options.metric else {}
    if options.metric and not asked_for(options):
        write_atomically(beside)
        if not options.quiet:
            print_out(f"{options.metric}: {net!r}")
        return OK

    def solve(progress: Listener | None) -> isoembed.Embedding:
        return isoembed.embed(net, method="alexandrov", progress=progress)

    return answer(options, solve, describe=described, beside=beside)
