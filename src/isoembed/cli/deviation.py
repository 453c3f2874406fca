"""``isoembed deviation``: sensitivity of a surface to errors of its lengths."""

import argparse
from pathlib import Path

import numpy as np

from isoembed.cli.console import NOT_EMBEDDED, OK, UsageError, print_aside, print_json, print_out
from isoembed.cli.length_error import add_length_error_option, length_errors, not_rigid
from isoembed.cli.numbers import read_numbers
from isoembed.cli.options import (
    add_json_option,
    add_merge_option,
    add_output_option,
    add_surface_argument,
)
from isoembed.cli.outputs import check_answer, written
from isoembed.cli.summary import ARRAYS, INTEGRALS, why_undetermined
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.sensitivity import Sensitivity
from isoembed.io import SURFACE_ENDINGS, read_surface, write_atomically
from isoembed.io.files import Writer, ending
from isoembed.io.surface import mesh_writer, surface_data
from isoembed.linalg import SingularMatrix
from isoembed.plot import PICTURE_ENDINGS, picture_writer
from isoembed.plot.coloring import vertex_deviation
from isoembed.proof.deviation_bound import DeviationBound
from isoembed.sheets.boundary_condition import with_boundary_condition
from isoembed.sheets.surface import SheetEmbedding
from isoembed.surface.changes import Changes, root_mean_square
from isoembed.surface.deviation import NONLINEAR, Deviation
from isoembed.surface.estimate import percent

EXAMPLES = (
    "isoembed deviation surface.ply --length-error 0.001",
    "isoembed deviation cap.ply --length-error 0.001 --boundary plane",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed deviation``."""
    add_surface_argument(parser)
    add_length_error_option(parser, required=True)
    parser.add_argument(
        "--bound",
        action="store_true",
        help="treat E as the maximum error of each length, and print proven bounds instead of estimates",
    )
    parser.add_argument(
        "--boundary",
        metavar="CONDITION",
        help="boundary condition of a surface with boundary: free, plane, or the .npy file of heights (B,) "
        "or positions (B, 3) given to 'isoembed embed --boundary', which are taken as exact. The "
        "lengths of the surface are taken as exact; for fits to measured lengths, 'isoembed embed "
        "--length-error' reports deviations",
    )
    add_output_option(
        parser,
        f"{' '.join(SURFACE_ENDINGS)}: the surface with the deviations at its vertices; "
        f"{' '.join(PICTURE_ENDINGS)}: a picture of the deviations",
    )
    add_merge_option(parser)
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Estimate the deviations; return the exit status."""
    output = options.output
    if output:
        check_answer(output, (*SURFACE_ENDINGS, *PICTURE_ENDINGS), options.surface)
    errors = length_errors(options)
    assert errors is not None
    surface = _with_boundary(options, read_surface(options.surface, merge=options.merge))
    sensitivity = Sensitivity(surface)
    try:
        found = sensitivity.deviation_bound(errors) if options.bound else sensitivity.deviation(errors)
    except SingularMatrix:
        raise not_rigid(options.surface) from None
    obstacle = found.report.get("reason")
    if output and not obstacle:
        write_atomically({output: _writer(output, surface, found)})
    if options.json:
        print_json(found.report)
    else:
        print_out(f"not proven, because {obstacle}" if obstacle else _summary(surface, found))
        if output and not obstacle:
            print_aside(written(options, output))
    return NOT_EMBEDDED if obstacle else OK


def _with_boundary(options: argparse.Namespace, surface: Embedding) -> Embedding:
    """Surface with its boundary condition; raises UsageError if the option is missing or superfluous."""
    condition, t = options.boundary, surface.triangulation
    if t.is_closed != (condition is None):
        raise UsageError(
            f"--boundary is for surfaces with boundary, and {options.surface} is closed"
            if t.is_closed
            else f"{options.surface} has a boundary: give its condition by --boundary, as free, plane or a "
            "file"
        )
    if condition is None:
        return surface
    assert isinstance(surface, SheetEmbedding)
    count = int(t.boundary_vertices.sum())
    if condition in ("free", "plane"):
        return with_boundary_condition(surface, condition, np.zeros(count) if condition == "plane" else None)
    values = read_numbers(Path(condition))
    if values.shape not in ((count,), (count, 3)):
        raise UsageError(f"{condition} has the shape {values.shape}, not ({count},) or ({count}, 3)")
    return (
        with_boundary_condition(surface, "heights", values)
        if values.ndim == 1
        else with_boundary_condition(surface, "curve")
    )


def _writer(path: Path, surface: Embedding, found: Changes) -> Writer:
    if ending(path) in PICTURE_ENDINGS:
        return picture_writer(path, surface, color=vertex_deviation(found))
    data = surface_data(surface)
    data["vertex_deviation"], data["mean_curvature_deviation"] = found.vertices, found.mean_curvature
    return mesh_writer(path, faces=surface.faces, **data)


def _summary(surface: Embedding, found: Deviation | DeviationBound) -> str:
    if isinstance(found, Deviation):
        known = (
            f"; the last four are estimates accurate to {percent(found.relative_error)}"
            if found.probes
            else ""
        )
        meaning, more = f"one standard deviation, to first order{known}", 1.0
    else:
        # Rounding to two digits may lower a number by 5 %, and the printed bound must be proven, too.
        meaning, more = (
            "proven: for any lengths within E, a surface with these lengths is within the bounds",
            1.06,
        )
    lines = [
        f"{name:12}{getattr(surface, field):.17g} +- {more * getattr(found, field):.2g}"
        if isinstance(found, DeviationBound)
        else f"{name:12}{getattr(surface, field):.12g} +- {getattr(found, field):.2g}"
        for field, name in INTEGRALS.items()
        if not np.isnan(getattr(found, field))  # a surface with boundary that is not a cap has no volume
    ]
    for field, name, place, unit in ARRAYS:
        values = getattr(found, field)
        worst = int(np.argmax(values))
        lines.append(
            f"{name:12}+- {more * root_mean_square(values):.2g}{unit}, "
            f"at most {more * values[worst]:.2g} (at {place} {worst})"
        )
    closed = surface.triangulation.is_sphere
    if closed and isinstance(found, Deviation) and not found.volume_nonlinearity <= NONLINEAR:
        why = why_undetermined(found.volume_nonlinearity)
        lines.append(f"the first-order estimate is not valid here: {why}")
    return "\n".join([*lines, meaning])
