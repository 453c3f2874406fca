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
    triangulation, lengths = _flipped(metric.triangulation, unit.lengths, Straight, -1, unit.curvature)
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
    return _flipped(triangulation, lengths, Ptolemaic, fixed, 0.0)


def _flipped(
    triangulation: Triangulation,
    lengths: Floats,
    rule: type[Straight | Ptolemaic],
    fixed: int,
    curvature: float,
) -> tuple[Triangulation, Floats]:
    """Flip edges until ``cos(alpha) + cos(alpha') >= 0`` across every edge whose flip is possible."""
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
