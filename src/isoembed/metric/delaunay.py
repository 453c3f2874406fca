"""Intrinsic Delaunay flips: the same metric on better triangles."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidMetric
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SLACK = 1e-9  # of a sum of cosines: four vertices on a circle up to rounding are left as they are


def delaunay(metric: PolyhedralMetric) -> PolyhedralMetric:
    """Flip edges until the angles across every edge sum to at most pi.

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
    Bobenko and Springborn, A discrete Laplace-Beltrami operator for simplicial surfaces, 2007.
    """
    triangulation, lengths = flipped(metric.triangulation, metric.normalized.lengths, _straight)
    if triangulation is metric.triangulation:
        return metric
    try:
        return PolyhedralMetric.on(triangulation, metric.unit * lengths)
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
    return flipped(triangulation, lengths, _ptolemy, fixed)


def flipped(
    triangulation: Triangulation,
    lengths: Floats,
    diagonal: Callable[[float, float, float, float, float], float],
    fixed: int = -1,
) -> tuple[Triangulation, Floats]:
    """Flip edges until ``cos(alpha) + cos(alpha') >= 0`` across every edge whose flip is possible."""
    left, right = triangulation.edge_halfedges.T
    face_lengths = lengths[triangulation.face_edges].ravel()

    def cosine(h: Indices) -> Floats:
        """Twice the cosine across from half-edges, also of triangles that break the triangle inequality."""
        f, c = np.divmod(h, 3)
        a, b = face_lengths[3 * f + (c + 1) % 3], face_lengths[3 * f + (c + 2) % 3]
        return a / b + b / a - face_lengths[h] ** 2 / (a * b)

    stack = triangulation.edges[cosine(left) + cosine(right) < -SLACK].tolist()
    if not stack:
        return triangulation, lengths

    length: dict[tuple[int, int], float] = {}
    for (a, b), l in zip(triangulation.edges.tolist(), lengths.tolist(), strict=True):
        length[a, b] = length[b, a] = l
    opposite: dict[tuple[int, int], int] = {}  # the third vertex of the face that holds a half-edge
    for a, b, c in triangulation.faces.tolist():
        opposite[a, b], opposite[b, c], opposite[c, a] = c, a, b

    flips = 0
    while stack:
        i, j = stack.pop()
        if (i, j) not in opposite:
            continue  # flipped away meanwhile
        k, m = opposite[i, j], opposite[j, i]
        if fixed in (i, j, k, m) or (k, m) in length:
            continue
        l, ik, jk, im, jm = length[i, j], length[i, k], length[j, k], length[i, m], length[j, m]
        if ik / jk + jk / ik - l * l / (ik * jk) + im / jm + jm / im - l * l / (im * jm) >= -SLACK:
            continue
        length[k, m] = length[m, k] = diagonal(l, ik, jk, im, jm)
        del opposite[i, j], opposite[j, i], length[i, j], length[j, i]
        opposite[k, i], opposite[i, m], opposite[m, k] = m, k, i
        opposite[m, j], opposite[j, k], opposite[k, m] = k, m, j
        stack += [(k, i), (i, m), (m, j), (j, k)]
        flips += 1
    if flips == 0:
        return triangulation, lengths

    result = Triangulation([(a, b, c) for (a, b), c in opposite.items() if a < b and a < c])
    return result, np.array([length[a, b] for a, b in result.edges.tolist()])


def _straight(l: float, ik: float, jk: float, im: float, jm: float) -> float:
    """The other diagonal of two triangles unfolded into the plane."""

    def angle(a: float, b: float, c: float) -> float:
        """Between a and b, across from c."""
        return 2 * math.atan2(
            math.sqrt(max((c - a + b) * (c + a - b), 0.0)), math.sqrt(max((a + b + c) * (a + b - c), 0.0))
        )

    phi = angle(l, ik, jk) + angle(l, im, jm)
    return math.sqrt((ik - im) ** 2 + 4 * ik * im * math.sin(phi / 2) ** 2)


def _ptolemy(l: float, ik: float, jk: float, im: float, jm: float) -> float:
    """The other diagonal of a quadrilateral inscribed in a circle."""
    return (ik * jm + jk * im) / l
