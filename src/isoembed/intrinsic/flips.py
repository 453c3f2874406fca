"""The intrinsic edge flip, compiled: one diagonal of two triangles in the place of the other."""

import math
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.intrinsic.halfedges import HalfEdges, following, glue, leaving_halfedges, preceding
from isoembed.kernel import kernel
from isoembed.space.trigonometry import angle_between, apex, arc, sn


class Tracked(NamedTuple):
    """What flips are to carry along besides the half-edge structure.

    Attributes
    ----------
    kept : ndarray of bool, shape (3F,)
        The half-edges of edges that `isoembed.intrinsic.delaunay` does not flip.
    leaving : ndarray of int64, shape (V,)
        A half-edge that leaves each vertex.
    weights : ndarray, shape (V,)
        Zeros: those of a Delaunay triangulation.
    """

    kept: Mask
    leaving: Indices
    weights: Floats


@kernel
def tracked(corners: Indices, kept: Mask, n: int) -> Tracked:
    """What flips of triangles on n vertices are to carry along."""
    return Tracked(kept, leaving_halfedges(corners, n), np.zeros(n))


@kernel
def swap_diagonals(h: int, corners: Indices, twins: Indices) -> None:
    """Replace the edge of a half-edge by the other diagonal of its two triangles, which are not one.

    Of the faces ijk and jim of half-edge i -> j and its twin remain kim, with the other diagonal in the place
    that ``following(h)`` had, and mjk, with it in the place of ``following(twin)``.  Half-edge jk moves to
    the place of the twin, and im to that of h; the caller moves what else belongs to them.
    """
    t = twins[h]
    jk, im = following(h), following(t)
    corners[jk], corners[im] = corners[preceding(t)], corners[preceding(h)]
    glue(t, twins[jk], twins)  # one after the other: they may be glued to each other
    glue(h, twins[im], twins)
    glue(jk, im, twins)


@kernel
def flip(h: int, mesh: HalfEdges, thinnest: float) -> bool:
    """Flip the edge of a half-edge as `swap_diagonals`, if its triangles are a strictly convex quadrilateral.

    Returns
    -------
    bool
        False, and nothing is changed, if both sides are one face, or a new triangle would be as thin as
        stated: no higher than that fraction of its longest side.
    """
    lengths, directions, k = mesh.lengths, mesh.directions, mesh.curvature
    t = mesh.twins[h]
    if h // 3 == t // 3:
        return False
    jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
    l, length_jk, length_ki, length_im, length_mj = (
        lengths[h],
        lengths[jk],
        lengths[ki],
        lengths[im],
        lengths[mj],
    )
    if k == 0:
        x, y = apex(l, length_jk, length_ki, k)
        u, v = apex(l, length_mj, length_im, k)
        diagonal = np.hypot(x - u, y + v)
        # Twice the areas of the new triangles.
        at_i = x * v + u * y
        at_j = (l - x) * v + (l - u) * y
    else:
        diagonal, at_i, at_j = _curved_diagonal(l, length_jk, length_ki, length_im, length_mj, k)
    longest_i = max(diagonal, max(length_ki, length_im))
    longest_j = max(diagonal, max(length_mj, length_jk))
    if not (at_i > thinnest * longest_i * longest_i and at_j > thinnest * longest_j * longest_j):
        return False
    if len(directions):
        at_m, at_k = directions[mesh.twins[im]], directions[mesh.twins[jk]]  # of m -> i and k -> j
        # The angles of the better triangle tell the directions.
        if at_i * longest_j * longest_j > at_j * longest_i * longest_i:
            at_m -= angle_between(length_im, diagonal, length_ki, k)
            at_k = directions[ki] + angle_between(length_ki, diagonal, length_im, k)
        else:
            at_m = directions[mj] + angle_between(length_mj, diagonal, length_jk, k)
            at_k -= angle_between(length_jk, diagonal, length_mj, k)
        directions[t], directions[h] = directions[jk], directions[im]
        directions[jk], directions[im] = at_m, at_k
    swap_diagonals(h, mesh.corners, mesh.twins)
    lengths[t], lengths[h] = length_jk, length_im
    lengths[jk] = lengths[im] = diagonal
    return True


@kernel
def _curved_diagonal(
    l: float, jk: float, ki: float, im: float, mj: float, k: float
) -> tuple[float, float, float]:
    """The other diagonal of two triangles, and longest side times height of the new ones.

    It is the third side of a triangle by a law of cosines in which nothing cancels.
    """
    x, y = apex(l, jk, ki, k)
    u, v = apex(l, mj, im, k)
    sine, difference = math.sin((math.atan2(y, x) + math.atan2(v, u)) / 2), sn((ki - im) / 2, k)
    diagonal = arc(2 * np.sqrt(difference * difference + sn(ki, k) * sn(im, k) * sine * sine), k)
    at_i = x * v + u * y
    at_j = apex(l, ki, jk, k)[0] * v + apex(l, im, mj, k)[0] * y
    longest_i, longest_j = max(diagonal, max(ki, im)), max(diagonal, max(mj, jk))
    at_i *= longest_i / np.float64(sn(longest_i, k))
    return diagonal, at_i, at_j * longest_j / np.float64(sn(longest_j, k))


@kernel
def flip_tracked(h: int, mesh: HalfEdges, carried: Tracked, thinnest: float) -> bool:
    """Flip an edge as `flip` does, and carry along which edges are kept and which half-edges leave."""
    corners, kept, leaving = mesh.corners, carried.kept, carried.leaving
    t = mesh.twins[h]
    jk, im = following(h), following(t)
    if not flip(h, mesh, thinnest):
        return False
    kept[t], kept[h] = kept[jk], kept[im]
    kept[jk] = kept[im] = False
    leaving[corners[h]], leaving[corners[t]] = h, t
    leaving[corners[jk]], leaving[corners[im]] = jk, im
    return True
