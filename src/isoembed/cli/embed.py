"""``isoembed embed``: options and their checks, method, comparison with the surface in the input file."""

import argparse
import math
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import isoembed
from isoembed.aim.acceptance import are_identical, is_realization
from isoembed.arrays import Floats
from isoembed.cli.checkpoints import Checkpoints, add_checkpoint_options, checkpoint_file
from isoembed.cli.console import UsageError, print_error
from isoembed.cli.embedding_output import add_output_options, answer, listener_of, requested_outputs
from isoembed.cli.length_error import add_length_error_option, length_errors
from isoembed.cli.numbers import read_numbers
from isoembed.cli.options import (
    OF_RUNS,
    add_merge_option,
    add_run_options,
    add_space_option,
    converted,
    given,
    refuse_given,
)
from isoembed.cli.parameters import configured, parameters
from isoembed.cli.same_triangles import check_same_triangles
from isoembed.errors import Interrupted, InvalidParameter, NotEmbedded
from isoembed.io import MESH_ENDINGS, FileError, read_checkpoint, read_surface
from isoembed.io.files import ending
from isoembed.io.metric import read_with_vertices
from isoembed.io.registry import METRIC_ENDINGS
from isoembed.methods import method_class, method_names
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Listener
from isoembed.typed_numbers import number

WHICH = ("convex", "smoothest")
"""Values of ``--which`` other than files."""
OF_METHODS = {
    "repair": ("alexandrov", "has no repair"),
    "best_fit": ("aim", "has no best fit"),
    "effort": ("aim", "does not search"),
    "which": ("aim", "finds one surface"),
}
"""Options that are fields of one method, and what other methods are like."""

EXAMPLES = (
    "isoembed embed metric.npz -o surface.ply",
    "isoembed embed scan.obj --best-fit -o smooth.ply --html smooth.html",
)
USUAL = (
    "method",
    "boundary",
    "best_fit",
    "length_error",
    "which",
    "space",
    "output",
    "picture",
    "html",
    "json",
)
"""Options listed by ``--help``."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed embed``."""
    parser.add_argument(
        "inputs",
        nargs="+",
        metavar="INPUT",
        help=f"a metric (.npz or .json with faces, edges, lengths), or a mesh ({' '.join(MESH_ENDINGS)}) "
        "used for its edge lengths and its planar polygons, or a strut table (.csv); - reads JSON from "
        "standard input; with several inputs, --output is a folder",
    )
    parser.add_argument(
        "--method",
        choices=method_names(),
        help="aim: the adaptive method (default); paper: AIM as printed; alexandrov: the exact convex "
        "polyhedron; sheet: surfaces with boundary, or of higher genus (default with --boundary); "
        "other methods are from installed packages",
    )
    parser.add_argument(
        "--boundary",
        metavar="CONDITION",
        help="for surfaces with boundary, or of higher genus: free for a surface of least bending; plane "
        "for the convex cap; a mesh of the same triangles, whose boundary positions are prescribed; "
        "or a .npy file with heights (B,) or positions (B, 3) of the boundary's vertices, in the "
        "order of Triangulation.boundaries",
    )
    parser.add_argument(
        "--start",
        type=Path,
        metavar="FILE",
        help="with --boundary: initial surface, as a mesh of the same triangles or a .npy file of vertices "
        "(V, 3)",
    )
    parser.add_argument(
        "--tolerance",
        type=_tolerance,
        default=1e-10,
        metavar="T",
        help="largest length error allowed, relative to the mean edge length (default 1e-10)",
    )
    add_merge_option(parser)
    add_space_option(
        parser,
        "the space to embed in, of curvature K, which is also the curvature of the triangles; without "
        "K, the curvature in the file, or the least curved hyperbolic space that makes the metric "
        "convex (default: the space in the file, or R^3)",
    )
    add_output_options(parser)
    add_checkpoint_options(parser)
    add_run_options(parser)
    parser.add_argument(
        "--repair",
        metavar="NOISE",
        help="with --method alexandrov: treat deficits of at most this many radians as noise, and make "
        "them zero by the smallest conformal change of the lengths",
    )
    parser.add_argument(
        "--best-fit",
        action="store_true",
        help="if no surface with the lengths is found, write the smooth surface that fits them best and "
        'succeed, with the status "best fit"; only with --method aim',
    )
    add_length_error_option(
        parser,
        "; with --method aim the surface is a smooth one that agrees with the lengths within these "
        "errors (chi-square), and 0 for all edges takes the lengths as exact, whatever their digits; "
        "the report includes standard deviations of area, volume and int H dA; not with --best-fit",
    )
    parser.add_argument(
        "--effort",
        type=float,
        metavar="TIMES",
        help="cost limit after a failed first attempt: a search and the best fit take up to 1 + TIMES the "
        "cost of that attempt (at most 11 times), counted in factorizations; above 1, a search for "
        "vertices on the wrong side follows, up to TIMES that cost (default 1; 0: no search); only "
        "with --method aim",
    )
    parser.add_argument(
        "--which",
        metavar="convex|smoothest|FILE",
        help="choice among the realizations found: the convex one, the smoothest, or the one nearest to "
        "the surface in FILE, which has the same triangles and any size; only with --method aim",
    )
    parser.add_argument(
        "--parameter",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="set a parameter of the method; may be repeated, e.g. --method paper --parameter Tsteps=20",
    )


