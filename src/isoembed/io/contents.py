"""`isoembed.read`: the net, surface or metric stored in a file."""

import os

from isoembed.embedding.embedding import Embedding
from isoembed.gluing import Net
from isoembed.io.metric import metric_of, read_tables
from isoembed.io.net import holds_net, read_net
from isoembed.io.surface import surface_of
from isoembed.metric.polyhedral import PolyhedralMetric


def read(path: str | os.PathLike[str], *, merge: float | None = None) -> Embedding | PolyhedralMetric | Net:
    """Read a net, a surface or a metric, whichever the file holds.

    Parameters
    ----------
    path : path
        File in any readable format: see `isoembed.io.read_metric` and `isoembed.io.read_net`.
    merge : float, optional
        Merging distance of mesh vertices; see `isoembed.io.read_metric`.

    Returns
    -------
    Embedding, PolyhedralMetric or Net
        The surface if the file has vertices (see `isoembed.io.read_surface`), the metric if it has only
        lengths, or the net if it has polygons to glue.

    Raises
    ------
    FileError
        The file cannot be read, or its ending is unknown.
    InvalidMetric, InvalidParameter
        The contents are none of these.

    Warns
    -----
    MeshNote
        Vertices or faces are merged or omitted, or polygons are not planar.
    """
    if holds_net(path):
        return read_net(path)
    tables = read_tables(path, merge)
    return surface_of(tables, str(path)) if "vertices" in tables else metric_of(tables)
