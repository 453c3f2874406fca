"""Offset of simple polygons: sharp corners are cut off, and closed notches rejected."""

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.gluing.polygon import meeting_sides

REMEDY = "takes more sheets, another choice of cuts, a larger scale or a smaller offset"


def offset(outline: Floats, distances: ArrayLike, name: str, limit: float = np.inf) -> Floats:
    """Move the sides of a polygon outward, and intersect adjacent ones.

    If the result is simple and the directions of its sides are unchanged, it winds once around each enclosed
    point, and thus bounds the region within the distances.

    Parameters
    ----------
    outline : ndarray, shape (n, 2)
        Simple polygon, counterclockwise.
    distances : float or array_like, shape (n,)
        Distance of each side, negative inward.
    name : str
        Name of the polygon, for messages.
    limit : float
        A convex corner that would move farther than this multiple of the distance is cut off there,
        perpendicular to its bisector.

    Returns
    -------
    ndarray, shape (m, 2)
        Corners of the result; a corner that is cut off, or lies between collinear sides of different
        distances, is replaced by two.

    Raises
    ------
    InvalidParameter
        A side vanishes, or the outline intersects itself, as when a notch closes.
    """
    return moved_sides(outline, distances, name, limit)[0]


def moved_sides(
    outline: Floats, distances: ArrayLike, name: str, limit: float = np.inf
) -> tuple[Floats, Indices, Indices]:
    """Polygon of `offset`, and the start and end corner of each side in it, shape (n,) each."""
    n = len(outline)
    steps = np.roll(outline, -1, axis=0) - outline
    along = steps / np.hypot(*steps.T)[:, None]
    out = np.column_stack([along[:, 1], -along[:, 0]])
    moved = np.broadcast_to(np.asarray(distances, dtype=np.float64), n)
    points: list[Floats] = []
    begins, ends = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    for k in range(n):
        (d, e), (u, v), (a, b) = ((some[k - 1], some[k]) for some in (moved, out, along))
        turn = float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))
        if abs(turn) <= 1e-9:  # the sides are collinear
            found = [d * u] if d == e else [d * u, e * v]
        else:
            corner = (e * a - d * b) / np.sin(turn)
            found = [corner]
            if turn > 0 and min(d, e) > 0 and np.hypot(*corner) > (far := limit * max(d, e)):
                across = corner / np.hypot(*corner)
                found = [d * u + (far - d * (u @ across)) / (a @ across) * a]
                found += [e * v + (far - e * (v @ across)) / (b @ across) * b]
        ends[k - 1] = len(points)
        points += [outline[k] + shift for shift in found]
        begins[k] = len(points) - 1
    result = np.array(points)
    forward = ((result[ends] - result[begins]) * along).sum(axis=1) > 0
    if not forward.all():
        k = int(np.argmin(forward))
        notch = f", as in a notch; it {REMEDY}" if moved[k] > 0 else ""
        raise InvalidParameter(
            f"side {k} of {name} vanishes: an offset of {moved[k]:.4g} is too large{notch}"
        )
    size = float(np.ptp(result, axis=0).max())
    i, j = meeting_sides((result - result.min(axis=0)) / size)
    if i >= 0:
        side = [int(np.searchsorted(begins, m, side="right")) - 1 for m in (i, j)]
        raise InvalidParameter(
            f"an offset of {float(moved.max()):.4g} closes the notch of {name} between its sides "
            f"{min(side)} and {max(side)}: it {REMEDY}"
        )
    return result, begins, ends