def run(options: argparse.Namespace) -> int:
    """Embed one or several inputs; return the exit status."""
    if len(options.inputs) > 1 or (options.output and options.output.is_dir()):
        from isoembed.cli.embed_files import embed_files

        for name, path in (("boundary", options.boundary), ("start", options.start)):
            if _is_surface(path):
                raise UsageError(f"the mesh {path} as --{name} is for a single input")
        return embed_files(options, _method(options, _near(options)))
    refuse_given(options, OF_RUNS, "is for several files, whose --output is a folder")
    outputs = requested_outputs(options)
    [source] = options.inputs
    left = checkpoint_file(options, outputs, source)
    near = _near(options)
    method = _method(options, near)
    errors = length_errors(options)
    checkpoint = read_checkpoint(options.resume) if options.resume else None
    checkpoints = Checkpoints(left, checkpoint)
    metric, own_vertices = read_with_vertices(
        source, merge=options.merge, space=options.space, any_surface=True, length_errors=errors
    )
    if near is not None:
        why = "'nearest' is defined for a surface on"
        check_same_triangles(metric, near.metric, source, Path(options.which), why)
    if _is_surface(options.boundary) or _is_surface(options.start):
        method = _from_meshes(options, method, metric, source)
    if options.space == "hyperbolic" and metric.space.is_euclidean:
        print_error(
            "the metric is convex in R^3: it is embedded in R^3; for curvature -1 write "
            "--space hyperbolic=-1",
            "note",
        )

    def note_given_surface(found: isoembed.Embedding) -> None:
        if own_vertices is not None and "which" in parameters(type(method)) and options.which is None:
            _note_given_surface(found, own_vertices, source)

    def solve(progress: Listener | None) -> isoembed.Embedding:
        try:
            found = isoembed.embed(
                metric,
                method=method,
                tolerance=options.tolerance,
                progress=listener_of(progress, checkpoints.listen),
                resume=checkpoint,
            )
        except NotEmbedded as error:
            note_given_surface(error.embedding)
            raise
        note_given_surface(found)
        return found

    try:
        status = answer(options, outputs, solve)
    except Interrupted as interrupted:
        raise KeyboardInterrupt(checkpoints.leave(interrupted, method.name)) from None
    except FileError as error:
        raise FileError(f"{error}{checkpoints.left()}") from None
    checkpoints.remove()
    return status


def _near(options: argparse.Namespace) -> isoembed.Embedding | None:
    """Surface in the file of ``--which``, if it is one."""
    if options.which is None or options.which in WHICH:
        return None
    return read_surface(Path(options.which), merge=options.merge)


