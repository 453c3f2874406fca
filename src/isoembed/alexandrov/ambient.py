"""Euclidean pyramids equivalent to those of hyperbolic and spherical space (projective model).

A point at distance r from the apex in direction u has ambient coordinates ``sn(r) u``: those of a Euclidean
pyramid with the same dihedral angles at its radii.  Coordinates about the apex are conformal,
``2 tn(r / 2) u``; on the sphere they cover all points but the antipode of the apex.
"""

import numpy as np

from isoembed.arrays import Floats
from isoembed.space import Space


def ambient_lengths(space: Space, lengths: Floats, a: Floats, b: Floats) -> Floats:
    """Euclidean distances between the ambient coordinates of points.

    Parameters
    ----------
    space : Space
    lengths : ndarray
        Distances of the points.
    a, b : ndarray
        Distances of the points from the apex.
    """
    if space.is_euclidean:
        return lengths
    chords, rise = space.chord(lengths), 2 * space.sn((a - b) / 2) * space.sn((a + b) / 2)
    return np.sqrt(np.maximum(chords * chords - space.curvature * rise * rise, 0.0))


def conformal_radii(space: Space, radii: Floats) -> Floats:
    """Conformal radii ``2 tn(r / 2)`` for distances r from the apex."""
    return 2 * space.sn(radii / 2) / space.cs(radii / 2)


def distances_from_apex(space: Space, about: Floats) -> Floats:
    """Distances from the apex of vertices in coordinates about it, shape (V, 3)."""
    sizes = np.linalg.norm(about, axis=1)
    if space.is_euclidean:
        return sizes
    y = space.root * sizes / 2
    return 2 * (np.arctan(y) if space.curvature > 0 else np.arctanh(y)) / space.root


def away_from_apex(space: Space, about: Floats) -> Floats:
    """Ambient coordinates about a center of the body, shape (V, 3), from coordinates about the apex.

    In Euclidean space they are unchanged.  On the sphere the center approximates that of the smallest
    enclosing ball, so that the body is in the hemisphere represented by ambient coordinates.
    """
    if space.is_euclidean:
        return about
    k = space.curvature
    part = k * np.einsum("ij,ij->i", about, about) / 4
    x, w = about / (1 + part)[:, None], (1 - part) / (1 + part)
    center, height = x.mean(axis=0), w.mean()
    for n in range(1, 200 if k > 0 else 0):  # each moves the center toward the farthest vertex
        size = np.sqrt(height * height + k * (center @ center))
        far = int(np.argmin(w * height + k * (x @ center)))
        center = (n * center / size + x[far]) / (n + 1)
        height = (n * height / size + w[far]) / (n + 1)
    size = np.sqrt(height * height + k * (center @ center))
    center, height = center / size, height / size
    return x - center * (w + k * (x @ center) / (1 + height))[:, None]
