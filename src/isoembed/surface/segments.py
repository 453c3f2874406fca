"""Line segments on a surface, such as seams."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.mesh.triangulation import frozen

if TYPE_CHECKING:
    from isoembed.intrinsic.edge_paths import EdgePaths


class Segments(NamedTuple):
    """Straight segments on a surface.

    Attributes
    ----------
    ends : ndarray, shape (n, 2, 3)
    faces : ndarray of int, shape (n, 2)
        Triangles on both sides of each: the same one twice, unless it lies along an edge.
    """

    ends: Floats
    faces: Indices

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self.ends)} pieces)"

    @classmethod
    def none(cls) -> Segments:
        """Empty set of segments."""
        return cls(frozen(np.empty((0, 2, 3))), frozen(np.empty((0, 2), dtype=np.int64)))

    @classmethod
    def along(cls, paths: EdgePaths, which: Indices, vertices: Floats) -> Segments:
        """Segments of paths between consecutive crossings of triangle edges.

        Parameters
        ----------
        paths : EdgePaths
            Paths on a triangulation without multiple edges.
        which : ndarray of int
            Indices of the paths, which must have been found.
        vertices : ndarray, shape (V, 3)
        """
        tables, points = paths.tables, paths.points(vertices)
        start, end = (some.astype(np.int64) for some in tables.ends)
        key = start * len(vertices) + end
        order = np.argsort(key)
        pieces, faces = [cls.none().ends], [cls.none().faces]
        for e in which.tolist():
            begin, stop = paths.point_offsets[e : e + 2]
            line = points[begin:stop]
            crossed = paths.halfedges[paths.offsets[e] : paths.offsets[e + 1]]
            if crossed.size:
                inside = np.append(crossed, tables.twins[crossed[-1]]) // 3
                beside = np.column_stack([inside, inside])
            else:
                a, b = paths.ends[e]
                h = order[np.searchsorted(key, a * len(vertices) + b, sorter=order)]
                beside = np.array([[h // 3, tables.twins[h] // 3]])
            pieces.append(np.stack([line[:-1], line[1:]], axis=1))
            faces.append(beside)
        return cls(frozen(np.concatenate(pieces)), frozen(np.concatenate(faces)))
