"""``isoembed horizon``: apparent horizons, read or found: embeddings, energies, pictures and files."""

import argparse
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from isoembed.cli.console import (
    NOT_EMBEDDED,
    OK,
    WRONG,
    UsageError,
    print_aside,
    print_error,
    print_json,
    print_out,
)
from isoembed.cli.options import (
    add_json_option,
    add_marginal_options,
    add_output_option,
    add_report_options,
    add_vertices_option,
    marginal,
    reference,
    refuse_given,
    vertices,
)
from isoembed.cli.outputs import Outputs, check_folder, print_written, stems
from isoembed.cli.slices import (
    OF_SLICE,
    add_slice_options,
    slice_label,
    slice_named,
    slice_stem,
)
from isoembed.errors import InvalidMetric, InvalidParameter, NoHorizon
from isoembed.io import FileError, mesh_writer, report_writer
from isoembed.io.files import AmbiguousFileError, check_target, input_ending, write_atomically
from isoembed.plot.picture import figure_writer
from isoembed.plot.series.stills import horizon_figures
from isoembed.relativity.energies.report import energy_table
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.finder import find_horizon
from isoembed.relativity.horizons.horizon import GivenHorizon
from isoembed.relativity.horizons.horizon_file import read_horizon
from isoembed.relativity.horizons.spectre import SPECTRE_ENDINGS, read_spectre
from isoembed.relativity.horizons.stability_spectrum import checked_eigenvalues, stability_spectrum
from isoembed.relativity.series.horizon_task import HorizonOptions, HorizonTask, mesh_of
from isoembed.relativity.series.moment import Moment
from isoembed.relativity.series.source import HeldShape, HeldSlice
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.runs.result import REFUSED, Result
from isoembed.runs.run import run as run_tasks

OF_FILES = ("time", "surface", "marginal", "not_marginal")
WRITTEN = ("vtk", "json", "png")

EXAMPLES = (
    "isoembed horizon --find --geometry kerr-schild --spin 0 0 0.5 -o found",
    "isoembed horizon h.t0.ah1.gp --geometry slice.h5 --json",
)
USUAL = ("find", "guess", "geometry", "spin", "masses", "positions", "space", "wang_yau", "output", "json")
"""Options listed by ``--help``."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed horizon``."""
    parser.add_argument(
        "files",
        nargs="*",
        metavar="FILE",
        help="horizons: h.t*.ah*.gp of AHFinderDirect or BHaHAHA, SpECTRE's *.vol or *_Ylm.dat, GRChombo's "
        "coords_AH*.dat, other HDF5, .npz, VTK, or a metric on a grid (.csv, too); several files form "
        "a sequence, each embedded from the previous one",
    )
    parser.add_argument(
        "--find",
        action="store_true",
        help="instead of files: find an outermost horizon of the --geometry, as far as proved or searched, "
        "or the one near the --guess",
    )
    parser.add_argument(
        "--guess",
        type=float,
        nargs=4,
        metavar=("X", "Y", "Z", "R"),
        help="center and radius of the initial sphere of --find",
    )
    parser.add_argument(
        "--stability",
        type=int,
        metavar="N",
        help="with --find: report the first N eigenvalues of the stability operator, complex in general",
    )
    add_slice_options(parser, "3-metric of the slice, missing from most horizon files")
    add_report_options(parser)
    add_marginal_options(
        parser, "of each file", "by default its expansion decides, and a metric without k is not one"
    )
    parser.add_argument("--time", type=float, metavar="T", help="which slice of a SpECTRE file with several")
    parser.add_argument("--surface", metavar="NAME", help="which surface of a SpECTRE file with several")
    add_output_option(
        parser,
        "where to write, for each file, NAME.vtk with the surface, NAME.png and NAME.json",
        metavar="FOLDER",
    )
    add_vertices_option(parser)
    add_json_option(parser, "print JSON: an object, or a list of them")


