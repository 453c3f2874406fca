"""Delaunay flips of a metric and of its conformal class, within simplicial complexes."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import flip_edges
from isoembed.intrinsic.ptolemaic_loops import Ptolemaic, Straight
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Space


def delaunay(metric: PolyhedralMetric) -> PolyhedralMetric:
    """Flip edges until the two angles opposite to every edge sum to at most pi.

    On the sphere and in the hyperbolic plane, their sum is at most that of the other four angles beside the
    edge: no vertex is inside the circumcircle of an adjacent triangle.
    The vertices and the distances on the surface are unchanged; an edge is replaced by the other diagonal of
    its two unfolded triangles.  Flips that would create multiple edges are omitted: the result is a
    triangulation in which two vertices share at most one edge, and may fail to be Delaunay on surfaces with
    long thin ends.

    Parameters
    ----------
    metric : PolyhedralMetric

    Returns
    -------
    PolyhedralMetric
        `metric` itself if no flip is needed, or if rounding would break a flipped triangle.

    References
    ----------
    Bobenko and Springborn, A discrete Laplace-Beltrami operator for simplicial surfaces, 2007.  Leibon,
    Characterizing the Delaunay decompositions of compact hyperbolic surfaces, Geom. Topol. 6, 2002.
    """
    unit = metric.normalized
    triangulation, lengths = _flipped(metric.triangulation, unit.lengths, Straight, -1, unit.curvature)
    if triangulation is metric.triangulation:
        return metric
    try:
        return PolyhedralMetric.on(triangulation, metric.unit * lengths, metric.space)
    except InvalidMetric:  # triangles so thin that rounding broke one
        return metric


def ideal_delaunay(triangulation: Triangulation, lengths: Floats, fixed: int) -> tuple[Triangulation, Floats]:
    """Flip edges to Delaunay by Ptolemy's relation, which commutes with conformal change.

    The lengths may violate the triangle inequality: they represent a decorated ideal hyperbolic polyhedron
    (Penner), and satisfy the inequality when all edges are Delaunay.

    Parameters
    ----------
    triangulation : Triangulation
    lengths : ndarray, shape (E,)
        Lengths; on the sphere and in the hyperbolic plane the chords, ``2 sn(l / 2)``.
    fixed : int
        Vertex with a fixed star.

    Returns
    -------
    Triangulation, ndarray
        The arguments themselves if no flip is needed.

    References
    ----------
    Gillespie, Springborn and Crane, Discrete conformal equivalence of polyhedral surfaces, ACM TOG 40 (2021).
    """
    return _flipped(triangulation, lengths, Ptolemaic, fixed, 0.0)


def _flipped(
    triangulation: Triangulation,
    lengths: Floats,
    rule: type[Straight | Ptolemaic],
    fixed: int,
    curvature: float,
) -> tuple[Triangulation, Floats]:
    """Flip edges until ``cos(alpha) + cos(alpha') >= 0`` at every edge that can be flipped."""
    l = Space(curvature).chord(lengths)[triangulation.face_edges]
    a, b = np.roll(l, -1, axis=1), np.roll(l, -2, axis=1)
    cosines = (b / a + a / b - l * l / (b * a)).ravel()
    wrong = np.flatnonzero(cosines + cosines[triangulation.twins] < -1e-9)
    if wrong.size == 0:
        return triangulation, lengths
    face_lengths = lengths[triangulation.face_edges]
    mesh = HalfEdges.of(triangulation.faces, triangulation.twins, face_lengths, curvature)
    if flip_edges(wrong, rule(mesh.views, fixed))[0] == 0:
        return triangulation, lengths
    result = Triangulation(mesh.faces)
    return result, mesh.lengths[result.edge_halfedges[:, 0]]
