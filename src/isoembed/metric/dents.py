"""Dents of a metric: patches that can be reflected without changing the lengths.

A plane tangent to a surface of revolution along a circle cuts off a patch; reflected in the plane, it has the
same metric and fits as smoothly as before, up to the sign of the normal curvature across the circle.  A dent
is such a patch: a cap with K > 0 and a ring with K < 0 around it.  The circle is the outer boundary of the
ring, and as its normals are parallel, the total curvature of the patch vanishes.  On surfaces without
symmetry this holds approximately.
"""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.components import connected_parts
from isoembed.metric.curvature import deficits, face_areas, negative_deficits
from isoembed.metric.polyhedral import PolyhedralMetric

MIN_PATCH = 4  # vertices: smaller patches are left to the search for nearby realizations


def dents(metric: PolyhedralMetric) -> list[Mask]:
    """Patches that are dents or reflections of dents.

    Parameters
    ----------
    metric : PolyhedralMetric

    Returns
    -------
    list of ndarray of bool, shape (V,)
        Vertices inside the rim of each patch, disjoint; sorted by decreasing total curvature of the caps.

    Raises
    ------
    InvalidMetric
        The surface has a boundary or handles.
    """
    metric.triangulation.check_sphere()
    negative = negative_deficits(metric)
    if not negative.any():
        return []
    curvature, adjacency = deficits(metric), metric.triangulation.adjacency
    area = np.bincount(metric.faces.ravel(), np.repeat(face_areas(metric), 3))
    # Gaps of an edge or two in the rings are closed: on irregular triangulations deficits are noisy.
    ring = ~_grown(adjacency, ~_grown(adjacency, negative)) | negative
    outside = connected_parts(adjacency, ~ring)
    if not outside:
        return []
    filled = np.ones(len(curvature), dtype=np.bool_)
    filled[max(outside, key=lambda part: float(area[part].sum()))] = False
    found: list[tuple[float, Mask]] = []
    for region in connected_parts(adjacency, filled):
        inside = np.zeros_like(filled)
        inside[region] = True
        caps = connected_parts(adjacency, inside & ~negative)
        totals = np.array([curvature[cap].sum() for cap in caps])
        if not area[region].sum() < 0.5 * area.sum():  # K < 0 over half the surface: no ring
            continue
        is_dent = _vanishes(curvature[region].sum(), totals.sum())
        if is_dent:
            plain = np.flatnonzero(totals > 0.3 * totals.max())  # caps with less curvature are noise
        else:  # it may be merged with another feature, such as a horn
            plain = np.flatnonzero([len(cap) >= MIN_PATCH for cap in caps])
            if not 1 < len(plain) <= 3:  # rough surfaces have more caps
                continue
        patches = [inside]
        if len(plain) > 1:
            shared = _shared(metric, inside, [caps[k] for k in plain])
            patches = [patch & (inside | ~filled) for patch in shared]
        found += [
            (float(totals[k]), patch)
            for k, patch in zip(plain, patches, strict=True)
            if is_dent or _vanishes(curvature[patch].sum(), totals[k])
        ]
    found.sort(key=lambda pair: -pair[0])
    # caps with less curvature, in radians, are noise
    return [patch for cap, patch in found if cap > 3e-3 and patch.sum() >= MIN_PATCH]


def _vanishes(total: float, caps: float) -> bool:
    """Whether the total curvature of a patch is that of a dent, given that of its caps."""
    lower, upper = np.multiply((-0.5, 0.2), caps)  # range of the total curvature relative to the caps
    return bool(lower <= total <= upper)


def _grown(adjacency: csr_array, mask: Mask) -> Mask:
    """Vertices and their neighbors."""
    return mask | (adjacency @ mask.astype(np.float64) > 0)


def _shared(metric: PolyhedralMetric, region: Mask, caps: list[Indices]) -> list[Mask]:
    """Split merged rings among their caps.

    Vertices are assigned to the nearest cap, up to the distance that minimizes the total curvature.
    """
    n, curvature = len(region), deficits(metric)
    a, b = metric.edges.T
    ends = (np.concatenate([a, b]), np.concatenate([b, a]))
    lengths = csr_array((np.tile(metric.lengths, 2), ends), shape=(n, n))
    distances = np.array([_distances(lengths, cap) for cap in caps])
    nearest, patches = np.argmin(distances, axis=0), []
    for k, cap in enumerate(caps):
        near = np.flatnonzero((nearest == k) & (distances[k] <= distances[k, region & (nearest == k)].max()))
        near = near[np.argsort(distances[k, near], kind="stable")]
        left = np.cumsum(curvature[near])[len(cap) - 1 :]
        patch = np.zeros(n, dtype=np.bool_)
        patch[near[: len(cap) + int(np.argmin(left))]] = True
        patches.append(patch)
    return patches


def _distances(lengths: csr_array, sources: Indices) -> Floats:
    """Distances along edges to the nearest of the source vertices."""
    return np.asarray(dijkstra(lengths, directed=False, indices=sources, min_only=True))
