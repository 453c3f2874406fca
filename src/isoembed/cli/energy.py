"""``isoembed energy``: quasi-local energies of closed forms, surfaces from files, and spheres in a slice."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import isoembed
from isoembed.arrays import Floats
from isoembed.cli.closed_form import OF_SPACETIME, add_spacetime_options, closed_form
from isoembed.cli.console import NOT_EMBEDDED, OK, UsageError, print_error, print_json, print_out
from isoembed.cli.embedding_output import solved
from isoembed.cli.length_error import add_length_error_option, length_errors, not_rigid
from isoembed.cli.numbers import read_numbers
from isoembed.cli.options import (
    add_json_option,
    add_marginal_options,
    add_merge_option,
    add_output_option,
    add_reference_option,
    add_vertices_option,
    marginal,
    reference,
    refuse_given,
    vertices,
)
from isoembed.cli.outputs import Outputs, print_written
from isoembed.cli.pictures import add_picture_options, check_pictures, picture_writers
from isoembed.cli.slices import OF_SLICE, add_slice_options, slice_label, slice_named
from isoembed.errors import InvalidMetric, NotEmbedded
from isoembed.io import MESH_ENDINGS, SURFACE_ENDINGS, mesh_writer, surface_writer, write_atomically
from isoembed.io.files import Writer, input_ending
from isoembed.io.metric import in_space
from isoembed.io.surface import read_with_curvatures
from isoembed.io.title_line import WRITTEN
from isoembed.linalg import SingularMatrix
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.plot.coloring import from_file
from isoembed.plot.endings import PAGE_ENDINGS, PICTURE_ENDINGS
from isoembed.plot.series.stills import measures_caption
from isoembed.relativity.energies.embedded_surface import conventions, embed_surface, embedded_report
from isoembed.relativity.energies.mesh_energies import mesh_deviation, mesh_energies
from isoembed.relativity.energies.report import checked_report, energy_table, mesh_report, unembedded_report
from isoembed.relativity.energies.wang_yau_result import WangYau
from isoembed.relativity.horizons.curvature_check import CurvatureCheck
from isoembed.relativity.horizons.expansion import classify_horizon, classify_surface
from isoembed.relativity.horizons.grid_file import read_metric_or_grid
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.two_metric import TwoMetric
from isoembed.space import Space
from isoembed.space.models import to_model
from isoembed.surface.smooth_integrals import Lengths

OF_METRIC = ("merge", "mean_curvature", "momentum", "normal_momentum", "lengths", "length_error")
IN_SLICE = ("geometry", *(name for name in OF_SLICE if name not in OF_SPACETIME))
OF_DECISION = ("marginal", "not_marginal")
OF_SMOOTH = ("best_fit", "band", "wang_yau", *OF_DECISION)

EXAMPLES = (
    "isoembed energy --spacetime kerr --spin 0.5 --surface horizon",
    "isoembed energy --spacetime kerr --spin 0.9 --surface horizon --space hyperbolic",
)
USUAL = (
    "spacetime",
    "spin",
    "mass",
    "surface",
    "sphere",
    "geometry",
    "mean_curvature",
    "space",
    "wang_yau",
    "output",
)
"""Options listed by ``--help``."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed energy``."""
    parser.add_argument(
        "input",
        nargs="?",
        metavar="METRIC",
        help="surface file: a metric on triangles (.npz or .json with faces, edges, lengths, or a mesh), "
        "or on a grid (.npz .h5 .hdf5, or a table .csv .txt .dat, with theta, phi, q_tt, q_tp, q_pp, "
        "and maybe k, p, j_t, j_p); with --sphere the slice, as a --geometry",
    )
    add_merge_option(parser)
    parser.add_argument(
        "--mean-curvature",
        type=Path,
        metavar="K.npy",
        help="k = k1 + k2 in the slice of spacetime, at the vertices or the grid nodes",
    )
    parser.add_argument(
        "--momentum",
        type=Path,
        metavar="P.npy",
        help="p = K_ij (gamma^ij - n^i n^j) at the same points (default 0)",
    )
    parser.add_argument(
        "--normal-momentum",
        type=Path,
        metavar="J.npy",
        help="on a grid, for the spin and --wang-yau: the components of K(., n) for theta and phi, an array "
        "(2, n, m)",
    )
    parser.add_argument(
        "--lengths",
        choices=("geodesic", "chord"),
        help="kind of the edge lengths: geodesic, as computed by isoembed triangulate, or Euclidean "
        "distances, as in meshes and from isoembed surface (default: chord for meshes, otherwise "
        "geodesic with errors wide enough for both)",
    )
    add_length_error_option(
        parser, "; only for a METRIC of triangles, whose energies then have standard deviations"
    )
    add_marginal_options(parser, "of a surface on a grid or in a slice", "by default it is not one")
    add_spacetime_options(parser)
    parser.add_argument(
        "--sphere",
        type=float,
        nargs=4,
        metavar=("X", "Y", "Z", "R"),
        help="the coordinate sphere with this center and radius, in a slice of spacetime",
    )
    add_slice_options(parser, "the slice of a --sphere", mass_and_spin=False)
    add_reference_option(parser)
    add_vertices_option(parser)
    add_json_option(parser)
    add_output_option(
        parser, f"file for the embedded surface, in the format of its extension: {' '.join(SURFACE_ENDINGS)}"
    )
    add_picture_options(parser, films=False)
    parser.add_argument(
        "--wang-yau",
        action="store_true",
        help="add the Wang-Yau energy of a smooth surface, minimized over time functions from tau = 0; "
        "--output then writes the projection of its surface in Minkowski space, with tau at the "
        "vertices; with a --space, that of tau = 0 with (anti-)de Sitter space for reference",
    )
    parser.add_argument(
        "--best-fit",
        action="store_true",
        help="if no embedding of a smooth surface is found, take the nearest approximation",
    )
    parser.add_argument(
        "--band",
        type=Path,
        metavar="FILE",
        help="if no embedding of an axisymmetric surface is found, write its largest embeddable band as a "
        "mesh",
    )


