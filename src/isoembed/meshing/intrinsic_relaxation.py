"""Angles and edge lengths for the relaxation of triangles on the sphere toward equal sides in a metric.

The half-edge tables are those of `isoembed.intrinsic.halfedges`.  Vertices also have directions u (V, 3) on
the unit sphere, in which every triangle is oriented outward.
"""

import numpy as np

from isoembed.arrays import Floats
from isoembed.intrinsic.halfedges import HalfEdges


def angles_from_lengths(lengths: Floats) -> Floats:
    """Angles (F, 3) in radians, 0 and pi if the lengths form no triangle: `angle_between` for arrays."""
    sides = lengths.reshape(-1, 3)
    third, s = np.roll(sides, 1, axis=1), np.roll(sides, -1, axis=1)
    a, b = np.maximum(sides, third), np.minimum(sides, third)
    mu = np.where(b >= s, s - (a - b), b - (a - s))
    sine, cosine = (a - b + s) * mu, (a + (b + s)) * np.maximum(a - s + b, 0.0)
    return np.asarray(2 * np.arctan2(np.sqrt(np.maximum(sine, 0.0)), np.sqrt(cosine)))


def end_lengths(u: Floats, q: Floats, mesh: HalfEdges) -> None:
    """Measure all half-edges by the mean of the metric tensors q (V, 3, 3) at their ends, in place.

    The lengths are second-order accurate, and exact on round spheres.
    """
    corners, twins, lengths = mesh.corners, mesh.twins, mesh.lengths
    lower = np.flatnonzero(np.arange(twins.size) < twins)
    upper = twins[lower]
    i, j = corners[lower], corners[upper]
    chords = u[j] - u[i]
    half = 0.5 * np.sqrt((chords**2).sum(axis=1))
    squares = 0.5 * np.einsum("ha,hab,hb->h", chords, q[i] + q[j], chords)
    # The tangential component of the chord is the sine of the arc.
    with np.errstate(divide="ignore", invalid="ignore"):  # coincident or antipodal vertices
        lengths[lower] = np.sqrt(squares) * np.arcsin(half) / (half * np.sqrt(1.0 - half**2))
    lengths[upper] = lengths[lower]
