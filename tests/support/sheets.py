"""Polygons covered twice, with flat vertices on the outline and inside either sheet."""

from itertools import pairwise

import numpy as np

from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.metric.glued import GluedMetric
from scrambling import scramble


def covered_twice(outline, on_sides, inside, seed):
    """A convex polygon as a metric in random triangles: (metric, points, how many of them are corners).

    Flat vertices are put on random sides, and inside random sheets.
    """
    rng = np.random.default_rng(seed)
    n = len(outline)
    points, sides = list(outline), rng.integers(0, n, on_sides)
    around = []
    for side, (a, b) in enumerate(pairwise([*outline, outline[0]])):
        around.append(side)
        for t in np.sort(rng.uniform(0.05, 0.95, (sides == side).sum())):
            around.append(len(points))
            points.append((1 - t) * a + t * b)
    sheets = []
    for count in (inside - inside // 2, inside // 2):
        new = range(len(points), len(points) + count)
        points += list(rng.dirichlet(np.ones(n), count) @ outline)
        sheets.append(_triangulated(np.array(points), around, new, rng))
    front, back = sheets[0], [triangle[::-1] for triangle in sheets[1]]
    tables = _glued(np.array(points), front, back)
    scramble(tables, 3 * len(points), rng, 1e-2)
    metric = GluedMetric(tables.faces, tables.twins, tables.face_lengths)
    return metric, np.column_stack([points, np.zeros(len(points))]), n


def _area(points, a, b, c):
    (x, y), (u, v) = points[b] - points[a], points[c] - points[a]
    return x * v - y * u


def _triangulated(points, around, new, rng):
    """Cut off random ears, and put the new points into the triangles."""
    rest, triangles = list(around), []
    while len(rest) > 3:
        k = int(rng.integers(len(rest)))
        a, b, c = rest[k - 1], rest[k], rest[(k + 1) % len(rest)]
        left = rest[:k] + rest[k + 1 :]
        if _area(points, a, b, c) > 1e-9 and not _in_line(points, left):
            triangles.append((a, b, c))
            rest = left
    triangles.append(tuple(rest))
    for v in new:
        depths = [
            min(_area(points, *t[:2], v), _area(points, *t[1:], v), _area(points, t[2], t[0], v))
            for t in triangles
        ]
        a, b, c = triangles.pop(int(np.argmax(depths)))
        triangles += [(a, b, v), (b, c, v), (c, a, v)]
    return triangles


def _in_line(points, left):
    return max(abs(_area(points, a, b, c)) for a, b in pairwise([*left, left[0]]) for c in left) < 1e-9


def _glued(points, front, back):
    halfedges = {}
    for sheet, triangles in enumerate((front, back)):
        for a, b, c in triangles:
            for ends in ((a, b), (b, c), (c, a)):
                halfedges[(*ends, sheet)] = len(halfedges)
    twins = [halfedges.get((b, a, s), halfedges.get((b, a, 1 - s))) for a, b, s in halfedges]
    start, end, _ = np.array(list(halfedges)).T
    lengths = np.linalg.norm(points[start] - points[end], axis=1)
    return HalfEdges.of(np.array(front + back), np.array(twins), lengths.reshape(-1, 3))
