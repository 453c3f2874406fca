# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled Euclidean and Ptolemaic flips in a triangulation without loops or multiple edges."""

from __future__ import annotations

import cython
from cython.cimports.isoembed.c_types import Int, Real
from cython.cimports.isoembed.intrinsic.loops import (
    Mesh,
    Rule,
    edges_between,
    flip,
    following,
    preceding,
    swap_diagonals,
)
from cython.cimports.isoembed.space.trigonometry import chord

THINNEST = cython.declare(
    cython.double, 1e-15
)  # height over longest side: below, triangles degenerate by rounding
BLOCKED = cython.declare(cython.longlong, -1)  # outcomes of a rule, as in `loops`
LEFT = cython.declare(cython.longlong, 0)
FLIPPED = cython.declare(cython.longlong, 1)


@cython.cclass
class Straight(Rule):
    """Delaunay rule with ordinary flips: the new edge is the diagonal of the two unfolded triangles.

    The star of the vertex ``fixed`` is left unchanged, and no multiple edges are created.
    """

    mesh: Mesh
    fixed: cython.longlong

    def __init__(self, mesh: Mesh, fixed):
        self.mesh, self.twins, self.fixed = mesh, mesh.twins, fixed

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        if not _is_demanded(h, self.mesh, self.fixed):
            return LEFT
        return FLIPPED if flip(h, self.mesh, THINNEST) else BLOCKED


@cython.cclass
class Ptolemaic(Rule):
    """Delaunay rule with Ptolemaic flips: the new edge is the diagonal of an inscribed quadrilateral.

    The star of the vertex ``fixed`` is left unchanged, and no multiple edges are created.
    """

    mesh: Mesh
    fixed: cython.longlong

    def __init__(self, mesh: Mesh, fixed):
        self.mesh, self.twins, self.fixed = mesh, mesh.twins, fixed

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        mesh = self.mesh
        if not _is_demanded(h, mesh, self.fixed):
            return LEFT
        t, lengths = mesh.twins[h], mesh.lengths
        jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
        diagonal = (lengths[ki] * lengths[mj] + lengths[jk] * lengths[im]) / lengths[h]
        lengths[t], lengths[h] = lengths[jk], lengths[im]
        lengths[jk] = lengths[im] = diagonal
        swap_diagonals(h, mesh.corners, mesh.twins)
        return FLIPPED


@cython.cfunc
@cython.exceptval(check=False)
def _is_demanded(h: Int, mesh: Mesh, fixed: Int) -> cython.bint:
    """Whether a flip is required that leaves the star of a vertex unchanged and creates no multiple edge."""
    corners, t = mesh.corners, mesh.twins[h]
    # tolerance of the cosines: four concyclic vertices up to rounding
    if _cosine(h, mesh) + _cosine(t, mesh) >= -1e-9:
        return False
    k, m = preceding(h), corners[preceding(t)]
    if fixed in (corners[h], corners[t], corners[k], m):
        return False
    return edges_between(k, m, corners, mesh.twins) == 0


@cython.cfunc
@cython.exceptval(check=False)
def _cosine(h: Int, mesh: Mesh) -> Real:
    """Twice the cosine of the angle opposite a half-edge, even if the triangle inequality is violated.

    It is that of the triangle of chords: divided by ``cs(l / 2)``, common to both sides of an edge, it is the
    sine of half the excess of the other two angles over the opposite one.
    """
    l = chord(mesh.lengths[h], mesh.curvature)
    a = chord(mesh.lengths[following(h)], mesh.curvature)
    b = chord(mesh.lengths[preceding(h)], mesh.curvature)
    return b / a + a / b - l * l / (b * a)
