"""Flat polygons bounded by fixed edges of an intrinsic triangulation, laid out in a `chart`.

Lengths alone do not say how a triangle lies that is a million times longer than high: rounding hides its
height.  Every corner of a triangle has coordinates here, which no flip changes.
"""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask, Points
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.polygon_loops import Layout, are_convex, unfolded


class Polygons(NamedTuple):
    """Triangles laid out in polygons, each in a frame of its own.

    Attributes
    ----------
    corners, twins : ndarray of int64, shape (3F,)
        As of `HalfEdges`.
    z : ndarray of complex128, shape (3F,)
        Where the corners lie, continuous in each polygon: in a `chart`.
    fixed : ndarray of bool, shape (3F,)
        The half-edges between polygons.
    cells : ndarray of int64, shape (F,)
        To which polygon a face belongs.
    curvature : float
        That of the triangles.
    """

    corners: Indices
    twins: Indices
    z: Points
    fixed: Mask
    cells: Indices
    curvature: float = 0.0

    @property
    def views(self) -> Layout:
        """The tables as `polygon_loops` take them; what these change is changed here."""
        return Layout(self)


def lay_out(mesh: HalfEdges, kept: Mask) -> Polygons:
    """Unfold the triangles between kept edges; where these bound no convex polygons, each triangle is one.

    Parameters
    ----------
    mesh : HalfEdges
    kept : ndarray of bool, shape (3F,)
        The half-edges of both sides of the edges that are kept.
    """
    fixed, views = kept.copy(), mesh.views
    z, cells = unfolded(views, fixed)
    convex = are_convex(cells, views, fixed)
    if not convex.all():
        fixed |= ~np.repeat(convex[cells], 3)
        z, cells = unfolded(views, fixed)
    return Polygons(mesh.corners, mesh.twins, z, fixed, cells, mesh.curvature)


def loosened(lengths: Floats, twins: Indices) -> Floats:
    """Lengths that make triangles in floats, however thin: where they do not, short sides are rounded up.

    Parameters
    ----------
    lengths : ndarray, shape (3F,)
        Between polygons they may differ by rounding, and the shorter counts.
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
        # Where that makes the longest side of the next triangle longer, that one is broken in turn.
        tight, sides, longest = tight[broken], sides[broken], longest[broken, None]
        shorter = sides < longest
        # By what is little of the longest: of the short ones themselves it might be nothing in floats.
        # two sides get longer than the third by more than rounding
        step = np.broadcast_to(2.0**-50 / 2 * longest, shorter.shape)[shorter]
        sides = (3 * tight[:, None] + np.arange(3))[shorter]
        both = np.concatenate([sides, twins[sides]])
        longer = lengths[both] + np.tile(step, 2)
        np.maximum.at(lengths, both, longer)
        tight = np.unique(both // 3)
