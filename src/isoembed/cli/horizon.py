"""``isoembed horizon``: from horizon files to embeddings, energies, pictures and files for ParaView."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.cli.energies import DEFAULT, FEWEST, table
from isoembed.cli.refusal import UsageError
from isoembed.cli.screen import print_error, print_out
from isoembed.cli.status import NOT_EMBEDDED, OK
from isoembed.errors import NotEmbedded
from isoembed.io import FileError, mesh_writer, report_writer, write_atomically
from isoembed.io.files import Writer, ending
from isoembed.io.hdf5 import HDF5_ENDINGS
from isoembed.meshing.sphere import gauss_rule
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.relativity.energies.embedded import EmbeddedSurface, embed_surface
from isoembed.relativity.energies.quadrature import intrinsic_energies
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.horizon_file import read_horizon
from isoembed.relativity.horizons.spectre import read_spectre
from isoembed.relativity.spacetimes.cartesian_grid import read_cartesian_grid
from isoembed.relativity.spacetimes.conformally_flat import IsotropicSchwarzschild
from isoembed.relativity.spacetimes.kerr_schild import KerrSchild, horizon_radius
from isoembed.relativity.spacetimes.painleve_gullstrand import PainleveGullstrand
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.grid_metric import GridMetric
from isoembed.surface.embedding import Embedding

NODES = (48, 96)  # at which a surface from a file is looked at
MARGINAL = 0.1  # times the mean radius: 2 for a sphere in flat space
WRITTEN = (".vtk", ".json", ".png")
GEOMETRIES = ("kerr-schild", "isotropic", "painleve-gullstrand")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed horizon``."""
    parser.add_argument(
        "files",
        nargs="+",
        metavar="FILE",
        help="horizons: AHFinderDirect's h.t*.ah*.gp, SpECTRE's or other HDF5, .npz, VTK, or a metric on a "
        "grid; several are taken as a sequence, and each is embedded from the one before",
    )
    parser.add_argument(
        "--geometry",
        metavar="GEOMETRY",
        help="the 3-metric of the slice, which most horizon files lack: a file (.h5 .hdf5 .npz) with "
        f"gxx ... gzz, and kxx ... kzz, on a Cartesian grid; or one of {', '.join(GEOMETRIES)}",
    )
    parser.add_argument("--mass", type=float, metavar="M", help="of the closed-form geometry (default 1)")
    parser.add_argument(
        "--spin",
        type=float,
        nargs=3,
        metavar=("AX", "AY", "AZ"),
        help="the vector a = J/M of the closed-form geometry, a length (default 0 0 0)",
    )
    parser.add_argument(
        "--axis",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="the axis of the angular momentum (default that of --spin, or z)",
    )
    parser.add_argument("--time", type=float, metavar="T", help="which slice of a SpECTRE file with several")
    parser.add_argument("--surface", metavar="NAME", help="which surface of a SpECTRE file with several")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="where to write, for each file, NAME.vtk with the surface, NAME.png and NAME.json",
    )
    parser.add_argument(
        "--vertices",
        type=int,
        default=DEFAULT,
        metavar="N",
        help=f"of the mesh that finds the surface, and of the one that is written (default {DEFAULT})",
    )
    parser.add_argument("--json", action="store_true", help="print JSON: an object, or a list of them")


def run(options: argparse.Namespace) -> int:
    """Embed the horizons one after the other; return the exit status."""
    if options.vertices < FEWEST:
        raise UsageError(f"--vertices must be at least {FEWEST}, not {options.vertices}")
    geometry = _geometry(options)
    stems = _stems(options.files)
    horizons = [(name, _data(name, _read(name, options), geometry, _axis(options))) for name in options.files]
    if options.output:
        try:
            options.output.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(f"cannot make the folder {options.output}: {error.strerror}") from None
    reports: list[dict[str, Any]] = []
    before: EmbeddedSurface | None = None
    status = OK
    for stem, (name, (data, facts)) in zip(stems, horizons, strict=True):
        try:
            surface = _embedded(data, before, options.vertices)
        except NotEmbedded as error:
            found = intrinsic_energies(data).report
            report = {
                "status": "not embedded",
                "message": str(error),
                "name": name,
                **found,
                "horizon": facts,
            }
            reports.append(report)
            if options.output:
                path = options.output / f"{stem}.json"
                write_atomically({path: report_writer(report)})
            print_error(f"{name}: {error}")
            status = NOT_EMBEDDED
            continue
        before = surface
        report = {**surface.report, "horizon": facts}
        reports.append(report)
        if options.output:
            write_atomically(_writers(options.output / stem, surface, report, options.vertices))
        if not options.json:
            print_out(_text(report))
    if options.json:
        print_out(json.dumps(reports if len(options.files) > 1 else reports[0], indent=2, allow_nan=False))
    return status


def _embedded(data: SurfaceData, before: EmbeddedSurface | None, vertices: int) -> EmbeddedSurface:
    """Deform the surface before; where that leads nowhere, begin with a mesh."""
    if before is not None:
        try:
            return embed_surface(data, start=before)
        except NotEmbedded:
            pass
    return embed_surface(data, vertices=vertices)


