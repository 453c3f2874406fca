"""``isoembed realizations``: search for other realizations of the lengths near a surface."""

import argparse
from pathlib import Path

import numpy as np

from isoembed.aim.acceptance import SAME
from isoembed.aim.realizations import FEWEST, MOST, Realizations, realizations
from isoembed.cli.console import NOT_EMBEDDED, OK, UsageError, print_json, print_out
from isoembed.cli.options import (
    add_json_option,
    add_merge_option,
    add_metric_argument,
    add_output_option,
    add_surface_argument,
)
from isoembed.cli.outputs import check_folder, print_written
from isoembed.cli.same_triangles import metric_of
from isoembed.embedding.certify import certify
from isoembed.embedding.embedding import Embedding
from isoembed.io import read_surface, write_atomically
from isoembed.io.surface import surface_writer

EXAMPLES = (
    "isoembed realizations surface.ply metric.npz -o others",
    "isoembed realizations surface.ply metric.npz --motions 3 --distance 0.2",
)

LISTED = 10
LEGEND = (
    "distance from SURFACE and from the nearest other one, radius and isolation of the certificate, in mean "
    "edge lengths; fine is the fine roughness; the smoothest comes first"
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed realizations``."""
    add_surface_argument(parser)
    add_metric_argument(parser)
    parser.add_argument(
        "--distance",
        type=float,
        default=0.12,
        metavar="D",
        help="largest distance of a vertex from SURFACE, in mean edge lengths (default %(default)s)",
    )
    parser.add_argument(
        "--motions",
        type=int,
        default=5,
        metavar="K",
        help=f"largest number of motions combined, {FEWEST} to {MOST} (default %(default)s)",
    )
    parser.add_argument(
        "--surfaces",
        type=int,
        default=8,
        metavar="N",
        help="number of realizations to search from, alternating between breadth-first and smoothest-first "
        "order; time is proportional to it (default %(default)s)",
    )
    add_output_option(
        parser,
        "folder for the surfaces: realization-1.ply (the smoothest), realization-2.ply, ...",
        metavar="FOLDER",
    )
    add_merge_option(parser)
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Search for realizations; return the exit status."""
    if options.output:
        check_folder(options.output)
    about = read = read_surface(options.surface, merge=options.merge)
    if options.metric is not None:
        why = "realizations are on"
        metric = metric_of(read, options.surface, options.metric, options.merge, why, any_surface=False)
        about = Embedding(metric, read.vertices, method=read.method, tolerance=read.tolerance)
    found = realizations(about, distance=options.distance, motions=options.motions, surfaces=options.surfaces)
    files = _write(options, found) if options.output else []
    if options.json:
        print_json(found.report)
    else:
        print_out("\n".join([*_table(found), found.message]))
        print_written(options, *files)
    return OK if found.surfaces else NOT_EMBEDDED


def _write(options: argparse.Namespace, found: Realizations) -> list[Path]:
    paths = [options.output / f"realization-{i}.ply" for i in range(1, len(found.surfaces) + 1)]
    inputs = {path.resolve() for path in (options.surface, options.metric) if path}
    for path in paths:
        if path.resolve() in inputs:
            raise UsageError(f"{path} would overwrite the input: take another folder")
    if paths:
        options.output.mkdir(parents=True, exist_ok=True)
    write_atomically(
        {path: surface_writer(path, each) for path, each in zip(paths, found.surfaces, strict=True)}
    )
    return paths


def _table(found: Realizations) -> list[str]:
    """Lines for the nearest realizations, the smoothest first, and a legend of the columns."""
    if not found.surfaces:
        return []
    shown = sorted(np.argsort(found.distances, kind="stable")[:LISTED].tolist())
    lines = [
        f"{'':>4} {'distance':>9} {'nearest':>9} {'roughness':>10} {'fine':>9} {'radius':>8} {'isolation':>9}"
    ]
    for i in shown:
        surface, distance = found.surfaces[i], found.distances[i]
        proof = certify(surface)
        nearest = min(
            (surface.distance(other) for j, other in enumerate(found.surfaces) if j != i), default=None
        )
        numbers = [
            "-" if value is None else f"{value:.{digits}e}"
            for value, digits in (
                (distance, 2),
                (nearest, 2),
                (surface.surface.roughness, 3),
                (surface.surface.fine_roughness, 2),
                (proof.radius if proof.certified else None, 1),
                (proof.isolation if proof.certified else None, 2),
            )
        ]
        widths = (9, 9, 10, 9, 8, 9)
        row = " ".join(f"{number:>{width}}" for number, width in zip(numbers, widths, strict=True))
        same = "  SURFACE itself" if distance < SAME else ""
        lines.append(f"{i + 1:>4} {row}{same}{'' if found.searched[i] else '  not searched from'}")
    if len(shown) < len(found.surfaces):
        lines.append(f"the {LISTED} nearest of {len(found.surfaces)}; --json and --output have all")
    return [*lines, LEGEND]
