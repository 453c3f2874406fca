"""Edge lengths from vertex positions."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.triangle_checks import first_broken
from isoembed.space import Space

ROUNDING = 8 * 2.0**-52  # error of heights and of sums of sides, in largest coordinates
MARGIN = 4 * 2.0**-52  # relative: keeps the longest side below the sum of the others


def lengths_between(triangulation: Triangulation, points: Floats, space: Space) -> Floats:
    """Lengths of edges between points of size 1, (E,), rounded so that triangles with area do not degenerate.

    If the height of a triangle is 1e-8 of its longest side, the sum of the other two equals it in floats: the
    longest side is then rounded down.
    """
    t = triangulation
    if space.is_euclidean:
        lengths = straight_lengths(t.edges, points)
    else:
        lengths = space.distances(*np.moveaxis(points[t.edges], 1, 0))
    if first_broken(t.face_edges, lengths, MARGIN / 2) < 0:
        return lengths
    for _ in range(50):  # shortened sides may be short sides of other triangles
        sides = lengths[t.face_edges]
        longest = sides.argmax(axis=1)
        shortest, middle, longest_side = np.sort(sides, axis=1).T
        room = shortest - (longest_side - middle)
        f = np.flatnonzero((room < MARGIN / 2 * longest_side) & (room >= -ROUNDING))
        if not f.size:
            break
        a, b, c = (points[t.faces[f, (longest[f] + k) % 3]] for k in range(3))
        to_b, to_c, far = space.seen_from(a, b), space.seen_from(a, c), space.sn(longest_side[f])
        along = to_b / np.where(far > 0, far, 1.0)[:, None]
        heights = np.linalg.norm(to_c - (to_c * along).sum(axis=1, keepdims=True) * along, axis=1)
        f = f[heights > ROUNDING]
        np.minimum.at(lengths, t.face_edges[f, longest[f]], (middle + shortest)[f] * (1 - MARGIN))
    return lengths


def straight_lengths(edges: Indices, vertices: Floats) -> Floats:
    """Distances between the ends of the edges, (E,)."""
    sides = vertices[edges[:, 0]] - vertices[edges[:, 1]]
    return np.sqrt((sides * sides).sum(axis=1))
