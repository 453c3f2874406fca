"""What the commands that compute energies do with them: say them, and write the surface."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import isoembed
from isoembed.cli.live import live_view
from isoembed.cli.refusal import UsageError
from isoembed.cli.screen import print_error, print_out
from isoembed.cli.status import NOT_EMBEDDED, OK
from isoembed.errors import InvalidMetric, InvalidParameter, NoMinimum, NotEmbedded
from isoembed.io import SURFACE_ENDINGS, check_output, mesh_writer, surface_writer, write_atomically
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.relativity.energies.embedded import CONVENTIONS, EmbeddedSurface, embed_surface
from isoembed.relativity.energies.mesh_energies import mesh_energies
from isoembed.relativity.energies.quadrature import intrinsic_energies
from isoembed.relativity.energies.wang_yau_energy import WangYau, wang_yau
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.surface.smooth_integrals import Lengths

Floats = NDArray[np.float64]

SHOWN = {
    "area": "area",
    "integrated_mean_curvature": "int H dA, H = (k1 + k2)/2",
    "irreducible_mass": "irreducible mass",
    "christodoulou_mass": "Christodoulou mass",
    "hawking": "Hawking energy",
    "brown_york": "Brown-York energy",
    "liu_yau": "Kijowski-Liu-Yau energy",
    "wang_yau": "Wang-Yau energy",
}

DEFAULT, FEWEST = 1000, 12  # vertices


def add_answer_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say how to embed and where the answer goes."""
    parser.add_argument(
        "--vertices",
        type=int,
        metavar="N",
        help=f"of the mesh that finds a smooth surface, and of the one that is written (default {DEFAULT})",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=f"where to write the embedded surface, by its ending: {' '.join(SURFACE_ENDINGS)}",
    )
    parser.add_argument(
        "--wang-yau",
        action="store_true",
        help="add the Wang-Yau energy of a smooth surface, the least over all time functions; --output then "
        "writes the projection of its surface in Minkowski space, with tau at the vertices",
    )
    parser.add_argument(
        "--best-fit",
        action="store_true",
        help="if a smooth surface does not embed, take the one that comes nearest to it",
    )
    parser.add_argument(
        "--band",
        type=Path,
        metavar="FILE",
        help="if an axisymmetric surface does not embed, write the band of it that does, as a mesh",
    )


def check_outputs(options: argparse.Namespace) -> None:
    """Find out what cannot be written before anything is computed.

    Raises
    ------
    FileError, Refusal
        Naming the file or the option.
    """
    if options.vertices is not None and options.vertices < FEWEST:
        raise UsageError(f"--vertices must be at least {FEWEST}, not {options.vertices}")
    for path in (options.output, options.band):
        if path:
            check_output(path, SURFACE_ENDINGS)


def smooth_answer(options: argparse.Namespace, data: SurfaceData) -> int:
    """Embed a smooth surface, answer with its energies, and return the exit status."""
    vertices = DEFAULT if options.vertices is None else options.vertices
    try:
        surface = embed_surface(data, vertices=vertices, best_fit=options.best_fit)
    except NotEmbedded as error:
        found = {"name": data.name, **intrinsic_energies(data).report, "conventions": CONVENTIONS}
        _answered(options, {"status": "not embedded", "message": str(error), **found})
        print_error(str(error))
        if options.band is not None:
            _write_band(options.band, data)
        return NOT_EMBEDDED
    report, tables = surface.report, surface.mesh
    if options.wang_yau:
        least = _add_wang_yau(report, surface)
        tables = tables if least is None else least.mesh
    if options.band:
        why = "the whole surface embeds" if surface.embedding.converged else "the best fit was asked for"
        print_error(f"{options.band} is not written: {why}")
    if options.output:
        write_atomically({options.output: mesh_writer(options.output, **tables(vertices))})
    _answered(options, report)
    return OK


def mesh_answer(
    options: argparse.Namespace,
    metric: PolyhedralMetric,
    k: Floats | None,
    p: Floats | None,
    lengths: Lengths | None,
) -> int:
    """Embed the triangles of a surface, answer with its energies, and return the exit status."""
    if options.vertices is not None:
        raise UsageError("--vertices is for smooth surfaces: this METRIC has its own")
    for name in ("best_fit", "band", "wang_yau"):
        if getattr(options, name):
            raise UsageError(f"--{name.replace('_', '-')} is for smooth surfaces")
    try:
        with live_view(sys.stderr is not None and sys.stderr.isatty()) as progress:
            embedding = isoembed.embed(metric, progress=progress)
    except NotEmbedded as error:
        if options.json:
            print_out(
                json.dumps(
                    {"status": "not embedded", "message": str(error), "name": str(options.input)}, indent=2
                )
            )
        print_error(str(error))
        return NOT_EMBEDDED
    energies = mesh_energies(embedding, k, p, lengths=lengths)
    if options.output:
        write_atomically({options.output: surface_writer(options.output, embedding)})
    report = {
        "status": "embedded",
        "message": embedding.message,
        "name": str(options.input),
        **energies.report,
        "lengths": lengths or "not known",
        "embedding": {
            "vertices": metric.triangulation.n_vertices,
            "residual": embedding.residual,
            "volume": embedding.volume,
        },
        "conventions": CONVENTIONS,
    }
    _answered(options, report)
    return OK


def _add_wang_yau(report: dict[str, Any], surface: EmbeddedSurface) -> WangYau | None:
    """Add the least Wang-Yau energy to a report, or why there is none."""
    try:
        found = wang_yau(surface.data, "optimal", embedding=surface.embedding)
    except (InvalidParameter, NotEmbedded, NoMinimum) as error:
        report["wang_yau"] = report["errors"]["wang_yau"] = None
        report["notes"].append(str(error))
        return None
    report["wang_yau"], report["errors"]["wang_yau"] = found.energy.value, found.energy.error
    report["error_estimate"] = max(report["error_estimate"], found.energy.error)
    report["minimum"] = found.report
    return found


def _write_band(path: Path, data: SurfaceData) -> None:
    """Write the largest band of an axisymmetric surface that embeds, or say why there is none."""
    try:
        bands = AxisymmetricEmbedding.of(data.metric).bands
    except InvalidMetric as error:
        print_error(f"--band is for surfaces that are symmetric about the z-axis: {error}")
        return
    if not bands:
        print_error(f"{path} is not written: no part of the surface is a surface of revolution")
        return
    vertices, faces = max(bands, key=lambda band: band.area).mesh()
    write_atomically({path: mesh_writer(path, vertices, faces)})


def _answered(options: argparse.Namespace, report: dict[str, Any]) -> None:
    print_out(json.dumps(report, indent=2, allow_nan=False) if options.json else table(report))


def table(report: dict[str, Any]) -> str:
    """The energies of a report, with their errors, in lines."""
    width = max(map(len, SHOWN.values()))
    lines = [report["name"], ""]
    for name, shown in SHOWN.items():
        if report.get(name) is not None:
            lines.append(f"{shown:{width}}  {report[name]:<22.15g} +- {report['errors'][name]:.0e}")
    lines += ["", *(f"note: {note}" for note in report["notes"])]
    return "\n".join([*lines, CONVENTIONS["units"]])
