"""``isoembed embed`` for several files: a folder with surfaces and reports, and a table."""

import argparse
import csv
import io
import shlex
from pathlib import Path
from typing import Any

import numpy as np

from isoembed import Method
from isoembed.cli.batch import carried_out, seen_by_all
from isoembed.cli.console import UsageError, print_aside, print_json
from isoembed.cli.length_error import length_errors
from isoembed.cli.outputs import check_folder, elapsed, stems
from isoembed.io import mesh_writer, report_writer, write_atomically
from isoembed.runs import Result, Store
from isoembed.runs.embedding_task import EmbeddingTask

OF_ONE = ("report", "picture", "html", "animate", "keep", "checkpoint", "resume")
TABLE, SURFACE, REPORT = "table.csv", ".ply", ".json"
COLUMNS = {
    "vertices": ("input", "vertices"),
    "negative_deficits": ("input", "negative_deficits"),
    "residual": ("residual", "max"),
    **{
        column: place
        for name in ("area", "volume", "integrated_mean_curvature")
        for column, place in ((name, (name,)), (f"{name}_deviation", ("deviation", name)))
    },
    "chi_square": ("measured", "chi_square"),
    "concave_edges": ("convexity", "concave_edges"),
    "others": ("others",),
}
"""Columns of the table, with their keys in the report."""


def embed_files(options: argparse.Namespace, method: Method) -> int:
    """Embed all files into a folder; return the exit status."""
    for name in OF_ONE:
        if getattr(options, name, None):
            raise UsageError(f"--{name} is for a single input; an output folder contains all reports")
    if options.output is None:
        last = options.inputs[-1]
        meant = f"; did you mean -o {shlex.quote(last)}?" if last != "-" and not Path(last).exists() else ""
        raise UsageError(
            f"{len(options.inputs)} files need an --output: the folder for their surfaces{meant}"
        )
    check_folder(options.output)
    if "-" in options.inputs:
        raise UsageError("standard input, -, cannot be combined with other inputs")
    errors = length_errors(options)
    if errors is not None and errors.ndim:
        raise UsageError("--length-error must be a number for several files")
    error = None if errors is None else float(errors)
    tasks = [
        EmbeddingTask(stem, Path(name), method, options.tolerance, options.merge, options.space, error)
        for stem, name in zip(stems(options.inputs), seen_by_all(options, options.inputs), strict=True)
    ]
    folder = Path(*seen_by_all(options, [options.output]))
    inputs = {task.path.resolve(): task.path for task in tasks}
    for name in (TABLE, *(f"{task.label}{end}" for task in tasks for end in (SURFACE, REPORT))):
        if (same := inputs.get((folder / name).resolve())) is not None:
            raise UsageError(f"{folder / name} would overwrite the input {same}: take another folder")
    tally = carried_out(tasks, Store.made(folder), options, lambda result: _write(folder, result))
    table = None if options.shard else str(options.output / TABLE)
    if table:  # for shards, a later complete run writes it
        rows = [_row(result) for result in Store(folder).of({task.label for task in tasks})]
        write_atomically({folder / TABLE: lambda path: path.write_text(_csv(rows), encoding="utf-8")})
    if options.json:
        print_json({**tally.report, "table": table})
    else:
        files = f"{TABLE}, and " if table else ""
        print_aside(
            f"{tally}\nin {options.output}: {files}NAME{SURFACE} and NAME{REPORT} of each\n{elapsed(options)}"
        )
    return tally.exit_status


def _write(folder: Path, result: Result) -> None:
    """Write the report of a file and, if found, its surface."""
    writers = {folder / f"{result.label}{REPORT}": report_writer(result.report)}
    if result.answered:
        data = dict(result.arrays)
        vertices, corners, sizes = (data.pop(name) for name in ("vertices", "corners", "sizes"))
        faces: Any = np.split(corners, np.cumsum(sizes)[:-1])
        if (sizes == 3).all():
            faces = corners.reshape(-1, 3)
        path = folder / f"{result.label}{SURFACE}"
        writers[path] = mesh_writer(path, vertices, faces, **data)
    write_atomically(writers)


def _row(result: Result) -> dict[str, Any]:
    row: dict[str, Any] = {"name": result.label, "status": result.status}
    for column, place in COLUMNS.items():
        value: Any = result.report
        for key in place:
            value = value.get(key) if isinstance(value, dict) else None
        row[column] = value
    return {**row, "message": result.message}


def _csv(rows: list[dict[str, Any]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, ["name", "status", *COLUMNS, "message"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
