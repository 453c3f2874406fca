"""Flat polygons bounded by fixed edges of an intrinsic triangulation, laid out in a `chart`.

For triangles a million times longer than high, lengths alone do not determine the layout: the height is lost
to rounding.  Here every corner of a triangle has coordinates, unchanged by flips.
"""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask, Points
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.polygon_loops import Layout, are_convex, unfolded


class Polygons(NamedTuple):
    """Triangles laid out in polygons, each in its own frame.

    Attributes
    ----------
    corners, twins : ndarray of int64, shape (3F,)
        As in `HalfEdges`.
    z : ndarray of complex128, shape (3F,)
        Positions of the corners in a `chart`, consistent within each polygon.
    fixed : ndarray of bool, shape (3F,)
        Half-edges between polygons.
    cells : ndarray of int64, shape (F,)
        Polygon of each face.
    curvature : float
        Gaussian curvature of the triangles.
    """

    corners: Indices
    twins: Indices
    z: Points
    fixed: Mask
    cells: Indices
    curvature: float = 0.0

    @property
    def views(self) -> Layout:
        """Views of the tables for `polygon_loops`, which modify them in place."""
        return Layout(self)


def lay_out(mesh: HalfEdges, kept: Mask) -> Polygons:
    """Unfold the triangles between kept edges into convex polygons, or else into single triangles.

    Parameters
    ----------
    mesh : HalfEdges
    kept : ndarray of bool, shape (3F,)
        Half-edges on both sides of the kept edges.
    """
    fixed, views = kept.copy(), mesh.views
    z, cells = unfolded(views, fixed)
    convex = are_convex(cells, views, fixed)
    if not convex.all():
        fixed |= ~np.repeat(convex[cells], 3)
        z, cells = unfolded(views, fixed)
    return Polygons(mesh.corners, mesh.twins, z, fixed, cells, mesh.curvature)


def loosened(lengths: Floats, twins: Indices) -> Floats:
    """Lengths that satisfy the triangle inequality in floats; short sides of thin triangles are rounded up.

    Parameters
    ----------
    lengths : ndarray, shape (3F,)
        Lengths of the half-edges; twins between polygons may differ by rounding, and the shorter one is used.
    twins : ndarray of int, shape (3F,)
    """
    lengths = np.minimum(lengths, lengths[twins])
    tight = np.arange(lengths.size // 3)
    while True:
        sides = lengths.reshape(-1, 3)[tight]
        short, middle, longest = np.sort(sides, axis=1).T
        broken = longest - middle >= short
        if not broken.any():
            return lengths
        # If this lengthens the longest side of an adjacent triangle, that one is processed next.
        tight, sides, longest = tight[broken], sides[broken], longest[broken, None]
        shorter = sides < longest
        # The step is relative to the longest side: relative to the short ones it might vanish by rounding.
        # Then the sum of two sides exceeds the third by more than rounding.
        step = np.broadcast_to(2.0**-50 / 2 * longest, shorter.shape)[shorter]
        sides = (3 * tight[:, None] + np.arange(3))[shorter]
        both = np.concatenate([sides, twins[sides]])
        longer = lengths[both] + np.tile(step, 2)
        np.maximum.at(lengths, both, longer)
        tight = np.unique(both // 3)