def run(options: argparse.Namespace) -> int:
    """Compute the energies; return the exit status."""
    number = vertices(options)
    check_pictures(options)
    outputs = Outputs.of(
        options, output=SURFACE_ENDINGS, band=SURFACE_ENDINGS, picture=PICTURE_ENDINGS, html=PAGE_ENDINGS
    )
    if options.sphere is not None:
        return _smooth(options, outputs, _sphere(options), number)
    if options.spacetime is not None:
        refuse_given(options, ("input", *OF_METRIC, *OF_DECISION), "does not go with a --spacetime")
        refuse_given(options, IN_SLICE, "does not go with a --spacetime: it needs a --sphere")
        return _smooth(options, outputs, closed_form(options), number)
    refuse_given(options, IN_SLICE, "needs a --sphere, the surface in the slice")
    refuse_given(options, OF_SPACETIME, "needs a --spacetime")
    if options.input is None:
        raise UsageError(
            "which surface? Give a METRIC, or a --spacetime and a --surface, or a --geometry and a --sphere"
        )
    errors = length_errors(options)
    metric = read_metric_or_grid(options.input, merge=options.merge, length_errors=errors)
    if isinstance(metric, SurfaceData):
        return _smooth(options, outputs, _on_grid(options, metric), number)
    return _triangles(options, outputs, metric)


