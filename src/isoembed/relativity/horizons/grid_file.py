"""Metrics on theta-phi grids from files."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from isoembed.errors import InvalidMetric
from isoembed.io import npz
from isoembed.io.files import FileError, check_ending, check_input, ending
from isoembed.io.hdf5 import HDF5_ENDINGS, groups_in, hdf5_file, numbers_in
from isoembed.smooth.grid_metric import GridMetric

NEEDED = ("theta", "phi", "q_tt", "q_pp")


def read_metric_grid(path: str | os.PathLike[str]) -> GridMetric:
    """Read a metric on a grid in theta and phi.

    Parameters
    ----------
    path : path
        ``.npz``, or ``.h5`` or ``.hdf5`` with everything at the top or in one group.  It holds ``theta``
        (n,), ``phi`` (m,), and ``q_tt``, ``q_tp``, ``q_pp`` (n, m) as `GridMetric` takes them; ``q_tp`` may
        be left out where it is 0.

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
    path = Path(path)
    check_ending(path, (".npz", *HDF5_ENDINGS))
    check_input(path)
    return metric_of(npz.read(path) if ending(path) == ".npz" else _hdf5_tables(path), str(path))


def holds_metric_grid(path: str | os.PathLike[str]) -> bool:
    """Whether a file is of a kind that a metric on a grid comes in, and not a metric on triangles.

    Raises
    ------
    FileError
        The file cannot be read.
    """
    if ending(path) in HDF5_ENDINGS:
        return True
    if ending(path) != ".npz":
        return False
    check_input(Path(path))
    return holds_metric(npz.read(Path(path)))


def holds_metric(tables: Mapping[str, np.ndarray]) -> bool:
    """Whether some of these arrays are components of a metric."""
    return "q_tt" in tables or "q_pp" in tables


def metric_of(tables: Mapping[str, np.ndarray], source: str) -> GridMetric:
    """The metric of named arrays; see `read_metric_grid`."""
    missing = [name for name in NEEDED if name not in tables]
    if missing:
        there = ", ".join(tables) or "nothing"
        raise FileError(f"{source} holds {there}: {' and '.join(missing)} missing from a metric on a grid")
    q_tp = tables["q_tp"] if "q_tp" in tables else np.zeros(tables["q_tt"].shape)
    try:
        return GridMetric(tables["theta"], tables["phi"], tables["q_tt"], q_tp, tables["q_pp"])
    except InvalidMetric as error:
        raise InvalidMetric(f"{source}: {error}") from None


def _hdf5_tables(path: Path) -> Mapping[str, np.ndarray]:
    with hdf5_file(path) as file:
        found = {
            name: tables
            for name, group in groups_in(file).items()
            if holds_metric(tables := numbers_in(group))
        }
        if len(found) > 1:
            raise FileError(f"{path} holds {len(found)} metrics, in the groups {', '.join(found)}: leave one")
        return next(iter(found.values())) if found else numbers_in(file)
