"""Subdivision of glued triangles to a simplicial complex with the same metric."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Space
from isoembed.space.trigonometry import apex


def simplicial(faces: Indices, twins: Indices, face_lengths: Floats, space: Space) -> PolyhedralMetric:
    """Subdivide the triangles of a gluing where it is not a simplicial complex.

    After loops are cut into three and multiple edges into two, no two edges have the same ends.  A face with
    a cut side is then a polygon, and is filled with triangles around a new vertex; if it meets a vertex at
    two corners, a ring of new vertices is inserted in between.  If the surface consists of two faces with the
    same corners, one of them also gets a new vertex.

    Parameters
    ----------
    faces : ndarray of int, shape (F, 3)
    twins : ndarray of int, shape (3F,)
        Half-edges on a boundary are their own twins.
    face_lengths : ndarray, shape (F, 3)
        Lengths of order 1.
    space : Space
        Space with the curvature of the triangles.

    Returns
    -------
    PolyhedralMetric
        Metric with the old vertices first, in order.

    Raises
    ------
    InvalidMetric
        A triangle is so thin that rounding breaks one of its parts.
    """
    pieces = _pieces(faces, twins)
    whole = np.asarray((pieces.reshape(-1, 3) == 1).all(axis=1))
    if len(faces) == 2 and whole.all() and (twins // 3 != np.repeat([0, 1], 3)).all():
        whole[0] = False
    triangles = [faces[whole]]
    edges = [np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)[whole].reshape(-1, 2)]
    lengths = [face_lengths[whole].ravel()]

    between, count = _cuts(twins, pieces, int(faces.max()) + 1)
    for f in np.flatnonzero(~whole).tolist():
        outline, points, steps = _outline(faces[f], face_lengths[f], between[3 * f : 3 * f + 3], space)
        center = _middle(points, space)
        edges.append(_sides(outline))
        lengths.append(steps)
        if len(np.unique(outline)) < len(outline):
            ring, inner = np.arange(count, count + len(outline)), _halfway(points, center, space)
            count += len(ring)
            after, outer_after = np.roll(ring, -1), np.roll(outline, -1)
            triangles += [
                np.column_stack([outline, outer_after, ring]),
                np.column_stack([outer_after, after, ring]),
            ]
            edges += [_sides(ring), np.column_stack([outline, ring]), np.column_stack([outer_after, ring])]
            lengths += [
                _distances(inner, np.roll(inner, -1, axis=0), space),
                _distances(points, inner, space),
                _distances(np.roll(points, -1, axis=0), inner, space),
            ]
            outline, points = ring, inner
        hub = np.full(len(outline), count)
        count += 1
        triangles.append(np.column_stack([_sides(outline), hub]))
        edges.append(np.column_stack([outline, hub]))
        lengths.append(_distances(points, center, space))
    tables = (np.concatenate(some) for some in (triangles, lengths, edges))
    return PolyhedralMetric(*tables, curvature=space.curvature)


def _pieces(faces: Indices, twins: Indices) -> Indices:
    """Number of pieces into which each half-edge is cut, shape (3F,)."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    h = np.flatnonzero(np.arange(twins.size) <= twins)
    low, high = np.minimum(start[h], end[h]), np.maximum(start[h], end[h])
    _, first = np.unique(low * (start.max() + 1) + high, return_index=True)
    pieces = np.full(len(h), 2)
    pieces[first] = 1
    pieces[low == high] = 3
    result = np.empty(twins.size, dtype=np.int64)
    result[h] = result[twins[h]] = pieces
    return result


def _cuts(twins: Indices, pieces: Indices, count: int) -> tuple[list[list[int]], int]:
    """Number the new vertices on every half-edge, in its direction; return them and the next free index."""
    between: list[list[int]] = [[] for _ in range(twins.size)]
    for h in np.flatnonzero((pieces > 1) & (np.arange(twins.size) <= twins)).tolist():
        new = list(range(count, count + int(pieces[h]) - 1))
        count += len(new)
        between[int(twins[h])] = new[::-1]
        between[h] = new  # last: on a boundary both are the same
    return between, count


def _outline(
    corners: Indices, lengths: Floats, between: list[list[int]], space: Space
) -> tuple[Indices, Floats, Floats]:
    """Vertices of a triangle as a polygon, their positions, and the lengths of its sides.

    Positions are (x, y, w), on the sphere, on the hyperboloid, or in the plane w = 1.
    """
    l, second, third = lengths.tolist()
    plane = np.zeros((3, 3))
    plane[1, 0], plane[2, :2] = space.sn(l), apex(l, second, third, space.curvature)
    plane[:, 2] = space.cs(np.array([0.0, l, third]))
    outline: list[int] = []
    points: list[Floats] = []
    steps: list[float] = []
    for c, new in enumerate(between):
        n = len(new) + 1
        outline += [int(corners[c]), *new]
        points += [_along(plane[c], plane[(c + 1) % 3], lengths[c], k / n, space) for k in range(n)]
        steps += [float(lengths[c]) / n] * n
    return np.array(outline), np.array(points), np.array(steps)


def _sides(ring: Indices) -> Indices:
    return np.column_stack([ring, np.roll(ring, -1)])


def _along(p: Floats, q: Floats, l: float, part: float, space: Space) -> Floats:
    """Point at the fraction `part` of the geodesic of length l from p to q."""
    if space.is_euclidean:
        return p + (q - p) * part
    before, after, whole = space.sn(np.array([(1 - part) * l, part * l, l]))
    return np.asarray((before * p + after * q) / whole)


def _middle(points: Floats, space: Space) -> Floats:
    """Point of the sphere or hyperboloid in the direction of the sum of points (n, 3)."""
    mean = points.mean(axis=0)
    if space.is_euclidean:
        return mean
    between = _distances(np.repeat(points, len(points), axis=0), np.tile(points, (len(points), 1)), space)
    return np.asarray(mean / np.sqrt(space.cs(between).mean()))


def _halfway(points: Floats, center: Floats, space: Space) -> Floats:
    """Midpoints between points (n, 3) and a center."""
    return np.asarray((points + center) / 2 / space.cs(_distances(points, center, space) / 2)[:, None])


def _distances(a: Floats, b: Floats, space: Space) -> Floats:
    d = a - b
    if space.is_euclidean:
        return np.asarray(np.hypot(*d[:, :2].T))
    # Chords by stereographic projection, without cancellation far from the origin of the hyperbolic plane.
    here, there = 1 + a[:, 2:], 1 + b[..., 2:]
    moved = there * d[:, :2] - b[..., :2] * d[:, 2:]
    return space.arc(np.hypot(*(moved / np.sqrt(here * there)).T))
