"""Check that two files have the same triangulation."""

from pathlib import Path

import numpy as np

from isoembed.arrays import Indices
from isoembed.cli.screen import UsageError
from isoembed.metric.polyhedral import PolyhedralMetric


def check_same_triangles(
    metric: PolyhedralMetric, own: PolyhedralMetric, path: Path, surface: Path, why: str
) -> None:
    """Refuse a metric and a surface of other triangles, or of another curvature of space.

    Parameters
    ----------
    metric, own : PolyhedralMetric
        That of `path`, and that of the file `surface`.
    path, surface : Path
    why : str
        What needs the same triangles.

    Raises
    ------
    UsageError
    """
    if own.space.curvature != metric.space.curvature:
        raise UsageError(
            f"{surface} is in a space of curvature {own.space.curvature:g}, the triangles of "
            f"{path} have the curvature {metric.space.curvature:g}"
        )
    count, found = metric.triangulation.n_vertices, own.triangulation.n_vertices
    if found != count:
        raise UsageError(f"{surface} has {found} vertices, {path} has {count}")
    other = ~np.isin(_keys(metric.faces, count), _keys(own.faces, count))
    if other.any():
        f = int(np.argmax(other))
        raise UsageError(
            f"face {f} {metric.faces[f].tolist()} of {path} is not in {surface}: {why} the same triangles, "
            "with the same numbers of vertices"
        )


def _keys(faces: Indices, vertices: int) -> Indices:
    """A number for the corners of each face, in whatever order."""
    a, b, c = np.sort(faces, axis=1).T
    return np.asarray((a * vertices + b) * vertices + c)
