"""Choice of three vertices whose radii are held fixed, against translations of the apex."""

import numpy as np
from scipy.linalg import qr

from isoembed.alexandrov.ambient import ambient_lengths
from isoembed.alexandrov.loops import built
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Indices
from isoembed.linalg import Dissection


def independent_directions(p: Polytope, directions: Floats) -> Indices:
    """Pivots of a QR decomposition of the directions from the apex to the vertices, shape (3,).

    Three that are chosen by the angles between them may be in one plane with the apex: 68 + 146 + 146 degrees
    are a full turn.
    """
    # All are of length 1: the farthest is the first, not one that rounding or the numbering picks.
    # The farthest of vertices alike has the longest direction.
    longer = directions * (1 + 1e-3 * p.radii / p.radii.max())[:, None]
    _, pivots = qr(longer.T, mode="r", pivoting=True, check_finite=False)
    return np.sort(pivots[:3]).astype(np.int64)


def rough_directions(p: Polytope, dissection: Dissection) -> Floats:
    """Unit vectors from the apex, shape (V, 3): no more than a sketch.

    Pyramid is built on pyramid where errors do not grow too much from one to the next.  Elsewhere the
    vertices are where they were put when the triangles were dissected, by the number of edges between them,
    which says nothing about bodies with vertices of many edges.
    """
    tables = p.tables
    i, j = tables.ends
    lengths, radii = ambient_lengths(p.space, tables.lengths, p.radii[i], p.radii[j]), p.space.sn(p.radii)
    directions = built(tables.corners, tables.twins, lengths, radii)
    if radii.size <= 1000 or _closes(radii[:, None] * directions, i, j, lengths):
        return directions
    places = np.empty_like(dissection.position)
    places[dissection.labels] = dissection.position - dissection.position.mean(axis=0)
    sizes = np.linalg.norm(places, axis=1)[:, None]
    return places / np.where(sizes > 0, sizes, 1.0)  # zero for a vertex at the mean, which is then no pin


def _closes(points: Floats, i: Indices, j: Indices, lengths: Floats) -> bool:
    """Whether most edges that the pyramids were not built along have nearly their lengths, too."""
    missed = np.abs(np.linalg.norm(points[i] - points[j], axis=1) - lengths)
    return bool(np.quantile(missed / lengths, 0.9) < 0.01)
