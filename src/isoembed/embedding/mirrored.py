"""Mirror-image patches of two surfaces with the same lengths: bumps of one, dents of the other."""

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.mesh.components import connected_parts
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric


def mirrored_caps(
    triangulation: Triangulation, deficits: Floats, first: Floats, second: Floats
) -> list[Indices]:
    """Connected sets of vertices with K > 0 where two surfaces with the same lengths bend oppositely.

    Parameters
    ----------
    triangulation : Triangulation
    deficits : ndarray, shape (V,)
        Deficits; where positive, both principal curvatures have the sign of the mean curvature.
    first, second : ndarray, shape (V,)
        Mean curvatures of the two surfaces.

    Returns
    -------
    list of ndarray of int
        Vertices of each cap: the center of a bump or a dent, inside the ring with K < 0.
    """
    opposite = (deficits > 0) & (np.sign(first) * np.sign(second) < 0)
    caps = connected_parts(triangulation.adjacency, opposite)
    return [cap for cap in caps if len(cap) >= 3]  # smaller sets are inverted vertices


def mirrored_dents(metric: PolyhedralMetric, first: Floats, second: Floats) -> int:
    """Number of dents of one realization that are bumps of another, by their mean curvatures, (V,)."""
    return len(mirrored_caps(metric.triangulation, deficits(metric.normalized), first, second))
