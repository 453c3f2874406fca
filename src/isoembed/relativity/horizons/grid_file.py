"""Reader for metrics and data on (theta, phi) grids."""

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from isoembed.errors import InvalidMetric
from isoembed.io.files import FileError, Tables, check_ending, input_ending
from isoembed.io.hdf5 import HDF5_ENDINGS, enumerated
from isoembed.io.input_file import InputFile, opened
from isoembed.io.metric import read_metric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.relativity.horizons.curvature_check import brought_curvature
from isoembed.relativity.horizons.horizon_format import HorizonFormat
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.grid_metric import GridMetric

ARRAY_ENDINGS = (".npz", *HDF5_ENDINGS)
NEEDED = ("theta", "phi", "q_tt", "q_pp")


def read_metric_grid(path: str | os.PathLike[str]) -> GridMetric:
    """Read a metric on a grid in theta and phi.

    Parameters
    ----------
    path : path
        As of `read_grid_data`; k, p and j are not looked at.

    Returns
    -------
    GridMetric

    Raises
    ------
    FileError
        The file cannot be read, or arrays are missing; the message names them.
    InvalidMetric
        What it holds is not a metric on such a grid.
    """
    check_ending(path, ARRAY_ENDINGS)
    with opened(path) as file:
        return _metric(file, _tables(file))


def read_grid_data(path: str | os.PathLike[str]) -> SurfaceData:
    """Read a metric on a grid in theta and phi, and how its surface lies in a slice, as far as it is there.

    Parameters
    ----------
    path : path
        ``.npz``, or ``.h5`` or ``.hdf5`` with everything at the top or in one group.  It holds ``theta``
        (n,), ``phi`` (m,), and ``q_tt``, ``q_tp``, ``q_pp`` (n, m) as `GridMetric` takes them; ``q_tp`` may
        be left out where it is 0.  Besides, ``k``, ``p`` (n, m), and ``j_t`` and ``j_p``, the components of
        K(., n) for theta and phi: see `SurfaceData`; and a Gaussian curvature to compare with that of the
        metric, as `CurvatureCheck` knows it.

    Returns
    -------
    SurfaceData
        With the name of the file.

    Raises
    ------
    FileError
        The file cannot be read, or arrays are missing; the message names them.
    InvalidMetric
        What it holds is not a metric on such a grid, or the grid is too coarse for the rest.
    """
    check_ending(path, ARRAY_ENDINGS)
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
    """Read a metric on triangles or on a grid, whichever a file holds: see `read_metric`, `read_grid_data`.

    Parameters
    ----------
    path : path
    merge, length_errors : optional
        Of a metric on triangles, as of `read_metric`.

    Raises
    ------
    FileError
        The file cannot be read, or its ending is not known.
    InvalidMetric
        What it holds is not a metric.
    """
    if input_ending(path) not in ARRAY_ENDINGS:
        return read_metric(path, merge=merge, length_errors=length_errors)
    with opened(path) as file:
        is_grid = file.ending != ".npz" or holds_metric_grid(file) or "theta" in file.arrays[""]
        if is_grid:
            return read_grid_data(file)
        return read_metric(file, merge=merge, length_errors=length_errors)


def holds_metric_grid(file: InputFile) -> bool:
    """Whether some of the arrays of a file are components of a metric on a grid."""
    return file.ending in ARRAY_ENDINGS and any(map(_is_metric, file.arrays.values()))


def _is_metric(tables: Tables) -> bool:
    return "q_tt" in tables or "q_pp" in tables


def _tables(file: InputFile) -> Tables:
    """The arrays of the one metric of a file."""
    found = {name: tables for name, tables in file.arrays.items() if _is_metric(tables)}
    tables = next(iter(found.values())) if found else file.arrays[""]
    if len(found) > 1:
        raise FileError(f"{file} holds {len(found)} metrics, in the groups {', '.join(found)}: leave one")
    missing = [name for name in NEEDED if name not in tables]
    if missing:
        there = enumerated(tables) if tables else file.contents
        raise FileError(f"{file} holds {there}: {' and '.join(missing)} missing from a metric on a grid")
    return tables


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
