"""``isoembed compare``: distance and curvature differences of two surfaces on the same triangulation."""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from isoembed.cli.console import NOT_EMBEDDED, OK, print_aside, print_json, print_out
from isoembed.cli.options import (
    add_json_option,
    add_merge_option,
    add_metric_argument,
    add_output_option,
    add_surface_argument,
)
from isoembed.cli.outputs import check_answer, written
from isoembed.cli.same_triangles import check_same_triangles, metric_of
from isoembed.cli.summary import ARRAYS, INTEGRALS
from isoembed.embedding.comparison import Comparison, compare, stated
from isoembed.embedding.embedding import Embedding
from isoembed.io import (
    SURFACE_ENDINGS,
    read_surface,
    write_atomically,
)
from isoembed.io.files import Writer, ending
from isoembed.io.surface import mesh_writer, surface_data
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.plot import PICTURE_ENDINGS, picture_writer
from isoembed.plot.coloring import mean_curvature_difference
from isoembed.sheets.surface import SheetEmbedding
from isoembed.surface.changes import root_mean_square

NEEDED = "surfaces are compared on"
HEADING = "differences between OTHER and SURFACE, in the unit of the lengths; signed values: OTHER - SURFACE"

EXAMPLES = (
    "isoembed compare by-aim.ply by-paper.ply metric.npz",
    "isoembed compare by-aim.ply by-paper.ply metric.npz -o difference.png",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed compare``."""
    add_surface_argument(parser)
    parser.add_argument("other", type=Path, metavar="OTHER", help="second surface, on the same triangles")
    add_metric_argument(parser)
    add_output_option(
        parser,
        f"{' '.join(SURFACE_ENDINGS)}: SURFACE with the differences at its vertices; "
        f"{' '.join(PICTURE_ENDINGS)}: a picture of the mean curvature difference",
    )
    add_merge_option(parser)
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Compare the surfaces; return the exit status."""
    output = options.output
    if output:
        check_answer(output, (*SURFACE_ENDINGS, *PICTURE_ENDINGS), options.surface, options.other)
    first, second = (read_surface(path, merge=options.merge) for path in (options.surface, options.other))
    named, metric = options.surface, first.metric
    if options.metric:
        named = options.metric
        metric = metric_of(first, options.surface, named, options.merge, NEEDED)
    check_same_triangles(metric, second.metric, named, options.other, NEEDED)
    one, other = (_with_lengths(metric, each) for each in (first, second))
    found = compare(one, other)
    if output:
        write_atomically({output: _writer(output, one, found)})
    if options.json:
        print_json(found.report)
    else:
        print_out(_summary(one, found))
        if output:
            print_aside(written(options, output))
    provable = metric.triangulation.is_sphere and (options.metric or other.converged)
    return NOT_EMBEDDED if provable and not found.certified else OK


def _with_lengths(metric: PolyhedralMetric, surface: Embedding) -> Embedding:
    if isinstance(surface, SheetEmbedding):
        return replace(surface, metric=metric)
    return Embedding(metric, surface.vertices, method=surface.method, tolerance=surface.tolerance)


def _writer(path: Path, surface: Embedding, found: Comparison) -> Writer:
    if ending(path) in PICTURE_ENDINGS:
        return picture_writer(path, surface, color=mean_curvature_difference(found))
    data = surface_data(surface)
    data["distance"], data["mean_curvature_difference"] = (
        found.difference.vertices,
        found.difference.mean_curvature,
    )
    return mesh_writer(path, faces=surface.faces, **data)


def _summary(first: Embedding, found: Comparison) -> str:
    apart, error = found.difference, found.error
    lines = [found.reason, "", HEADING]
    for name, shown, place, unit in ARRAYS:
        values, errors = np.abs(getattr(apart, name)), getattr(error, name)
        worst = int(np.argmax(values))
        lines.append(
            f"{shown:12}{stated(values[worst], errors.max())}{unit} at most (at {place} {worst}), "
            f"{root_mean_square(values):.3g} in root mean square"
        )
    lines.append(f"{'area':12}{'equal' if found.certified else stated(apart.area, error.area)}")
    closed = first.triangulation.is_closed
    for name in ("volume", "integrated_mean_curvature") if closed else ("integrated_mean_curvature",):
        change, whole = getattr(apart, name), getattr(first, name)
        with_error = stated(change, getattr(error, name))
        share = f", {abs(change / whole):.1e} of {whole:.9g}" if whole and np.isfinite(whole) else ""
        lines.append(f"{INTEGRALS[name]:12}{with_error}{share}")
    rough = " and ".join(f"{each:.4g}" for each in found.fine_roughness)
    lines.append(f"{'roughness':12}{rough} (fine_roughness)")
    if found.certified:
        lines.append("errors after +- are proven bounds for the exact surfaces")
    return "\n".join(lines)
