"""Dents of a metric: patches that can be reflected without change of the lengths.

A plane that is tangent to a surface of revolution along a circle cuts off a patch; reflected in the plane, it
has the same metric and fits as smoothly as before, up to the sign of the curvature across the circle.  A dent
is such a patch: a cap with K > 0 and a ring with K < 0 around it.  The circle is the outer boundary of the
ring, and as its normals are parallel, the total curvature of the patch vanishes.  It nearly does on surfaces
that have no symmetry.
"""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.components import connected_parts
from isoembed.metric.curvature import deficits, face_areas, negative_deficits
from isoembed.metric.polyhedral import PolyhedralMetric

MIN_PATCH = 4  # vertices: smaller patches are for the search for nearby realizations


def dents(metric: PolyhedralMetric) -> list[Mask]:
    """Patches that are dents, or the reflections of dents.

    Parameters
    ----------
    metric : PolyhedralMetric

    Returns
    -------
    list of ndarray of bool, shape (V,)
        The vertices inside of the rim of each, no vertex in two of them; the patch with the most curvature
        on its cap comes first.

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
    # Gaps of an edge or two in the rings are closed: about irregular triangles deficits are noisy.
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
            plain = np.flatnonzero(totals > 0.3 * totals.max())  # caps of less curvature are noise
        else:  # it may be one that has grown together with something else, such as a horn
            plain = np.flatnonzero([len(cap) >= MIN_PATCH for cap in caps])
            if not 1 < len(plain) <= 3:  # rough bodies have more caps
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
    # caps of less curvature, in radians, are noise
    return [patch for cap, patch in found if cap > 3e-3 and patch.sum() >= MIN_PATCH]


def _vanishes(total: float, caps: float) -> bool:
    """Whether a patch has the total curvature of a dent, given that of its caps."""
    least, most = np.multiply((-0.5, 0.2), caps)  # of a ring with its caps, over that of the caps
    return bool(least <= total <= most)


def _grown(adjacency: csr_array, mask: Mask) -> Mask:
    """The vertices and their neighbors."""
    return mask | (adjacency @ mask.astype(np.float64) > 0)


def _shared(metric: PolyhedralMetric, region: Mask, caps: list[Indices]) -> list[Mask]:
    """Rings that have grown together, shared among their caps.

    A vertex is with the nearest cap, and as far away from it as makes the total curvature least.
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
    """Distances along edges from the nearest of some vertices."""
    return np.asarray(dijkstra(lengths, directed=False, indices=sources, min_only=True))
