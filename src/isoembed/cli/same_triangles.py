"""Reading of a metric on the triangles of a surface, with a check."""

from pathlib import Path

import numpy as np

from isoembed.arrays import Indices
from isoembed.cli.console import UsageError
from isoembed.embedding.embedding import Embedding
from isoembed.io import read_metric
from isoembed.metric.polyhedral import PolyhedralMetric


def metric_of(
    surface: Embedding, named: Path, path: Path, merge: float | None, why: str, *, any_surface: bool = True
) -> PolyhedralMetric:
    """Read a metric on the triangles of a surface from another file, with the curvature of its space.

    Parameters
    ----------
    surface : Embedding
    named, path : Path
        Files of the surface and of the metric.
    merge : float, optional
    why : str
        Operation that requires the same triangles, for messages.
    any_surface : bool

    Raises
    ------
    FileError, InvalidMetric, UsageError
    """
    space = None if surface.space.is_euclidean else surface.space
    metric = read_metric(path, merge=merge, space=space, any_surface=any_surface)
    check_same_triangles(metric, surface.metric, path, named, why)
    return metric


def check_same_triangles(
    metric: PolyhedralMetric, own: PolyhedralMetric, path: Path, surface: Path, why: str
) -> None:
    """Raise UsageError if a metric and a surface differ in triangles or curvature of space.

    Parameters
    ----------
    metric, own : PolyhedralMetric
        Metrics of the files `path` and `surface`.
    path, surface : Path
    why : str
        Operation that requires the same triangles, for messages.
    """
    if own.space.curvature != metric.space.curvature:
        raise UsageError(
            f"{surface} is in a space of curvature {own.space.curvature:g}, the triangles of "
            f"{path} have the curvature {metric.space.curvature:g}"
        )
    count, found = metric.triangulation.n_vertices, own.triangulation.n_vertices
    if found != count:
        raise UsageError(
            f"{surface} has {found} vertices, {path} has {count}: {why} the same triangles, with the same "
            "numbers of vertices"
        )
    first, second = (_keys(faces, count) for faces in (metric.faces, own.faces))
    for keys, others, faces, where, elsewhere in (
        (first, second, metric.faces, path, surface),
        (second, first, own.faces, surface, path),
    ):
        lacking = ~np.isin(keys, others)
        if lacking.any():
            f = int(np.argmax(lacking))
            raise UsageError(
                f"face {f} {faces[f].tolist()} of {where} is not in {elsewhere}: {why} the same triangles, "
                "with the same numbers of vertices"
            )


def _keys(faces: Indices, vertices: int) -> Indices:
    """Integer key of each face, independent of the order of its corners."""
    a, b, c = np.sort(faces, axis=1).T
    return np.asarray((a * vertices + b) * vertices + c)
