"""``isoembed series``: horizons of a whole simulation: tables, plots and films."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from isoembed.cli.batch import Tally, carried_out, print_failures, seen_by_all
from isoembed.cli.console import WRONG, UsageError, print_aside, print_error, print_json
from isoembed.cli.options import (
    OF_RUNS,
    add_json_option,
    add_marginal_options,
    add_output_option,
    add_report_options,
    add_run_options,
    add_vertices_option,
    marginal,
    reference,
    refuse_given,
    vertices,
)
from isoembed.cli.outputs import check_folder, elapsed
from isoembed.cli.slices import (
    CLOSED_FORMS,
    OF_SLICE,
    add_slice_options,
    slice_named,
)
from isoembed.errors import InvalidParameter
from isoembed.io import FileError, write_atomically
from isoembed.plot.picture import figure_writer
from isoembed.plot.series.curves import series_figures
from isoembed.plot.series.film import write_series_film
from isoembed.plot.series.page import write_series_page
from isoembed.plot.series.paraview import write_paraview
from isoembed.relativity.series.horizon_task import HorizonOptions, HorizonTask
from isoembed.relativity.series.moments import moments
from isoembed.relativity.series.table import write_table
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.runs import Outcome, Result, Store

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABLE = "table.csv"
FILMS = ("horizons.mp4", "horizons.gif", "horizons.html")
OF_HORIZONS = (
    "geometry",
    *OF_SLICE,
    "axis",
    "marginal",
    "not_marginal",
    "space",
    "surface",
    "vertices",
    "wang_yau",
)

EXAMPLES = (
    "isoembed series simulation -o results --film",
    "isoembed series h.t*.ah1.gp --geometry 'slices/{iteration}.h5' -o results",
)
USUAL = ("geometry", "space", "wang_yau", "multipoles", "output", "film", "jobs", "retry", "json", "quiet")
"""Options listed by ``--help``."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed series``."""
    parser.add_argument(
        "horizons",
        nargs="*",
        metavar="HORIZONS",
        help="files of horizons, of any time and number: h.t*.ah*.gp of AHFinderDirect or BHaHAHA, "
        "SpECTRE's *.vol or *_Ylm.dat, GRChombo's coords_AH*.dat, other HDF5 with one or many times, "
        ".npz, VTK, tables of metrics (.csv .txt .dat); or folders, or a simulation of the Einstein "
        "Toolkit; without files, the table and pictures are remade from the results in --output",
    )
    add_slice_options(
        parser,
        "slices that contain the horizons, unless these have metrics of their own: a pattern of "
        "files, 'slices/{iteration}.h5' or with {time}; a folder; a file with many times; or one for "
        "all",
    )
    add_report_options(parser)
    add_marginal_options(parser, "of each surface", "by default its expansion decides")
    parser.add_argument("--surface", metavar="NAME", help="which surface of SpECTRE files, if not all")
    add_vertices_option(parser)
    add_output_option(
        parser,
        "folder for the results, table.csv, table.h5, plots and files for ParaView",
        metavar="FOLDER",
        required=True,
    )
    add_run_options(parser)
    parser.add_argument(
        "--film", action="store_true", help="also make a film, and a page for the browser with a slider"
    )
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Embed the horizons, and make table and pictures of the results; return the exit status."""
    check_folder(options.output)
    folder = Path(*seen_by_all(options, [options.output]))
    store = Store(folder)
    if options.horizons:
        tasks = _tasks(options)
        table = _GrowingTable(folder / TABLE) if options.shard is None else None
        tally = carried_out(tasks, Store.made(folder), options, table)
        results = None if options.shard else list(store.of(task.label for task in tasks))
    else:
        refuse_given(options, (*OF_HORIZONS, *OF_RUNS), "needs HORIZONS")
        results = list(store)
        tally = _tally(results)
    status, written = tally.exit_status, list[str]()
    if results is not None:  # other shards may still be running
        written, missing = _products(folder, results, film=options.film)
        for sentence in missing:
            print_error(sentence)
            status = WRONG
        if options.film and not any(result.answered for result in results):
            print_error("there is no film: no horizon is embedded", "note")
        stale = [name for name in FILMS if name not in written and (folder / name).exists()]
        if stale and not options.quiet:
            print_error(f"of an earlier command: {', '.join(stale)}; --film makes a new one", "note")
    if options.json:
        print_json({**tally.report, "folder": str(options.output), "files": written})
    else:
        lines = [str(tally)]
        if written:
            lines.append(f"in {options.output}: {', '.join(written)}")
        print_aside("\n".join([*lines, elapsed(options)]))
    return status


def _tally(results: Sequence[Result]) -> Tally:
    """Counts of stored results; failures are printed as after a computation."""
    tally = Tally(len(results))
    for result in results:
        tally.add(Outcome(result, computed=False))
    print_failures(tally)
    return tally


def _tasks(options: argparse.Namespace) -> list[HorizonTask]:
    """Tasks for the requested horizons."""
    axis = None if options.axis is None else tuple(options.axis)
    horizon_options = HorizonOptions(
        vertices(options), options.wang_yau, axis, marginal(options), reference(options), options.multipoles
    )
    listed = moments(seen_by_all(options, options.horizons), _geometry(options), surface=options.surface)
    return [HorizonTask(moment, horizon_options) for moment in listed]


def _geometry(options: argparse.Namespace) -> str | ThreeGeometry | None:
    """Slice in closed form, or location of the slice files."""
    if options.geometry is None:
        refuse_given(options, OF_SLICE, "needs a --geometry")
        return None
    if options.geometry in CLOSED_FORMS:
        return slice_named(options.geometry, options)
    refuse_given(options, OF_SLICE, "needs a --geometry in closed form")
    return seen_by_all(options, [options.geometry])[0]


class _GrowingTable:
    """Table of the results so far, rewritten periodically."""

    def __init__(self, path: Path) -> None:
        self._path, self._results, self._written = path, list[Result](), time.monotonic()

    def __call__(self, result: Result) -> None:
        self._results.append(replace(result, arrays={}))  # meshes would take too much memory
        if time.monotonic() > self._written + 20.0:  # seconds between updates of the table
            write_table(self._path, self._results)
            self._written = time.monotonic()


def _products(folder: Path, results: Sequence[Result], *, film: bool) -> tuple[list[str], list[str]]:
    """Make all files of the results in a folder; return their names, and reasons for missing ones."""
    if not results:
        raise UsageError(f"there are no results in {folder}")
    written, missing = list[str](), list[str]()

    def make(name: str, write: Callable[[Path, Iterable[Result]], None]) -> None:
        try:
            write(folder / name, results)
            written.append(name)
        except (FileError, InvalidParameter) as error:
            missing.append(str(error))

    make(TABLE, write_table)
    if find_spec("h5py"):
        make("table.h5", write_table)
    if any(result.answered for result in results):
        make("horizons.pvd", write_paraview)
        if find_spec("matplotlib"):
            for name, figure in series_figures(results).items():
                make(f"{name}.png", partial(_write_figure, figure))
        if film:
            make("horizons.mp4" if find_spec("imageio_ffmpeg") else "horizons.gif", write_series_film)
            make(FILMS[-1], write_series_page)
    return written, missing


def _write_figure(figure: Figure, path: Path, _: Iterable[Result]) -> None:
    write_atomically({path: figure_writer(path, figure)})