def run(options: argparse.Namespace) -> int:
    """Embed the horizons in sequence; return the exit status."""
    number = vertices(options)
    if options.axis and not any(options.axis):
        raise UsageError("--axis 0 0 0 is not an axis")
    spectrum = None
    try:
        if options.find:
            horizons, spectrum = _sought(options)
        else:
            horizons = _given(options)
    except NoHorizon as error:
        print_error(str(error))
        if options.json:
            status = "not found" if error.barriers is None else "not resolved"
            print_json({"status": status, "name": _found_name(options), **error.report})
        return NOT_EMBEDDED
    axis = tuple(options.axis) if options.axis else None
    horizon_options = HorizonOptions(
        number, options.wang_yau, axis, marginal(options), reference(options), options.multipoles
    )
    tasks = [
        HorizonTask(horizon, horizon_options) for horizon in horizons.values() if isinstance(horizon, Moment)
    ]
    outcomes = run_tasks(tasks, chunk=len(tasks))
    reports, drawn, files = [], dict[Path, Result](), list[Path]()
    for stem, horizon in horizons.items():
        result = next(outcomes).result if isinstance(horizon, Moment) else horizon
        report = {key: part for key, part in result.report.items() if key != "moment"}
        if spectrum is not None and "horizon" in report:
            report["horizon"] = {**report["horizon"], "stability_spectrum": spectrum}
        reports.append(report)
        refused = result.status == REFUSED
        if options.output and not refused:
            outputs = _outputs(options, stem)
            files += _write(outputs, result, report)
            if result.answered:
                drawn[outputs["png"]] = result
        if not result.answered:
            called, why = report.get("name", stem), result.message
            print_error(why if refused and called in why else f"{called}: {why}")
            if report.get("hindrance") and not report["space"]["curvature"]:
                print_error("--space hyperbolic, which embeds the whole surface", "try")
        if not refused and not options.json:
            (print_aside if options.output else print_out)(energy_table(report))
    found = {report["status"] for report in reports}
    if found == {REFUSED}:
        return WRONG
    if options.json:
        print_json(reports if len(reports) > 1 else reports[0])
    files += _draw(drawn) if drawn else []
    if not options.json:
        print_written(options, *files)
    return OK if found == {"embedded"} else NOT_EMBEDDED


def _given(options: argparse.Namespace) -> dict[str, Moment | Result]:
    """Horizons in files, by output name; some, but not all, may be refused."""
    if not options.files:
        raise UsageError("no horizon: give a FILE, or --find and a --geometry")
    refuse_given(options, ("guess", "stability"), "needs --find")
    geometry = None
    if options.geometry is None:
        refuse_given(options, OF_SLICE, "needs a --geometry")
    else:
        geometry = slice_named(options.geometry, options)
    names = stems(options.files)
    horizons: dict[str, Moment | Result] = {}
    refusals: list[Exception] = []
    for stem, name in zip(names, options.files, strict=True):
        try:
            horizons[stem] = _moment(_horizon(name, options, geometry), geometry, name)
        except (FileError, InvalidMetric, InvalidParameter) as error:
            refusals.append(error)
            horizons[stem] = Result.without_answer(stem, REFUSED, str(error), name=name)
    if len(refusals) == len(names):
        raise FileError("; ".join(map(str, refusals)))
    _make_folder(options, names)
    return horizons


def _sought(options: argparse.Namespace) -> tuple[dict[str, Moment | Result], dict[str, Any] | None]:
    """Horizon found in a slice, by output name, and its stability spectrum if requested."""
    if options.files:
        raise UsageError(f"--find takes no FILE, and {options.files[0]} is given")
    refuse_given(options, OF_FILES, "is for files, not for --find")
    if options.geometry is None:
        raise UsageError("--find needs a --geometry to find a horizon in")
    if options.geometry == "boyer-lindquist":
        raise UsageError(
            "Boyer-Lindquist coordinates are singular on the horizon: take --geometry kerr-schild, or "
            "'isoembed energy --spacetime kerr --surface horizon'"
        )
    if options.stability is not None:
        checked_eigenvalues(options.stability)  # before the computation
    geometry, guess, near = slice_named(options.geometry, options), None, ""
    if options.guess is not None:
        *center, radius = options.guess
        guess = StarSurface.sphere(center, radius)
        near = "".join(f"_{x:.9g}" for x in options.guess)
    stem = f"{slice_stem(options.geometry)}-horizon{near}"
    _make_folder(options, [stem])
    found = find_horizon(geometry, guess)
    spectrum = None if options.stability is None else stability_spectrum(found, options.stability).report
    return {stem: _moment(found, None, _found_name(options))}, spectrum