def _method(options: argparse.Namespace, near: isoembed.Embedding | None) -> isoembed.Method:
    """Method with its parameters, one of which may be the nearest surface."""
    name = options.method or ("aim" if options.boundary is None else "sheet")
    fields = parameters(method_class(name))
    for field, value in given(options, OF_METHODS).items():
        if value is not False and field not in fields:
            needed, why = OF_METHODS[field]
            option = field.replace("_", "-")
            raise UsageError(f"--{option} needs the method {needed!r}: the method {name!r} {why}")
    if options.length_error is not None and options.best_fit:
        raise UsageError("--length-error does not go with --best-fit, which smooths errors instead")
    if options.boundary is not None or options.start is not None:
        if "boundary" not in fields:
            raise UsageError(f"--boundary and --start need the method 'sheet', not {name!r}")
        if options.parameter:
            raise UsageError("the method 'sheet' takes no --parameter, only --boundary and --start")
        errors = length_errors(options)
        if errors is not None and errors.any() and options.boundary != "plane":
            raise UsageError(
                "--length-error is for closed surfaces of genus 0, and with --boundary plane: elsewhere "
                "lengths are exact, or with --tolerance of least squares through a curve"
            )
        return _sheet(options)
    asked = {"repair": options.repair, "best_fit": options.best_fit or None, "effort": options.effort}
    assignments = [f"{field}={value}" for field, value in asked.items() if value is not None]
    which: dict[str, str | Floats] = {}
    if options.which in WHICH:
        which["which"] = options.which
    elif near is not None:
        which["which"] = near.vertices
    method = configured(name, options.parameter + assignments, **which)
    if options.length_error is not None and method.takes_boundary:
        raise UsageError(f"--length-error with the method {name!r} needs --boundary plane")
    return method


def _sheet(options: argparse.Namespace) -> isoembed.Method:
    """Method for surfaces with boundary, with arrays from files."""
    boundary: Any = options.boundary or "free"
    if _is_surface(boundary):
        boundary = "free"  # replaced after the metric is read
    elif ending(boundary):
        boundary = read_numbers(Path(boundary))
    start = None if options.start is None or _is_surface(options.start) else read_numbers(options.start)
    try:
        return isoembed.Sheet(boundary, start)
    except InvalidParameter as error:
        raise UsageError(str(error)) from None


def _is_surface(path: str | Path | None) -> bool:
    """Whether the ending of a file is that of a surface format."""
    return path is not None and ending(path) in (*METRIC_ENDINGS, *MESH_ENDINGS)


def _from_meshes(
    options: argparse.Namespace, method: isoembed.Method, metric: PolyhedralMetric, source: Path
) -> isoembed.Method:
    """Method with boundary and start from meshes of the same triangles."""
    assert isinstance(method, isoembed.Sheet)
    found = {}
    for name, path in (("boundary", options.boundary), ("start", options.start)):
        if _is_surface(path):
            surface = read_surface(path, merge=options.merge)
            check_same_triangles(metric, surface.metric, source, Path(path), f"--{name} takes a mesh of")
            found[name] = surface.vertices
    if "boundary" in found and not metric.triangulation.is_closed:
        found["boundary"] = found["boundary"][np.concatenate(metric.triangulation.boundaries)]
    return replace(method, **found)


def _tolerance(text: str) -> float:
    value = converted(text, number, "a number")
    if not (value > 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text} is not a positive finite number")
    return value


def _note_given_surface(found: isoembed.Embedding, vertices: Floats, source: Path) -> None:
    """Note that the surface in the file has the lengths, too, if it is not the one found."""
    if not found.metric.space.is_euclidean or found.metric.length_errors is not None:
        return
    given = isoembed.Embedding(found.metric, vertices, method=found.method, tolerance=found.tolerance)
    if not is_realization(given):
        return
    says = "has these lengths"
    if found.residual <= found.tolerance:
        if are_identical(found, given):
            return
        says = f"{says}, too, and is {found.distance(given):.1g} mean edge lengths from the one found"
    print_error(f"the surface in {source} {says}: --which {shlex.quote(str(source))} returns it", "note")
