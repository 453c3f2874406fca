"""Three vertices in independent directions from the apex of a polytope: their radii fix where the apex is."""

import numpy as np
from scipy.linalg import qr

from isoembed.alexandrov.ambient import ambient_lengths
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.halfedges import following, preceding
from isoembed.kernel import kernel
from isoembed.linalg import Dissection
from isoembed.space.trigonometry import twice_area


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

    Pyramid is built on pyramid as long as errors do not grow too much from one to the next.  Beyond, the
    vertices are where they were put when the triangles were dissected.
    """
    tables = p.tables
    if p.radii.size <= 1000:  # vertices of bodies that are built pyramid by pyramid for their directions
        i, j = tables.ends
        lengths = ambient_lengths(p.space, tables.lengths, p.radii[i], p.radii[j])
        return _built(tables.corners, tables.twins, lengths, p.space.sn(p.radii))
    places = np.empty_like(dissection.position)
    places[dissection.labels] = dissection.position - dissection.position.mean(axis=0)
    sizes = np.linalg.norm(places, axis=1)[:, None]
    return places / np.where(sizes > 0, sizes, 1.0)  # zero for a vertex at the mean, which is then no pin


@kernel
def _built(corners: Indices, twins: Indices, lengths: Floats, r: Floats) -> Floats:
    """Unit vectors from the apex, shape (V, 3), pyramid built on pyramid, breadth first."""
    x = np.zeros((r.size, 3))
    placed = np.zeros(r.size, dtype=np.bool_)
    seen = np.zeros(corners.size // 3, dtype=np.bool_)
    queue = np.empty(corners.size // 3, dtype=np.int64)
    foot = _foot(0, corners, twins, lengths, r)
    side = np.sqrt(max(r[corners[0]] * r[corners[0]] - foot * foot, 0.0))
    x[corners[0]] = np.array([-foot, 0.0, side])
    x[corners[twins[0]]] = np.array([lengths[0] - foot, 0.0, side])
    placed[corners[0]] = placed[corners[twins[0]]] = True
    queue[0], seen[0], first, last = 0, True, 0, 1
    while first < last:
        h = queue[first]
        first += 1
        k = corners[preceding(h)]
        if not placed[k]:
            x[k] = _across(h, x, corners, twins, lengths, r)
            placed[k] = True
        for e in (following(h), preceding(h), h):
            t = twins[e]
            if not seen[t // 3]:
                seen[t // 3] = True
                queue[last] = t
                last += 1
    for v in range(r.size):
        x[v] /= max(np.sqrt((x[v] * x[v]).sum()), 1e-300)
    return x


@kernel
def _foot(h: int, corners: Indices, twins: Indices, lengths: Floats, r: Floats) -> float:
    """Distance along half-edge i -> j of the point nearest to the apex."""
    a, b = r[corners[h]], r[corners[twins[h]]]
    return (lengths[h] + (a - b) * (a + b) / lengths[h]) / 2


@kernel
def _across(h: int, x: Floats, corners: Indices, twins: Indices, lengths: Floats, r: Floats) -> Floats:
    """The third corner of the face of a half-edge whose ends are placed, in a frame of the edge."""
    i, j, k = corners[h], corners[following(h)], corners[preceding(h)]
    l, b, c = lengths[h], lengths[following(h)], lengths[preceding(h)]
    along = (l + (c - b) * (c + b) / l) / 2  # of the third corner
    height = twice_area(l, b, c) / l
    e = x[j] - x[i]
    e /= max(np.sqrt((e * e).sum()), 1e-300)
    foot = _foot(h, corners, twins, lengths, r)
    w = x[i] + foot * e  # from the apex to the edge
    w -= (w * e).sum() * e
    distance = max(np.sqrt((w * w).sum()), 1e-300)
    w /= distance
    # Where the apex is in the plane of the triangle, left of the edge: |x_k|^2 = r_k^2.
    reach = (along - foot) * (along - foot) + height * height + distance * distance - r[k] * r[k]
    sine = max(-1.0, min(1.0, reach / (2 * distance * max(height, 1e-300))))
    left = np.array([w[1] * e[2] - w[2] * e[1], w[2] * e[0] - w[0] * e[2], w[0] * e[1] - w[1] * e[0]])
    return x[i] + along * e + height * (np.sqrt(1 - sine * sine) * left - sine * w)