def _moment(found: GivenHorizon, geometry: ThreeGeometry | None, name: str) -> Moment:
    slice_ = None if geometry is None else HeldSlice(geometry)
    return Moment("horizon", None, None, HeldShape(found, name), slice_)


def _found_name(options: argparse.Namespace) -> str:
    near = "" if options.guess is None else " near ({:.9g}, {:.9g}, {:.9g}; {:.9g})".format(*options.guess)
    return f"horizon{near} in {slice_label(options.geometry, options)}"


def _make_folder(options: argparse.Namespace, stems: list[str]) -> None:
    """Create the output folder, and check that files can be written there."""
    if options.output:
        check_folder(options.output)
        try:
            options.output.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(f"cannot make the folder {options.output}: {error.strerror}") from None
        for stem in stems:
            for path in _outputs(options, stem).values():
                check_target(path)


def _outputs(options: argparse.Namespace, stem: str) -> Outputs:
    """Output files of one horizon."""
    return Outputs((end, options.output / f"{stem}.{end}") for end in WRITTEN)


def _write(outputs: Outputs, result: Result, report: dict[str, Any]) -> list[Path]:
    """Write the report and, if found, the surface."""
    if not result.answered:
        return outputs.write(json=lambda _: report_writer(report))
    return outputs.write(
        json=lambda _: report_writer(report),
        vtk=lambda path: mesh_writer(path, **mesh_of(result), **_when(report)),
    )


def _draw(drawn: dict[Path, Result]) -> list[Path]:
    """Write the pictures at a common scale, if matplotlib is installed."""
    if find_spec("matplotlib") is None:
        missing = "pictures need matplotlib, pip install matplotlib"
        print_error(f"{', '.join(map(str, drawn))} not written: {missing}")
        return []
    for path, picture in zip(drawn, horizon_figures(list(drawn.values())), strict=True):
        write_atomically({path: figure_writer(path, picture)})
    return list(drawn)


def _when(report: dict[str, Any]) -> dict[str, Any]:
    """Time and iteration of a horizon, if known."""
    horizon = report["horizon"]
    return {name: horizon[name] for name in ("time", "iteration") if horizon.get(name) is not None}


def _read(name: str, options: argparse.Namespace) -> CoordinateShape | SurfaceData:
    try:
        if options.time is None and options.surface is None:
            return read_horizon(name)
        if input_ending(name) not in SPECTRE_ENDINGS:
            raise UsageError(f"--time and --surface are for SpECTRE's files, and {name} is not one")
        return read_spectre(name, options.surface, options.time)
    except AmbiguousFileError as error:
        option = {"surface": "--surface", "observation": "--time"}[error.parameter]
        raise UsageError(f"{error.sentence}, by {option}") from None


def _horizon(
    name: str, options: argparse.Namespace, geometry: ThreeGeometry | None
) -> CoordinateShape | SurfaceData:
    found = _read(name, options)
    if isinstance(found, SurfaceData) and geometry is not None:
        raise UsageError(f"{name} holds a metric of its own: it needs no --geometry")
    if isinstance(found, SurfaceData) and options.axis is not None:
        raise UsageError(f"{name} has no coordinates for an --axis")
    if isinstance(found, CoordinateShape) and geometry is None:
        raise UsageError(f"{found.contents}: name it with --geometry")
    return found
