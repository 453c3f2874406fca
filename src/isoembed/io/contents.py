"""`isoembed.read`: the net, the surface or the metric in a file, whichever it holds."""

import os

from isoembed.embedding.embedding import Embedding
from isoembed.gluing import Net
from isoembed.io.metric import metric_of, read_tables
from isoembed.io.net import holds_net, read_net
from isoembed.io.surface import surface_of
from isoembed.metric.polyhedral import PolyhedralMetric


def read(path: str | os.PathLike[str], *, merge: float | None = None) -> Embedding | PolyhedralMetric | Net:
    """Read what a file holds.

    Parameters
    ----------
    path : path
        Of any format that is read: see `isoembed.io.read_metric` and `isoembed.io.read_net`.
    merge : float, optional
        Of a mesh, as of `isoembed.io.read_metric`.

    Returns
    -------
    Embedding, PolyhedralMetric or Net
        Of a file with vertices the surface, as `isoembed.io.read_surface` reads it; of one with lengths alone
        the metric; of polygons that are glued the net.

    Raises
    ------
    FileError
        The file cannot be read, or its ending is not known.
    InvalidMetric, InvalidParameter
        It holds none of these.

    Warns
    -----
    MeshNote
        Vertices or faces are merged or left out, or polygons are not planar.
    """
    if holds_net(path):
        return read_net(path)
    tables = read_tables(path, merge)
    return surface_of(tables, str(path)) if "vertices" in tables else metric_of(tables)
