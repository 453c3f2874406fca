"""A simple polygon cut into triangles: ears are clipped, then edges are flipped until they are Delaunay."""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.intrinsic.delaunay import BLOCKED, FLIPPED, LEFT, SLACK, attempts, flip_edges
from isoembed.intrinsic.flips import swap_diagonals
from isoembed.intrinsic.halfedges import preceding
from isoembed.intrinsic.plane import turn
from isoembed.kernel import kernel


class Triangles(NamedTuple):
    """The triangles of a polygon as tables over half-edges; beyond the last are twins of the outline."""

    corners: Indices
    twins: Indices


class Constrained(NamedTuple):
    """The rule of a Delaunay triangulation of a polygon with these corners (n, 2)."""

    points: Floats


def triangulated(points: Floats) -> Indices | None:
    """Triangles of the constrained Delaunay triangulation of a polygon.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        The corners of a simple polygon, counterclockwise, of the size of 1 at most; some may be in line.

    Returns
    -------
    ndarray of int64, shape (n - 2, 3), or None
        Counterclockwise.  None if the polygon is so thin that its triangles are lost in rounding.

    References
    ----------
    Meisters, Polygons have ears, American Mathematical Monthly 82 (1975).
    """
    triangles = np.empty((len(points) - 2, 3), dtype=np.int64)
    if not _clip(points, triangles):
        return None
    twins = twins_inside(triangles)
    outline = np.flatnonzero(twins < 0)
    twins[outline] = twins.size + np.arange(outline.size)
    mesh = Triangles(triangles.ravel(), np.concatenate([twins, outline]))
    flip_edges(np.arange(mesh.corners.size), mesh, Constrained(points))
    return triangles


def twins_inside(triangles: Indices) -> Indices:
    """The half-edge on the other side of each, (3F,) for triangles (F, 3); -1 on the outline."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    low, high = ends.min(axis=1), ends.max(axis=1)
    order = np.lexsort([high, low])
    first, second = order[:-1], order[1:]
    same = (low[first] == low[second]) & (high[first] == high[second])
    twins = np.full(len(ends), -1)
    twins[first[same]], twins[second[same]] = second[same], first[same]
    return twins


@kernel
def _clip(points: Floats, triangles: Indices) -> bool:
    n = len(points)
    after, before = np.arange(1, n + 1) % n, np.arange(-1, n - 1) % n
    blunt = np.empty(n, dtype=np.bool_)  # corners of pi or more: only these can lie in an ear
    for v in range(n):
        blunt[v] = turn(points[before[v]], points[v], points[after[v]]) <= 0
    suspects = np.flatnonzero(blunt)
    made, v, refused = 0, 0, 0
    while made < n - 3:
        if refused > n - made:
            return False
        a, b = before[v], after[v]
        if blunt[v] or not _empty(a, v, b, points, suspects, blunt):
            v = b
            refused += 1
            continue
        triangles[made] = a, v, b
        made += 1
        refused = 0
        after[a], before[b] = b, a
        for w in (a, b):  # corners only become smaller
            blunt[w] = blunt[w] and turn(points[before[w]], points[w], points[after[w]]) <= 0
        v = after[b]  # not b: its ears in a row would be a fan
    a, b = before[v], after[v]
    triangles[made] = a, v, b
    return turn(points[a], points[v], points[b]) > 0


@kernel
def _empty(a: int, v: int, b: int, points: Floats, suspects: Indices, blunt: Mask) -> bool:
    """Whether no other corner lies in the triangle or on its rim."""
    p, q, r = points[a], points[v], points[b]
    for w in suspects:
        if not blunt[w] or w in (a, b):
            continue
        s = points[w]
        if turn(p, q, s) >= 0 and turn(q, r, s) >= 0 and turn(r, p, s) >= 0:
            return False
    return True


@kernel
def _cotangent(points: Floats, i: int, j: int, k: int) -> float:
    """Of the angle at k."""
    x, y = points[i, 0] - points[k, 0], points[i, 1] - points[k, 1]
    u, v = points[j, 0] - points[k, 0], points[j, 1] - points[k, 1]
    return (x * u + y * v) / (x * v - y * u)


@attempts(Constrained)
def _attempt(h: int, mesh: Triangles, rule: Constrained) -> int:
    """Flip an edge across which the angles sum to more than pi: the sum of their cotangents is negative."""
    corners, points, t = mesh.corners, rule.points, mesh.twins[h]
    if t >= corners.size:
        return LEFT
    i, j, k, m = corners[h], corners[t], corners[preceding(h)], corners[preceding(t)]
    here, there = _cotangent(points, i, j, k), _cotangent(points, j, i, m)
    if here + there >= -SLACK * (abs(here) + abs(there)):
        return LEFT
    if turn(points[m], points[j], points[k]) <= 0 or turn(points[k], points[i], points[m]) <= 0:
        return BLOCKED
    swap_diagonals(h, corners, mesh.twins)
    return FLIPPED
