"""Delaunay flips of metrics and of their conformal classes, which leave simplicial complexes."""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.delaunay import BLOCKED, FLIPPED, LEFT, THINNEST, attempts, flip_edges
from isoembed.intrinsic.flips import flip, swap_diagonals
from isoembed.intrinsic.halfedges import HalfEdges, edges_between, following, preceding
from isoembed.kernel import kernel
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Space
from isoembed.space.trigonometry import chord


def delaunay(metric: PolyhedralMetric) -> PolyhedralMetric:
    """Flip edges until the angles across every edge sum to at most pi.

    On the sphere and in the hyperbolic plane they sum to no more than the other four angles beside the edge:
    no vertex is inside the circle through the corners of a triangle next to it.
    The vertices and the distances on the surface stay; an edge is replaced by the straight line across its
    two triangles unfolded.  An edge is left alone where the new one would join vertices that are joined
    already: the result is a triangulation in which two vertices share at most one edge, and so may miss
    being Delaunay on surfaces with long thin ends.

    Parameters
    ----------
    metric : PolyhedralMetric

    Returns
    -------
    PolyhedralMetric
        `metric` itself if nothing is to be flipped, or if rounding would break a flipped triangle.

    References
    ----------
    Bobenko and Springborn, A discrete Laplace-Beltrami operator for simplicial surfaces, 2007.  Leibon,
    Characterizing the Delaunay decompositions of compact hyperbolic surfaces, Geom. Topol. 6, 2002.
    """
    unit = metric.normalized
    triangulation, lengths = _flipped(metric.triangulation, unit.lengths, Straight(-1), unit.curvature)
    if triangulation is metric.triangulation:
        return metric
    try:
        return PolyhedralMetric.on(triangulation, metric.unit * lengths, metric.space)
    except InvalidMetric:  # triangles so thin that rounding broke one
        return metric


def ideal_delaunay(triangulation: Triangulation, lengths: Floats, fixed: int) -> tuple[Triangulation, Floats]:
    """Flip edges to Delaunay by Ptolemy's relation, which commutes with conformal change.

    The lengths need not obey the triangle inequality: they stand for a decorated ideal hyperbolic
    polyhedron (Penner), and do obey it once no edge is left to flip.

    Parameters
    ----------
    triangulation : Triangulation
    lengths : ndarray, shape (E,)
        On the sphere and in the hyperbolic plane the chords, ``2 sn(l / 2)``.
    fixed : int
        A vertex whose star is left alone.

    Returns
    -------
    Triangulation, ndarray
        The arguments themselves if nothing is to be flipped.

    References
    ----------
    Gillespie, Springborn and Crane, Discrete conformal equivalence of polyhedral surfaces, ACM TOG 40 (2021).
    """
    return _flipped(triangulation, lengths, Ptolemaic(fixed), 0.0)


class Straight(NamedTuple):
    """The rule by which an edge gives way to the straight line across its two triangles unfolded."""

    fixed: int


class Ptolemaic(NamedTuple):
    """The rule by which an edge gives way to the other diagonal of a quadrilateral inscribed in a circle."""

    fixed: int


@attempts(Straight)
def _attempt_straight(h: int, mesh: HalfEdges, rule: Straight) -> int:
    if not _is_demanded(h, mesh, rule.fixed):
        return LEFT
    return FLIPPED if flip(h, mesh, THINNEST) else BLOCKED


@attempts(Ptolemaic)
def _attempt_ptolemaic(h: int, mesh: HalfEdges, rule: Ptolemaic) -> int:
    if not _is_demanded(h, mesh, rule.fixed):
        return LEFT
    t, lengths = mesh.twins[h], mesh.lengths
    jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
    diagonal = (lengths[ki] * lengths[mj] + lengths[jk] * lengths[im]) / lengths[h]
    lengths[t], lengths[h] = lengths[jk], lengths[im]
    lengths[jk] = lengths[im] = diagonal
    swap_diagonals(h, mesh.corners, mesh.twins)
    return FLIPPED


@kernel
def _is_demanded(h: int, mesh: HalfEdges, fixed: int) -> bool:
    """Whether a flip is demanded that leaves the star of a vertex alone and doubles no edge."""
    corners, t = mesh.corners, mesh.twins[h]
    # in cosines: four vertices on a circle, but for rounding
    if _cosine(h, mesh) + _cosine(t, mesh) >= -1e-9:
        return False
    k, m = preceding(h), corners[preceding(t)]
    if fixed in (corners[h], corners[t], corners[k], m):
        return False
    return edges_between(k, m, corners, mesh.twins) == 0


@kernel
def _cosine(h: int, mesh: HalfEdges) -> float:
    """Twice the cosine across from a half-edge, also of a triangle that breaks the triangle inequality.

    It is that of the triangle of chords: divided by ``cs(l / 2)``, which the two sides of an edge have in
    common, it is the sine of half the excess of the other two angles over the one across.
    """
    l = chord(mesh.lengths[h], mesh.curvature)
    a = chord(mesh.lengths[following(h)], mesh.curvature)
    b = chord(mesh.lengths[preceding(h)], mesh.curvature)
    return b / a + a / b - l * l / (b * a)


def _flipped(
    triangulation: Triangulation, lengths: Floats, rule: Straight | Ptolemaic, curvature: float
) -> tuple[Triangulation, Floats]:
    """Flip edges until ``cos(alpha) + cos(alpha') >= 0`` across every edge whose flip is possible."""
    l = Space(curvature).chord(lengths)[triangulation.face_edges]
    a, b = np.roll(l, -1, axis=1), np.roll(l, -2, axis=1)
    cosines = (b / a + a / b - l * l / (b * a)).ravel()
    wrong = np.flatnonzero(cosines + cosines[triangulation.twins] < -1e-9)
    if wrong.size == 0:  # as often: nothing needs to be compiled
        return triangulation, lengths
    face_lengths = lengths[triangulation.face_edges]
    mesh = HalfEdges.of(triangulation.faces, triangulation.twins, face_lengths, curvature)
    if flip_edges(wrong, mesh, rule)[0] == 0:
        return triangulation, lengths
    result = Triangulation(mesh.faces)
    return result, mesh.lengths[result.edge_halfedges[:, 0]]
