"""Delaunay flips that leave a triangulation looking outward on a sphere of directions."""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.delaunay import (
    BLOCKED,
    FLIPPED,
    LEFT,
    attempts,
    flip_edges,
    is_delaunay,
    non_delaunay_edges,
)
from isoembed.intrinsic.flips import flip
from isoembed.intrinsic.halfedges import HalfEdges, edges_between, following, preceding
from isoembed.kernel import kernel


@kernel
def looks_outward(u: Floats, a: int, b: int, c: int) -> bool:
    """Whether three directions come counterclockwise, seen from outside."""
    volume = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        volume += u[a, k] * (u[b, i] * u[c, j] - u[b, j] * u[c, i])
    return volume > 0.0


class Outward(NamedTuple):
    """The rule of a Delaunay triangulation that looks outward.

    Attributes
    ----------
    u : ndarray, shape (V, 3)
    weights : ndarray, shape (V,)
        Zeros.
    flipped : ndarray of int64, shape (k + 1,)
        One half-edge of each edge that was flipped, and last how many these are.
    """

    u: Floats
    weights: Floats
    flipped: Indices


@attempts(Outward)
def _attempt(h: int, mesh: HalfEdges, rule: Outward) -> int:
    if is_delaunay(h, mesh, rule.weights):
        return LEFT
    corners, u, t = mesh.corners, rule.u, mesh.twins[h]
    into, other = preceding(h), preceding(t)
    i, j, k, m = corners[h], corners[t], corners[into], corners[other]
    if not (looks_outward(u, k, i, m) and looks_outward(u, m, j, k)):
        return BLOCKED
    if edges_between(into, m, corners, mesh.twins) > 0:
        return BLOCKED
    # the ends of a new edge at most 120 degrees apart
    if u[k, 0] * u[m, 0] + u[k, 1] * u[m, 1] + u[k, 2] * u[m, 2] < -0.5:
        return BLOCKED
    count = rule.flipped[-1]
    if count + 1 == rule.flipped.size or not flip(h, mesh, 1e-6):  # of height over longest side
        return BLOCKED
    rule.flipped[count] = following(h)
    rule.flipped[-1] += 1
    return FLIPPED


@kernel
def flip_to_delaunay(u: Floats, mesh: HalfEdges) -> Indices:
    """Flip edges until all are Delaunay whose flip leaves a triangulation that looks outward, in place.

    A new edge gets its length in the plane of its two triangles unfolded.

    Returns
    -------
    ndarray of int, shape (k,)
        One half-edge of each edge that was flipped, some more than once.
    """
    n = mesh.corners.size
    rule = Outward(u, np.zeros(n // 6 + 2), np.zeros(4 * n + 1, dtype=np.int64))
    flip_edges(non_delaunay_edges(mesh, rule.weights), mesh, rule)
    return rule.flipped[: rule.flipped[-1]].copy()