def _smooth(options: argparse.Namespace, outputs: Outputs, data: SurfaceData, number: int) -> int:
    try:
        surface = embed_surface(data, space=reference(options), vertices=number, best_fit=options.best_fit)
    except NotEmbedded as error:
        print_error(str(error))
        for option in _instead(options, data, error.embedding):
            print_error(option, "try")
        _print_unwritten(outputs)
        band = _write_band(outputs, data, error.embedding.space) if options.band else []
        report = {**unembedded_report(data, error), "conventions": conventions(error.embedding.space)}
        _show(options, _with_check(data, report))
        _end(options, band)
        return NOT_EMBEDDED
    found = surface.wang_yau if options.wang_yau else None
    shown = found if isinstance(found, WangYau) else surface
    if options.band:
        why = "the whole surface embeds" if surface.embedding.converged else "the best fit was requested"
        print_error(f"{options.band} is not written: {why}")
    report = embedded_report(surface, found)
    try:
        _show(options, _with_check(data, report))
    finally:
        mesh = shown.mesh(number) if outputs else {}
        caption = "" if shown is found else measures_caption(report)
        pictures = _pictures(options, mesh, caption)
        files = outputs.write(output=lambda path: mesh_writer(path, **mesh), **pictures)
    _end(options, files)
    return OK


def _pictures(
    options: argparse.Namespace, mesh: dict[str, Any], caption: str
) -> dict[str, Callable[[Path], Writer]]:
    """Writers of the requested pictures, equivalent to `isoembed view` of the mesh file."""
    if not (options.picture or options.html):
        return {}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "surface.npz"
        write_atomically({path: mesh_writer(path, **mesh)})
        surface, curvatures = read_with_curvatures(path)
    return picture_writers(options, surface, given=from_file(curvatures), caption=caption)


def _instead(options: argparse.Namespace, data: SurfaceData, attempt: SmoothEmbedding) -> Iterator[str]:
    """Suggested options if there is no embedding in Euclidean space."""
    if attempt.hindrance and attempt.space.is_euclidean:
        yield "--space hyperbolic, which embeds the whole surface"
        about_z = attempt.coordinates is None and attempt.harmonics.order < attempt.harmonics.degree
        if about_z and not options.band:
            with suppress(InvalidMetric):
                if AxisymmetricEmbedding.of(data.metric, space=attempt.space).bands:
                    yield "--band FILE, which writes the band that embeds"


def _with_check(data: SurfaceData, report: dict[str, Any]) -> dict[str, Any]:
    """Report with a check of the curvature in the file, if given."""
    return report if data.gaussian_curvature is None else checked_report(report, CurvatureCheck.of(data))


def _write_band(outputs: Outputs, data: SurfaceData, space: Space) -> list[Path]:
    """Write the largest band of an axisymmetric surface that embeds, or print why none is written."""
    try:
        bands = AxisymmetricEmbedding.of(data.metric, space=space).bands
    except InvalidMetric as error:
        print_error(f"--band is for surfaces that are symmetric about the z-axis: {error}")
        return []
    if not bands:
        print_error(f"{outputs['band']} is not written: no part of the surface is one of revolution")
        return []
    vertices, faces = max(bands, key=lambda band: band.area).mesh()
    vertices = to_model(space, vertices, WRITTEN)
    tables = {} if space.is_euclidean else {"curvature": np.array(space.curvature)}
    return outputs.write(band=lambda path: mesh_writer(path, vertices, faces, **tables))


def _sphere(options: argparse.Namespace) -> SurfaceData:
    """Coordinate sphere in a slice, selected by the options."""
    refuse_given(
        options,
        ("spacetime", "charge", "cosmological_constant", "surface", "slice", *OF_METRIC),
        "does not go with a --sphere",
    )
    if (options.geometry is None) == (options.input is None):
        raise UsageError("a --sphere lies in one slice: give a --geometry, or a file")
    name = options.geometry or options.input
    geometry = slice_named(name, options)
    *center, radius = options.sphere
    where = ", ".join(f"{x:.9g}" for x in center)
    data = StarSurface.sphere(center, radius).data(
        geometry, name=f"sphere of radius {radius:.9g} about ({where}) in {slice_label(name, options)}"
    )
    return _decided(options, data)