def _geometry(options: argparse.Namespace) -> ThreeGeometry | None:
    name, mass = options.geometry, 1.0 if options.mass is None else options.mass
    spin = options.spin or (0.0, 0.0, 0.0)
    if name not in GEOMETRIES:
        for given in ("mass", "spin"):
            if getattr(options, given) is not None:
                raise UsageError(f"--{given} needs a --geometry among {', '.join(GEOMETRIES)}")
        return None if name is None else read_cartesian_grid(name)
    if name == "kerr-schild":
        horizon_radius(mass, spin)  # refuses a spin beyond the mass
        return KerrSchild(mass, spin)
    if any(spin):
        raise UsageError(f"the geometry {name} has no spin: take kerr-schild")
    return IsotropicSchwarzschild(mass) if name == "isotropic" else PainleveGullstrand(mass)


def _axis(options: argparse.Namespace) -> tuple[float, float, float]:
    given = options.axis or (options.spin if options.spin and any(options.spin) else (0.0, 0.0, 1.0))
    if not any(given):
        raise UsageError("--axis 0 0 0 is no axis")
    return tuple(given)


def _stems(files: list[str]) -> list[str]:
    """Names for what is written, one for each file."""
    stems = [Path(name).name.removesuffix(".gz").rsplit(".", 1)[0] or Path(name).name for name in files]
    for k, stem in enumerate(stems):
        if stem in stems[:k]:
            raise UsageError(f"{files[stems.index(stem)]} and {files[k]} have the same name: {stem}")
    return stems


def _read(name: str, options: argparse.Namespace) -> CoordinateShape | GridMetric:
    if options.time is None and options.surface is None:
        return read_horizon(name)
    if ending(name) not in HDF5_ENDINGS:
        raise UsageError(f"--time and --surface are for SpECTRE's HDF5 files, and {name} is none")
    return read_spectre(name, options.surface, options.time)


def _data(
    name: str,
    found: CoordinateShape | GridMetric,
    geometry: ThreeGeometry | None,
    axis: tuple[float, float, float],
) -> tuple[SurfaceData, dict[str, Any]]:
    """The surface of a file, and what is known of it as a horizon."""
    if isinstance(found, GridMetric):
        if geometry is not None:
            raise UsageError(f"{name} holds a metric of its own: it needs no --geometry")
        return SurfaceData(found, marginal=True, relative_error=found.truncation, name=name), {}
    if geometry is None:
        raise UsageError(f"{found.contents}: name it with --geometry")
    surface = StarSurface.from_points(found.points, found.center.tolist())
    u, weights = gauss_rule(*NODES)
    mean = float(np.average(surface.radius(u), weights=weights))
    data = surface.data(geometry, axis, name=name)
    expansion = float(np.abs(surface.expansion(geometry, u)).max())
    # A horizon that was found on a coarse grid is one; what expands like a sphere in flat space is not.
    marginal = expansion * mean < MARGINAL
    return replace(data, marginal=marginal), {
        "time": found.time,
        "points": len(found.points),
        "center": list(found.center),
        "mean_coordinate_radius": mean,
        "misfit": surface.misfit,
        "largest_expansion": expansion,
        "marginal": marginal,
    }


def _writers(
    stem: Path, surface: EmbeddedSurface, report: dict[str, Any], vertices: int
) -> dict[Path, Writer]:
    """What writes the surface, its report and, where matplotlib is installed, its picture."""
    tables = surface.mesh(vertices)
    vtk, report_file, picture = (stem.with_name(f"{stem.name}{ending}") for ending in WRITTEN)
    writers = {vtk: mesh_writer(vtk, **tables), report_file: report_writer(report)}
    if find_spec("matplotlib") is None:
        print_error(f"{picture} is not written: pictures need matplotlib, pip install 'isoembed[plot]'")
    else:
        writers[picture] = _picture(picture, surface, tables)
    return writers


def _picture(path: Path, surface: EmbeddedSurface, tables: dict[str, NDArray[Any]]) -> Writer:
    from isoembed.plot import Quantity, picture_writer

    metric = PolyhedralMetric.from_mesh(tables["vertices"], tables["faces"])
    drawn = Embedding(metric, tables["vertices"], method="harmonics", tolerance=surface.embedding.tolerance)
    energies = surface.energies
    caption = (
        f"{Path(surface.data.name).name}     area {energies.area.value:.8g}     "
        rf"$\int\! H\,dA = {surface.embedding.integrated_mean_curvature:.8g}$"
    )
    exact = Quantity("mean curvature", "mean curvature  $H = (k_1 + k_2)/2$", tables["mean_curvature"])
    return picture_writer(path, drawn, color=exact, caption=caption)


def _text(report: dict[str, Any]) -> str:
    """The energies, and what the file was like."""
    horizon = report["horizon"]
    if not horizon:
        return table(report)
    return (
        f"{table(report)}\n{horizon['points']} points, fitted to {horizon['misfit']:.1e} of a mean radius "
        f"{horizon['mean_coordinate_radius']:.6g} in coordinates; the expansion of outgoing rays, 0 on a "
        f"horizon, is at most {horizon['largest_expansion']:.1e}"
        + ("" if horizon["marginal"] else ": in this geometry it is no horizon")
    )
