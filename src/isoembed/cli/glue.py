"""``isoembed glue``: gluing and folding of a paper net to its solid."""

import argparse
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import isoembed
from isoembed.alexandrov.solid import Solid
from isoembed.cli.advice import command
from isoembed.cli.console import OK, UsageError, print_aside
from isoembed.cli.embedding_output import add_output_options, answer, requested_outputs
from isoembed.cli.outputs import written
from isoembed.cli.summary import summary
from isoembed.gluing import embed_net
from isoembed.gluing.solid import unknown_folding
from isoembed.io import METRIC_ENDINGS, metric_writer
from isoembed.io.files import Writer
from isoembed.io.net import read_net
from isoembed.progress.stages import Listener

EXAMPLES = (
    "isoembed glue net.json -o solid.obj",
    "isoembed glue drawing.svg --html solid.html --tolerance 0.01",
)
USUAL = ("tolerance", "metric", "output", "report", "picture", "html", "keep", "json", "verbose", "quiet")
"""Options listed by ``--help``."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed glue``."""
    parser.add_argument(
        "input",
        metavar="FILE",
        help=".json: polygons with the pairs of sides that are glued or with names of their corners, or a "
        "zip, a pita form or a D-form; .fold: a crease pattern with names of its corners; .svg .dxf: a "
        "drawing in mm with numbers at its sides, as 'isoembed unfold' writes it; - reads JSON from standard "
        "input",
    )
    add_output_options(parser)
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="LENGTH",
        help="largest length difference of glued sides, in the unit of the sheets, which are corrected by "
        "the smallest change (default: the rounding error of the corners)",
    )
    parser.add_argument(
        "--metric",
        type=Path,
        metavar="FILE",
        help="file for the glued metric, on a simplicial complex, in the format of its extension: "
        f"{' '.join(METRIC_ENDINGS)}; without other outputs, nothing is solved",
    )


def run(options: argparse.Namespace) -> int:
    """Glue the net and embed it; return the exit status."""
    outputs = requested_outputs(options, metric=METRIC_ENDINGS)
    net = read_net(options.input, tolerance=options.tolerance)

    def metric(path: Path) -> Writer:
        return metric_writer(path, net.simplicial())

    if outputs.keys() == {"metric"} and not options.json:
        outputs.write(metric=metric)
        print_aside(f"{net!r}\n{written(options, options.metric)}")
        return OK

    if not net.is_sphere and (unknown := unknown_folding(net)):
        raise UsageError(
            f"{unknown}: {command('glue', options.input, '--metric', 'metric.npz')} and then "
            "'isoembed embed metric.npz --boundary plane', or free"
        )

    def solve(progress: Listener | None) -> isoembed.Embedding:
        return embed_net(net, progress=progress)

    correction = {} if net.correction is None else {"correction": asdict(net.correction)}
    return answer(options, outputs, solve, describe=_described, reported=correction, metric=metric)


def _described(embedding: isoembed.Embedding, report: Mapping[str, Any], **how: bool) -> str:
    solid = f"{Solid.of(embedding)}\n\n" if isinstance(embedding, isoembed.ConvexPolyhedron) else ""
    return f"{solid}{summary(embedding, report, **how)}"
