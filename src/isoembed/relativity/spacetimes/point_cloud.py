"""Directions, distances and solid angles of surface points about a center."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull, QhullError

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import solid_angles
from isoembed.relativity.spacetimes.checks import numbers, written


def checked_points(points: ArrayLike) -> Floats:
    """Checked points (m, 3).  Raises `InvalidParameter`: they are too few or not finite."""
    x = numbers(points)
    if x.ndim != 2 or x.shape[1] != 3 or len(x) < 8:
        raise InvalidParameter(f"points must be an array (m, 3) with m >= 8, not {x.shape}")
    good = np.isfinite(x).all(axis=1)
    if not good.all():
        i = int(np.argmin(good))
        raise InvalidParameter(f"point {i} is {written(x[i])}: that is not finite")
    return x


def seen_from(x: Floats, center: Floats, faces: Indices | None = None) -> tuple[Floats, Floats, Floats]:
    """Directions (m, 3), distances and solid angles (m,) of points about a center.

    Raises `InvalidParameter`: a point coincides with the center, or the points do not surround it.

    Parameters
    ----------
    x : ndarray, shape (m, 3)
    center : ndarray, shape (3,)
    faces : ndarray of int, shape (F, 3), optional
        Convex hull of the directions, if already computed.
    """
    d = x - center
    r = np.linalg.norm(d, axis=1)
    if r.min() == 0.0:
        raise InvalidParameter(f"point {int(np.argmin(r))} is the center {written(center)} itself")
    u = d / r[:, None]
    return u, r, solid_angles(u, _hull(u) if faces is None else faces)


def _hull(u: Floats) -> Indices:
    """Triangles of the convex hull of directions.  Raises `InvalidParameter`: a half-space is empty."""
    apart = "the points do not surround the center: a half-space contains none"
    try:
        hull = ConvexHull(u)
    except QhullError:
        raise InvalidParameter(apart) from None
    if hull.equations[:, 3].max() >= 0.0:
        raise InvalidParameter(apart)
    return np.asarray(hull.simplices)
