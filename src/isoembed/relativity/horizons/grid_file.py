"""Reader for metrics and data on (theta, phi) grids, distinguished from metrics on triangles."""

import os
import re
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from isoembed.errors import InvalidMetric
from isoembed.io.files import FileError, Tables, check_ending, input_ending
from isoembed.io.hdf5 import HDF5_ENDINGS, enumerated
from isoembed.io.input_file import InputFile, opened
from isoembed.io.metric import read_metric
from isoembed.io.text_table import read_text_table, words_of
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.relativity.horizons.curvature_check import brought_curvature
from isoembed.relativity.horizons.horizon_format import HorizonFormat
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.grid_metric import GridMetric

ARRAY_ENDINGS = (".npz", *HDF5_ENDINGS)
TEXT_ENDINGS = (".csv", ".txt", ".dat")
GRID_ENDINGS = (*ARRAY_ENDINGS, *TEXT_ENDINGS)
ANGLES = ("theta", "phi")
NUMBERED = re.compile(r"(?<!\S)\d+:(?=[A-Za-z])")  # as in 3:q_tt, the third column
NEEDED = (*ANGLES, "q_tt", "q_pp")


def read_metric_grid(path: str | os.PathLike[str]) -> GridMetric:
    """Read a metric on a grid in theta and phi.

    Parameters
    ----------
    path : path
        As in `read_grid_data`; k, p and j are ignored.

    Returns
    -------
    GridMetric

    Raises
    ------
    FileError
        The file cannot be read, or arrays are missing; the message names them.
    InvalidMetric
        The contents are not a metric on such a grid.
    """
    check_ending(path, GRID_ENDINGS)
    with opened(path) as file:
        return _metric(file, _tables(file))


def read_grid_data(path: str | os.PathLike[str]) -> SurfaceData:
    """Read a metric on a grid in theta and phi, with the extrinsic quantities that the file has.

    Parameters
    ----------
    path : path
        Either ``.npz``, ``.h5`` or ``.hdf5``, with all arrays at the top level or in one group: ``theta``
        (n,), ``phi`` (m,), and ``q_tt``, ``q_tp``, ``q_pp`` (n, m) as in `GridMetric`, or (n,) for a single
        phi; ``q_tp`` defaults to 0.  Or a table in ``.csv``, ``.txt`` or ``.dat`` with one row per node and
        these names above its columns; without phi the metric is symmetric about z.  Optional: ``k``, ``p``
        (n, m), the components ``j_t`` and ``j_p`` of K(., n) along theta and phi (see `SurfaceData`), and a
        Gaussian curvature to compare with that of the metric (see `CurvatureCheck`).

    Returns
    -------
    SurfaceData
        Its name is that of the file.

    Raises
    ------
    FileError
        The file cannot be read, or arrays are missing; the message names them.
    InvalidMetric
        The contents are not a metric on such a grid, or the grid is too coarse for the other arrays.
    """
    check_ending(path, GRID_ENDINGS)
    with opened(path) as file:
        tables = _tables(file)
        missing = [name for name in ("j_t", "j_p") if name not in tables]
        if len(missing) == 1:
            raise FileError(f"{file} has no {missing[0]}, the other component of K(., n)")
        there: dict[str, Any] = {
            "mean_curvature": tables.get("k"),
            "momentum": tables.get("p"),
            "normal_momentum": None if missing else [tables["j_t"], tables["j_p"]],
            "gaussian_curvature": brought_curvature(tables)[1],
        }
        try:
            return SurfaceData(_metric(file, tables), **there, name=str(file))
        except InvalidMetric as error:
            raise _with_name(error, file) from None


def read_metric_or_grid(
    path: str | os.PathLike[str], *, merge: float | None = None, length_errors: ArrayLike | None = None
) -> PolyhedralMetric | SurfaceData:
    """Read a metric on triangles or on a grid, as the file has it; see `read_metric` and `read_grid_data`.

    Parameters
    ----------
    path : path
    merge, length_errors : optional
        Options of `read_metric`, for a metric on triangles.

    Raises
    ------
    FileError
        The file cannot be read, or its ending is unknown.
    InvalidMetric
        The contents are not a metric.
    """
    if input_ending(path) not in GRID_ENDINGS:
        return read_metric(path, merge=merge, length_errors=length_errors)
    with opened(path) as file:
        if file.ending in TEXT_ENDINGS:
            is_grid = file.ending != ".csv" or "theta" in " ".join(_columns(file)).lower()
            return read_grid_data(file) if is_grid else read_metric(file, length_errors=length_errors)
        is_grid = file.ending != ".npz" or holds_metric_grid(file) or "theta" in file.arrays[""]
        if is_grid:
            return read_grid_data(file)
        return read_metric(file, merge=merge, length_errors=length_errors)


