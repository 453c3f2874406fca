"""Intrinsic Delaunay flips: the same metric on better triangles."""

from __future__ import annotations

import math

import numpy as np

from isoembed.metric.curvature import corner_angles
from isoembed.metric.polyhedral import PolyhedralMetric

SLACK = 1e-9  # radians: four vertices on a circle up to rounding are left as they are


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
        `metric` itself if nothing is to be flipped.

    References
    ----------
    Bobenko and Springborn, A discrete Laplace-Beltrami operator for simplicial surfaces, 2007.
    """
    triangulation = metric.triangulation
    across = np.roll(triangulation.face_edges, -1, axis=1)
    sums = np.bincount(across.ravel(), corner_angles(metric).ravel())
    violating = triangulation.edges[sums > np.pi + SLACK].tolist()
    if not violating:
        return metric

    length: dict[tuple[int, int], float] = {}
    for (a, b), l in zip(triangulation.edges.tolist(), metric.normalized.lengths.tolist(), strict=True):
        length[a, b] = length[b, a] = l
    opposite: dict[tuple[int, int], int] = {}  # the third vertex of the face that holds a half-edge
    for a, b, c in triangulation.faces.tolist():
        opposite[a, b], opposite[b, c], opposite[c, a] = c, a, b

    def angle(i: int, j: int, k: int) -> float:
        """Angle at i."""
        a, b, c = length[j, k], length[i, j], length[i, k]
        return 2 * math.atan2(
            math.sqrt(max((a - b + c) * (a + b - c), 0.0)), math.sqrt((a + b + c) * (b + c - a))
        )

    stack = violating
    while stack:
        i, j = stack.pop()
        if (i, j) not in opposite:
            continue  # flipped away meanwhile
        k, m = opposite[i, j], opposite[j, i]
        if angle(k, i, j) + angle(m, i, j) <= math.pi + SLACK or (k, m) in length:
            continue
        a, b, phi = length[i, k], length[i, m], angle(i, j, k) + angle(i, j, m)
        length[k, m] = length[m, k] = math.sqrt((a - b) ** 2 + 4 * a * b * math.sin(phi / 2) ** 2)
        del opposite[i, j], opposite[j, i], length[i, j], length[j, i]
        opposite[k, i], opposite[i, m], opposite[m, k] = m, k, i
        opposite[m, j], opposite[j, k], opposite[k, m] = k, m, j
        stack += [(k, i), (i, m), (m, j), (j, k)]

    faces = [(a, b, c) for (a, b), c in opposite.items() if a < b and a < c]
    edges = [edge for edge in length if edge[0] < edge[1]]
    return PolyhedralMetric(faces, metric.mean_length * np.array([length[edge] for edge in edges]), edges)
