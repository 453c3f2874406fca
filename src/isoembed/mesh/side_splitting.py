"""T-junctions: detection, and splitting of edges at vertices in their interior."""

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.polygons import next_corners


def slivers(points: Floats, corners: Indices, sizes: Indices, distance: float) -> Mask:
    """Mask of triangles with a vertex within a distance of the opposite side, shape (F,)."""
    found = np.zeros(len(sizes), dtype=np.bool_)
    (which,) = np.nonzero(sizes == 3)
    triangles = corners[(np.cumsum(sizes) - sizes)[which, None] + np.arange(3)]
    for k in range(3):
        a, b, v = np.roll(triangles, k, axis=1).T
        found[which] |= _is_between(points[v], points[a], points[b], distance)[0]
    return found


def vertices_on_sides(
    points: Floats, corners: Indices, sizes: Indices, distance: float
) -> tuple[Indices, Indices, Floats]:
    """Vertices within a distance of boundary sides, and farther from the sides' endpoints.

    Parameters
    ----------
    points : ndarray, shape (V, n)
    corners : ndarray of int, shape (m,)
        Concatenated corners of the faces.
    sizes : ndarray of int, shape (F,)
    distance : float

    Returns
    -------
    places : ndarray of int, shape (k,)
        Position in `corners` of the start of each side, ascending; vertices are ordered along a side.
    vertices : ndarray of int, shape (k,)
        Vertices on the sides; they are themselves endpoints of boundary sides.
    distances : ndarray, shape (k,)
        Distances of the vertices from the sides.
    """
    after = corners[next_corners(sizes)]
    keys = np.minimum(corners, after) * len(points) + np.maximum(corners, after)
    _, number, count = np.unique(keys, return_inverse=True, return_counts=True)
    (single,) = np.nonzero(count[number] == 1)
    a, b = corners[single], after[single]
    ends = np.unique([a, b])
    if not ends.size:
        return single, ends, np.empty(0)
    from scipy.spatial import cKDTree  # slow to import, and seldom needed

    reach = np.linalg.norm(points[a] - points[b], axis=1) / 2 + distance
    near = cKDTree(points[ends]).query_ball_point((points[a] + points[b]) / 2, reach)
    side = np.repeat(np.arange(len(single)), [len(some) for some in near])
    v = ends[np.concatenate([np.asarray(some, dtype=np.int64) for some in near])]
    apart = (v != a[side]) & (v != b[side])
    side, v = side[apart], v[apart]
    between, offsets = _is_between(points[v], points[a[side]], points[b[side]], distance)
    side, v, offsets = side[between], v[between], offsets[between]
    along = np.linalg.norm(points[v] - points[a[side]], axis=1)
    order = np.lexsort([along, side])
    return single[side[order]], v[order], offsets[order]


def with_vertices_on_sides(
    corners: Indices, sizes: Indices, places: Indices, vertices: Indices
) -> tuple[Indices, Indices]:
    """Insert vertices into faces, each after the corner at its place."""
    face = np.repeat(np.arange(len(sizes)), sizes)
    more = np.bincount(face[places], minlength=len(sizes))
    return np.insert(corners, places + 1, vertices), sizes + more


def _is_between(p: Floats, a: Floats, b: Floats, distance: float) -> tuple[Mask, Floats]:
    """Whether points are within a distance of segments and farther from their ends, and their offsets."""
    along = b - a
    squares = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    t = ((p - a) * along).sum(axis=1) / squares
    offsets = np.linalg.norm(p - a - t[:, None] * along, axis=1)
    inside = (t > 0) & (t < 1)
    for end in (a, b):
        inside &= np.linalg.norm(p - end, axis=1) > distance
    return inside & (offsets <= distance), offsets