def holds_metric_grid(file: InputFile) -> bool:
    """Whether arrays or columns of a file are components of a metric on a grid."""
    if file.ending in TEXT_ENDINGS:
        return _is_metric(dict.fromkeys(_columns(file)))
    return file.ending in ARRAY_ENDINGS and any(map(_is_metric, file.arrays.values()))


def _is_metric(tables: Tables) -> bool:
    return "q_tt" in tables or "q_pp" in tables


def _tables(file: InputFile) -> Tables:
    """Arrays of the single metric in a file; for a single phi, arrays along theta get a second axis."""
    tables = _table_on_grid(file) if file.ending in TEXT_ENDINGS else _arrays(file)
    missing = [name for name in NEEDED if name not in tables]
    if missing:
        there = enumerated(tables) if tables else file.contents
        raise FileError(f"{file} holds {there}: {' and '.join(missing)} missing from a metric on a grid")
    if np.size(tables["phi"]) != 1:
        return tables
    n = np.shape(tables["theta"])
    along = {
        name: values[:, None]
        for name, values in tables.items()
        if np.shape(values) == n and name not in ANGLES
    }
    return {**tables, **along, "phi": np.reshape(tables["phi"], 1)}


def _arrays(file: InputFile) -> Tables:
    found = {name: tables for name, tables in file.arrays.items() if _is_metric(tables)}
    tables = next(iter(found.values())) if found else file.arrays[""]
    if len(found) > 1:
        raise FileError(f"{file} holds {len(found)} metrics, in the groups {', '.join(found)}: keep one")
    return tables


def _columns(file: InputFile) -> list[str]:
    """Column names of a table, from the last comment or line of names before the numbers."""
    names = list[str]()
    for line in file.text.splitlines():
        words = NUMBERED.sub("", " ".join(words_of(line.strip("# \t\ufeff")))).split()
        if words and words[0].isidentifier():
            names = words
        if words and not line.lstrip().startswith("#"):
            break
    return names


def _table_on_grid(file: InputFile) -> Tables:
    """Columns of a table with one row per node, as arrays (n, m)."""
    names = _columns(file)
    if not _is_metric(dict.fromkeys(names)):
        there = f", but {', '.join(names[:8])}" if names else ""
        raise FileError(
            f"{file} is not a metric on a grid: there are no names theta, phi, q_tt, q_tp and q_pp above its "
            f"columns{there}; arrays of these names, (n,), (m,) and (n, m), may be in .npz or .h5"
        )
    if missing := [name for name in NEEDED if name not in names and name != "phi"]:
        raise FileError(f"{file} has no column {missing[0]}")
    numbers = read_text_table(file, named=True).numbers
    if numbers.shape[1] != len(names):
        raise FileError(f"{file} has {numbers.shape[1]} columns, and {len(names)} names above them")
    columns = {"phi": np.zeros(len(numbers))} | dict(zip(names, numbers.T, strict=True))
    angles = {name: np.unique(columns.pop(name), return_inverse=True) for name in ANGLES}
    (theta, i), (phi, j) = angles.values()
    cells = i.ravel() * len(phi) + j.ravel()
    if len(cells) != len(theta) * len(phi) or len(np.unique(cells)) != len(cells):
        without = "" if "phi" in names else "no column phi and "
        raise FileError(
            f"{file} has {without}{len(cells)} rows, which are not one for each pair of its {len(theta)} "
            f"angles theta and {len(phi)} angles phi"
        )
    order = np.argsort(cells)
    arrays = {name: values[order].reshape(len(theta), len(phi)) for name, values in columns.items()}
    return {"theta": theta, "phi": phi, **arrays}


def _metric(file: InputFile, tables: Tables) -> GridMetric:
    q_tp = tables["q_tp"] if "q_tp" in tables else np.zeros(tables["q_tt"].shape)
    try:
        return GridMetric(tables["theta"], tables["phi"], tables["q_tt"], q_tp, tables["q_pp"])
    except InvalidMetric as error:
        raise _with_name(error, file) from None


def _with_name(error: InvalidMetric, file: InputFile) -> InvalidMetric:
    sentence = str(error)
    return error if sentence.startswith(f"{file}: ") else InvalidMetric(f"{file}: {sentence}")


METRIC_GRID = HorizonFormat("metric on a grid", holds_metric_grid, read_grid_data)
