"""Flat polygons that triangles form between edges that are kept, laid out in a `chart`.

Lengths alone do not say how a triangle lies that is a million times longer than high: rounding hides its
height.  Every corner of a triangle has coordinates here, which no flip changes.
"""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask, Points
from isoembed.intrinsic.chart import coordinate, toward
from isoembed.intrinsic.halfedges import HalfEdges, corner_angle, following, preceding, third_corner
from isoembed.intrinsic.trigonometry import argument
from isoembed.kernel import kernel


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


@kernel
def lay_out(mesh: HalfEdges, kept: Mask) -> Polygons:
    """Unfold the triangles between kept edges; where these bound no convex polygons, each triangle is one.

    Parameters
    ----------
    mesh : HalfEdges
    kept : ndarray of bool, shape (3F,)
        The half-edges of both sides of the edges that are kept.
    """
    fixed = kept.copy()
    z, cells = _unfolded(mesh, fixed)
    convex = _are_convex(cells, mesh, fixed)
    if not convex.all():
        for h in range(fixed.size):
            if not convex[cells[h // 3]]:
                fixed[h] = True
        z, cells = _unfolded(mesh, fixed)
    return Polygons(mesh.corners, mesh.twins, z, fixed, cells, mesh.curvature)


@kernel
def _unfolded(mesh: HalfEdges, fixed: Mask) -> tuple[Points, Indices]:
    """Place the corners (3F,), from face to face but for fixed edges, and number the parts (F,)."""
    twins, lengths = mesh.twins, mesh.lengths
    n = twins.size // 3
    z, cells = np.zeros(3 * n, dtype=np.complex128), np.full(n, -1)
    stack = np.empty(n, dtype=np.int64)
    number = 0
    for first in range(n):
        if cells[first] >= 0:
            continue
        h = 3 * first
        z[h + 1] = coordinate(lengths[h], mesh.curvature)
        z[h + 2] = third_corner(h, z[h], z[h + 1], mesh)
        cells[first] = number
        stack[0], top = first, 1
        while top > 0:
            top -= 1
            f = stack[top]
            for h in range(3 * f, 3 * f + 3):
                t = twins[h]
                if fixed[h] or cells[t // 3] >= 0:
                    continue
                z[following(t)], z[t] = z[h], z[following(h)]
                z[preceding(t)] = third_corner(t, z[t], z[h], mesh)
                cells[t // 3] = number
                stack[top] = t // 3
                top += 1
        number += 1
    return z, cells


@kernel
def _are_convex(cells: Indices, mesh: HalfEdges, fixed: Mask) -> Mask:
    """Which cells are convex polygons, by number.

    A cell of n faces that hang together at n - 1 edges has no vertex inside and no hole; and if it has no
    reflex corner either, it does not overlap itself.
    """
    n = int(cells.max()) + 1
    inner = np.zeros(n, dtype=np.int64)
    size = np.zeros(n, dtype=np.int64)
    convex = np.ones(n, dtype=np.bool_)
    for h in range(fixed.size):
        c = cells[h // 3]
        if h % 3 == 0:
            size[c] += 1
        if not fixed[h]:
            inner[c] += 1
        else:
            # The corner from this side counterclockwise to the one before it.
            angle = 0.0
            e = h
            for _ in range(fixed.size):
                angle += corner_angle(e, mesh)
                if fixed[preceding(e)]:
                    break
                e = mesh.twins[preceding(e)]
            if angle > np.pi + 1e-9:  # radians of rounding
                convex[c] = False
    return convex & (inner == 2 * (size - 1))


@kernel
def first_sides(twins: Indices, fixed: Mask) -> Indices:
    """The side of the polygon that comes first counterclockwise at each corner of each face, shape (3F,)."""
    first = np.empty(twins.size, dtype=np.int64)
    for h in range(twins.size):
        if fixed[h]:
            e = h
            while True:
                first[e] = h
                into = preceding(e)
                if fixed[into]:
                    break
                e = twins[into]
    return first


@kernel
def angle_around(h: int, polygons: Polygons) -> float:
    """Sum of the angles at the vertex that a half-edge leaves."""
    z, curvature, start = polygons.z, polygons.curvature, h
    total = 0.0
    while True:
        ahead = toward(z[h], z[following(h)], curvature)
        total += argument(toward(z[h], z[preceding(h)], curvature) * ahead.conjugate())
        h = polygons.twins[preceding(h)]
        if h == start:
            return total


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