def _decided(options: argparse.Namespace, data: SurfaceData) -> SurfaceData:
    """Data of a surface, classified as horizon or not, as far as the options decide."""
    is_marginal = marginal(options)
    return classify_surface(data) if is_marginal is None else classify_horizon(data, is_marginal)


def _on_grid(options: argparse.Namespace, data: SurfaceData) -> SurfaceData:
    """Surface of a metric on a grid, with data from the options."""
    refuse_given(options, ("lengths", "length_error", "merge"), "is for a METRIC of triangles")
    functions: dict[str, Callable[[Floats], Floats]] = {}
    for name in ("mean_curvature", "momentum", "normal_momentum"):
        path = getattr(options, name)
        if path is None:
            continue
        if getattr(data, name) is not None:
            raise UsageError(f"--{name.replace('_', '-')} is in {data.name} already")
        functions[name] = _on_nodes(data.metric, read_numbers(path), name, path)
    data = replace(data, **functions)  # type: ignore[arg-type] # by the names of fields
    if data.momentum is not None and data.mean_curvature is None:
        raise UsageError("the momentum requires the mean curvature: give --mean-curvature, too")
    return _decided(options, data)


def _on_nodes(metric: TwoMetric, values: Floats, name: str, path: Path) -> Callable[[Floats], Floats]:
    """Function interpolated from values at the nodes of a grid."""
    assert isinstance(metric, GridMetric)
    if name != "normal_momentum":
        return metric.function(values, str(path))
    if values.ndim != 3 or len(values) != 2:
        raise UsageError(f"{path} has the shape {values.shape}, not (2, n, m)")
    return metric.one_form(values[0], values[1], str(path))


def _triangles(options: argparse.Namespace, outputs: Outputs, metric: PolyhedralMetric) -> int:
    k, p = (path and read_numbers(path) for path in (options.mean_curvature, options.momentum))
    refuse_given(options, ("normal_momentum",), "is for a METRIC on a grid")
    refuse_given(options, ("vertices",), "is for smooth surfaces: this METRIC has its own")
    refuse_given(options, OF_SMOOTH, "is for smooth surfaces")
    own, metric = metric.space, in_space(metric, options.space, options.input)
    lengths: Lengths | None = options.lengths
    if lengths is None and input_ending(options.input) in MESH_ENDINGS and metric.space == own:
        lengths = "chord"  # in the space of the file; in another one they are neither
    errors = None if options.length_error is None else metric.length_errors
    exact = metric if errors is None else metric.exact
    embedding, failure = solved(options, lambda progress: isoembed.embed(exact, progress=progress))
    if failure is not None:
        if options.json:
            print_json({"status": "not embedded", "name": str(options.input), **failure.report})
        print_error(str(failure))
        _print_unwritten(outputs)
        return NOT_EMBEDDED
    energies = mesh_energies(embedding, k, p, lengths=lengths)
    try:
        deviation = None if errors is None else mesh_deviation(embedding, errors, k, p, lengths=lengths)
    except SingularMatrix:
        raise not_rigid(f"the surface of {options.input}") from None
    try:
        _show(options, mesh_report(embedding, energies, lengths, str(options.input), deviation))
    finally:
        pictures = picture_writers(options, embedding)
        files = outputs.write(output=lambda path: surface_writer(path, embedding), **pictures)
    _end(options, files)
    return OK


def _print_unwritten(outputs: Outputs) -> None:
    """Print the names of files that are not written because there is no surface."""
    if files := [str(path) for name, path in outputs.items() if name != "band"]:
        print_error(f"{', '.join(files)} not written: there is no surface")


def _show(options: argparse.Namespace, report: dict[str, Any]) -> None:
    if options.json:
        print_json(report)
    else:
        print_out(energy_table(report))


def _end(options: argparse.Namespace, files: list[Path]) -> None:
    if not options.json:
        print_written(options, *files)
