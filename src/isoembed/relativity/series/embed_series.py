"""`embed_series`: horizons of a series embedded from Python, here or on an executor."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, Literal

from isoembed.errors import InvalidParameter
from isoembed.relativity.horizons.horizon import GivenHorizon
from isoembed.relativity.series.horizon_task import HorizonOptions, HorizonTask
from isoembed.relativity.series.kuibit_data import GridDataSlice
from isoembed.relativity.series.moment import Moment
from isoembed.relativity.series.shape_sources import ShapeFile
from isoembed.relativity.series.slice_files import SliceFile
from isoembed.relativity.series.source import HeldShape, HeldSlice, ShapeSource, SliceSource
from isoembed.relativity.spacetimes.checks import vector
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.runs import Result, Store, run
from isoembed.runs.result import FAILED, REFUSED
from isoembed.space import EUCLIDEAN, Space

SERIES = "horizon"
"""Default name of the series of moments."""


def embed_series(
    moments: Iterable[Moment | tuple[float | None, Any, Any]],
    *,
    vertices: int = 1000,
    wang_yau: bool = False,
    axis: Sequence[float] | None = None,
    marginal: bool | None = None,
    space: Space | Literal["hyperbolic"] = EUCLIDEAN,
    folder: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
) -> Iterator[Result]:
    """Compute embeddings and energies of many horizons, each in its own slice.

    Parameters
    ----------
    moments : iterable of Moment or of tuples
        Moments from `isoembed.relativity.moments`, or tuples (time, shape, geometry): the time, or None; a
        horizon in a form accepted by `horizon_data`, or its file; its slice, a file of one, grid data of
        kuibit by the names gxx ... kzz, or None for a horizon that needs no slice, such as one from
        `isoembed.relativity.find_horizon`.  They are consumed one by one; with an executor as
        `isoembed.runs.Workers` has capacity, or all at once.
    vertices : int
        Number of vertices of the meshes.
    wang_yau : bool
        Whether to compute the least Wang-Yau energy.
    axis, marginal
        See `horizon_data`.
    space : Space or "hyperbolic"
        See `isoembed.relativity.embed_surface`.
    folder : path, optional
        Folder for the results, one file each; existing results with the same content and options are reused.
        Slices and surfaces defined in code are identified by their data and by their values at 64 points of
        the surface to eight digits: metric, gradient, K_ij and their error.  Use another folder after changes
        that these points do not reflect.
    executor : concurrent.futures.Executor, optional
        By default everything runs in this process.  `isoembed.runs.Workers` has one process per core; objects
        sent to it must be picklable, with functions at the top level of a module.

    Yields
    ------
    Result
        One for each moment, as completed, with the ``report`` and the ``arrays`` described in
        `isoembed.relativity.HorizonTask`.  Horizons that do not embed or are invalid do not end the series.
        In groups of eight consecutive moments each embedding starts from the previous one.

    Raises
    ------
    InvalidParameter
        An option or a moment is invalid, or two moments have the same label.
    FileError
        The folder cannot be created.

    Warns
    -----
    UserWarning
        A result cannot be stored, as on a full disk, or all horizons are invalid or failed.
    """
    about = None if axis is None else vector("the axis", axis)
    options = HorizonOptions(vertices, wang_yau, about, marginal, space)
    store = None if folder is None else Store.made(Path(folder))
    return _results(_tasks(moments, options), store, executor)


def _results(
    tasks: Iterable[HorizonTask], store: Store | None, executor: Executor | None
) -> Iterator[Result]:
    first, computed = None, False
    for outcome in run(tasks, store=store, executor=executor):
        if outcome.complaint:
            warnings.warn(outcome.complaint, stacklevel=3)
        first, computed = first or outcome.result, computed or outcome.result.status not in (REFUSED, FAILED)
        yield outcome.result
    if first is not None and not computed:
        warnings.warn(
            f"all horizons are refused or failed; the first one, {first.label}, is {first.status}: "
            f"{first.message}",
            stacklevel=3,
        )


def _tasks(moments: Iterable[Any], options: HorizonOptions) -> Iterator[HorizonTask]:
    labels = set[str]()
    for position, item in enumerate(moments):
        moment = _moment(position, item)
        if moment.label in labels:
            raise InvalidParameter(
                f"moment {position} has the label of an earlier one, {moment.label}: moments must differ in "
                "series, iteration or time"
            )
        labels.add(moment.label)
        yield HorizonTask(moment, options)


def _moment(position: int, item: Any) -> Moment:
    if isinstance(item, Moment):
        return item
    if not (isinstance(item, Sequence) and not isinstance(item, str) and len(item) == 3):
        raise InvalidParameter(
            f"moment {position} is a {type(item).__name__}, not a Moment or (time, shape, geometry)"
        )
    time, shape, geometry = item
    return Moment(SERIES, time, None, _shape(position, shape), _slice(position, geometry), position)


def _shape(position: int, item: Any) -> ShapeSource:
    if isinstance(item, str | os.PathLike):
        return ShapeFile(os.fspath(item))
    if not isinstance(item, GivenHorizon):
        raise InvalidParameter(f"moment {position}: expected a horizon, not {type(item).__name__}")
    return HeldShape(item)


def _slice(position: int, item: Any) -> SliceSource | None:
    if item is None:
        return None
    if isinstance(item, str | os.PathLike):
        return SliceFile(os.fspath(item))
    if isinstance(item, Mapping):
        return GridDataSlice(item)
    if not isinstance(item, ThreeGeometry):
        raise InvalidParameter(f"moment {position}: expected a slice, not {type(item).__name__}")
    return HeldSlice(item)
